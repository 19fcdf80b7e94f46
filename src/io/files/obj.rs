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
use super::polygons::add_polygon;
use super::text_lines::{TextFile, excerpt, number};
use crate::mesh::TriangleSoup;
use nalgebra::Vector3;
use std::path::Path;

pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<TriangleSoup, FileError> {
    let format = "OBJ";
    let file = TextFile {
        path,
        format,
        bytes,
    };
    let mut soup = TriangleSoup {
        vertices: vertices(file)?,
        triangles: Vec::new(),
    };
    let mut vertex_count = 0;
    for line in statements(bytes) {
        let mut words = words(line);
        match words.next() {
            Some(b"v") => vertex_count += 1,
            Some(b"f") => {
                let corners = words.map(|word| {
                    let index = vertex_index(word, vertex_count, soup.vertices.len());
                    let cause = || unknown_vertex(word, soup.vertices.len());
                    index.ok_or_else(|| file.syntax_error(line, cause()))
                });
                let corners: Vec<usize> = corners.collect::<Result<_, FileError>>()?;
                add_polygon(&mut soup, &corners).map_err(|cause| file.syntax_error(line, cause))?;
            }
            _ => {}
        }
    }
    Ok(soup)
}

/// Lines of the file. A backslash before the line feed joins a line to the next one, except in a comment.
fn statements(bytes: &[u8]) -> impl Iterator<Item = &[u8]> {
    let (mut previous, mut is_comment) = (b'\n', false);
    bytes.split_inclusive(move |&byte| {
        is_comment |= byte == b'#';
        let is_end = byte == b'\n' && (is_comment || previous != b'\\');
        is_comment &= !is_end;
        // Windows puts a carriage return before the line feed.
        previous = if byte == b'\r' { previous } else { byte };
        is_end
    })
}

fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    let words = line.split(|&byte| byte.is_ascii_whitespace() || byte == b'\\');
    words
        .filter(|word| !word.is_empty())
        .take_while(|word| word[0] != b'#')
}

/// Vertices of the file. They are read before the faces, because a face may precede its vertices.
fn vertices(file: TextFile<'_>) -> Result<Vec<Vector3<f64>>, FileError> {
    let mut vertices = Vec::new();
    for line in statements(file.bytes) {
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
