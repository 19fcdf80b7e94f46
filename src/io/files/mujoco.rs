//! Reader of binary meshes of MuJoCo (`.msh`): positions and triangles. Normals and texture coordinates are skipped.
//!
//! The file consists of words of 4 bytes, little-endian. The first 4 words are the numbers of positions, normals, texture coordinates and
//! triangles. The data follow in this order: coordinates in single precision, and vertex indices as integers. The format has no signature,
//! so the length of the file identifies it.

use super::FileError;
use crate::mesh::TriangleSoup;
use nalgebra::Vector3;
use std::path::Path;

type Word = [u8; 4];

/// Number of words of the header.
const HEADER: usize = 4;

/// Number of words of a position, a normal, a pair of texture coordinates and a triangle.
const WORD_COUNTS: [u64; HEADER] = [3, 3, 2, 3];

pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<TriangleSoup, FileError> {
    soup(bytes).map_err(|cause| FileError::syntax(path, "MuJoCo .msh", cause))
}

/// Returns true if the bytes have the length that their header states.
pub(super) fn has_stated_length(bytes: &[u8]) -> bool {
    header(bytes).is_some_and(|header| stated_length(header) == bytes.len() as u64)
}

/// Numbers of positions, normals, texture coordinates and triangles. Returns `None` if the file is too short.
fn header(bytes: &[u8]) -> Option<[u32; HEADER]> {
    let words = bytes.as_chunks().0.first_chunk::<HEADER>()?;
    Some(words.map(u32::from_le_bytes))
}

/// Length of a file (bytes) with this header.
fn stated_length(header: [u32; HEADER]) -> u64 {
    let words = header.into_iter().zip(WORD_COUNTS);
    let words = words.map(|(count, size)| u64::from(count) * size);
    4 * (HEADER as u64 + words.sum::<u64>())
}

fn soup(bytes: &[u8]) -> Result<TriangleSoup, String> {
    let length = bytes.len();
    let Some(header) = header(bytes) else {
        return Err(format!(
            "the header needs 16 bytes, but the file has {length}"
        ));
    };
    let [position_count, normal_count, texture_count, triangle_count] = header;
    if !has_stated_length(bytes) {
        return Err(format!(
            "the header states {position_count} positions, {normal_count} normals, {texture_count} texture coordinates and \
             {triangle_count} triangles in {} bytes, but the file has {length} bytes",
            stated_length(header)
        ));
    }
    let words = &bytes.as_chunks().0[HEADER..];
    let (positions, _) = words.split_at(3 * position_count as usize);
    let (_, corners) = words.split_at(words.len() - 3 * triangle_count as usize);
    let corners = triples(corners).map(|corners| triangle(corners, position_count));
    Ok(TriangleSoup {
        vertices: triples(positions).map(position).collect::<Result<_, _>>()?,
        triangles: corners.collect::<Result<_, _>>()?,
    })
}

/// Groups of three words, preceded by their indices.
fn triples(words: &[Word]) -> impl Iterator<Item = (usize, [Word; 3])> {
    words.as_chunks().0.iter().copied().enumerate()
}

fn position((vertex, words): (usize, [Word; 3])) -> Result<Vector3<f64>, String> {
    let position = Vector3::from(words.map(|word| f64::from(f32::from_le_bytes(word))));
    match position.iter().find(|coordinate| !coordinate.is_finite()) {
        Some(value) => Err(format!(
            "vertex {vertex} has the coordinate {value}, but coordinates must be finite"
        )),
        None => Ok(position),
    }
}

fn triangle(
    (triangle, words): (usize, [Word; 3]),
    vertex_count: u32,
) -> Result<[usize; 3], String> {
    let corners = words.map(u32::from_le_bytes);
    match corners.iter().find(|&&vertex| vertex >= vertex_count) {
        Some(vertex) => Err(format!(
            "triangle {triangle} refers to vertex {}, but the file has {vertex_count} vertices",
            vertex.cast_signed()
        )),
        None => Ok(corners.map(|vertex| vertex as usize)),
    }
}
