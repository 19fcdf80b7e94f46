//! Wavefront OBJ: vertices and faces, without anything that is only looked at.
//!
//! It is read here, since the crates that read it (tobj, wobj, obj-rs, mesh-loader) round coordinates to single precision,
//! which bends a part that was drawn far from the origin, as in `stl.rs`. tobj has double precision too, but by a feature that
//! changes the type of its public fields, and cargo turns that on for all crates of a program: other users of tobj, such as
//! Rerun's viewer, would not compile beside this library. It also takes polylines for faces and refuses colors of only some
//! vertices. wavefront_obj has double precision, but cuts every face as if it were convex, and does not tell which triangles
//! were one face.

use super::FileError;
use super::surface_file::Soup;
use super::text_lines::{TextFile, number, words};
use nalgebra::Vector3;
use std::path::Path;

/// How many corners of a face are tried, at most, as the one that all its triangles have in common: each try takes a time in
/// proportion to the number of corners.
const TRIED: usize = 64;

/// Why a face is refused.
const NO_FAN: &str = "triangles from no corner fill this face: it is not flat, or bent so that it has to be cut into \
                      triangles beforehand";

pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<Soup, FileError> {
    let format = "OBJ";
    let file = TextFile {
        path,
        format,
        bytes,
    };
    let vertices = vertices(file)?;
    let (mut triangles, mut defined) = (Soup::new(), 0);
    for line in file.lines() {
        let mut words = words(line);
        match words.next() {
            Some(b"v") => defined += 1,
            Some(b"f") => {
                let corners = words.map(|word| {
                    let index = vertex_index(word, defined, vertices.len());
                    let cause = || unknown_vertex(word, vertices.len());
                    index.ok_or_else(|| file.stopped(line, cause()))
                });
                let corners = corners.map(|index| Ok(vertices[index?]));
                let corners: Vec<Vector3<f64>> = corners.collect::<Result<_, FileError>>()?;
                add_face(&corners, &mut triangles).map_err(|cause| file.stopped(line, cause))?;
            }
            _ => {}
        }
    }
    Ok(triangles)
}

/// The vertices of the file. Faces may come before theirs.
fn vertices(file: TextFile<'_>) -> Result<Vec<Vector3<f64>>, FileError> {
    let mut vertices = Vec::new();
    for line in file.lines() {
        let mut words = words(line);
        if words.next() == Some(b"v") {
            vertices.push(file.coordinates(line, words)?);
        }
    }
    Ok(vertices)
}

/// The index of the vertex that a corner of a face names, if there is one: counted from 1, or, if negative, back from the last
/// one `defined` so far. What follows after a slash are its texture and normal.
fn vertex_index(word: &[u8], defined: usize, vertex_count: usize) -> Option<usize> {
    let name: isize = number(word.split(|&byte| byte == b'/').next()?)?;
    let index = if name < 0 {
        defined.checked_add_signed(name)?
    } else {
        usize::try_from(name).ok()?.checked_sub(1)?
    };
    (index < vertex_count).then_some(index)
}

fn unknown_vertex(word: &[u8], vertex_count: usize) -> String {
    let word = super::stopped::beginning(word);
    format!("{word:?} names none of the {vertex_count} vertices")
}

/// Adds the triangles of a face, or says why there are none.
fn add_face(corners: &[Vector3<f64>], triangles: &mut Soup) -> Result<(), &'static str> {
    match *corners {
        [] | [_] | [_, _] => Err("a face has three corners or more"),
        [a, b, c] => {
            triangles.push([a, b, c]);
            Ok(())
        }
        _ => {
            let normal = normal(corners);
            let apexes = 0..corners.len().min(TRIED);
            let apex = { apexes }
                .find(|&apex| fan(corners, apex).all(|triangle| runs_about(&normal, triangle)));
            let apex = apex.ok_or(NO_FAN)?;
            triangles.extend(fan(corners, apex));
            Ok(())
        }
    }
}

/// The triangles of a face between one of its corners and the edges that do not end there.
fn fan(corners: &[Vector3<f64>], apex: usize) -> impl Iterator<Item = [Vector3<f64>; 3]> {
    let corner = move |step: usize| corners[(apex + step) % corners.len()];
    (1..corners.len() - 1).map(move |step| [corner(0), corner(step), corner(step + 1)])
}

/// The normal of a face, of twice its area (in the file's unit squared) as length.
fn normal(corners: &[Vector3<f64>]) -> Vector3<f64> {
    fan(corners, 0)
        .map(|[a, b, c]| (b - a).cross(&(c - a)))
        .sum()
}

/// Whether a triangle turns the same way as a face with this normal.
fn runs_about(normal: &Vector3<f64>, [a, b, c]: [Vector3<f64>; 3]) -> bool {
    (b - a).cross(&(c - a)).dot(normal) > 0.0
}
