//! Reader of Wavefront OBJ files: vertices and faces. Texture coordinates, normals and materials are ignored.
//!
//! No existing crate fits:
//!
//! - tobj, wobj, obj-rs and mesh-loader round coordinates to single precision, which deforms a part that was drawn far from the
//!   origin (see `stl.rs`).
//! - tobj has a feature for double precision, but the feature changes the type of public fields. cargo enables it for all crates
//!   of a program, so other users of tobj, such as the viewer of Rerun, would not compile together with this library. tobj also
//!   reads polylines as faces, and rejects files with colors on some vertices only.
//! - wavefront_obj has double precision, but triangulates every face as if it were convex, and does not report which triangles
//!   belong to a face.

use super::FileError;
use super::syntax_error::excerpt;
use super::text_lines::{TextFile, number, words};
use super::triangle_soup::TriangleSoup;
use nalgebra::Vector3;
use std::path::Path;

/// Maximum number of corners that are tried as the apex of a fan. The time for each attempt is
/// proportional to the number of corners.
const MAX_APEX_COUNT: usize = 64;

/// Cause of the error for a face that cannot be triangulated as a fan.
const NO_FAN: &str = "no corner of this face is connected to all others by diagonals within it: the face is not flat, or must be \
                      cut into triangles beforehand";

pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<TriangleSoup, FileError> {
    let format = "OBJ";
    let file = TextFile {
        path,
        format,
        bytes,
    };
    let vertices = vertices(file)?;
    let (mut triangles, mut vertex_count) = (TriangleSoup::new(), 0);
    for line in file.lines() {
        let mut words = words(line);
        match words.next() {
            Some(b"v") => vertex_count += 1,
            Some(b"f") => {
                let corners = words.map(|word| {
                    let index = vertex_index(word, vertex_count, vertices.len());
                    let cause = || unknown_vertex(word, vertices.len());
                    index.ok_or_else(|| file.syntax_error(line, cause()))
                });
                let corners = corners.map(|index| Ok(vertices[index?]));
                let corners: Vec<Vector3<f64>> = corners.collect::<Result<_, FileError>>()?;
                add_face(&corners, &mut triangles)
                    .map_err(|cause| file.syntax_error(line, cause))?;
            }
            _ => {}
        }
    }
    Ok(triangles)
}

/// Vertices of the file. They are read before the faces, because a face may precede its vertices.
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

/// Index of the vertex of a corner of a face, or `None` if it is out of range.
///
/// A positive number in the file counts from 1. A negative number counts back from the last of the `preceding` vertices. Indices of
/// texture coordinates and normals may follow after slashes.
fn vertex_index(word: &[u8], preceding: usize, vertex_count: usize) -> Option<usize> {
    let signed: isize = number(word.split(|&byte| byte == b'/').next()?)?;
    let index = if signed < 0 {
        preceding.checked_add_signed(signed)?
    } else {
        usize::try_from(signed).ok()?.checked_sub(1)?
    };
    (index < vertex_count).then_some(index)
}

fn unknown_vertex(word: &[u8], vertex_count: usize) -> String {
    let word = excerpt(word);
    format!("{word:?} is not the index of one of the {vertex_count} vertices")
}

/// Appends the triangles of a face.
///
/// # Errors
/// The cause, if the face has fewer than 3 corners or cannot be triangulated as a fan.
fn add_face(corners: &[Vector3<f64>], triangles: &mut TriangleSoup) -> Result<(), &'static str> {
    match *corners {
        [] | [_] | [_, _] => Err("a face must have at least three corners"),
        [a, b, c] => {
            triangles.push([a, b, c]);
            Ok(())
        }
        _ => {
            let normal = normal(corners);
            let apexes = 0..corners.len().min(MAX_APEX_COUNT);
            let apex = { apexes }.find(|&apex| {
                fan(corners, apex).all(|triangle| is_counterclockwise(&normal, triangle))
            });
            let apex = apex.ok_or(NO_FAN)?;
            triangles.extend(fan(corners, apex));
            Ok(())
        }
    }
}

/// Triangles of a face, as a fan around one of its corners.
fn fan(corners: &[Vector3<f64>], apex: usize) -> impl Iterator<Item = [Vector3<f64>; 3]> {
    let corner = move |step: usize| corners[(apex + step) % corners.len()];
    (1..corners.len() - 1).map(move |step| [corner(0), corner(step), corner(step + 1)])
}

/// Normal of a face. Its length is twice the area (in the squared unit of the file).
fn normal(corners: &[Vector3<f64>]) -> Vector3<f64> {
    fan(corners, 0)
        .map(|[a, b, c]| (b - a).cross(&(c - a)))
        .sum()
}

/// Whether a triangle is counterclockwise seen against a normal.
fn is_counterclockwise(normal: &Vector3<f64>, [a, b, c]: [Vector3<f64>; 3]) -> bool {
    (b - a).cross(&(c - a)).dot(normal) > 0.0
}
