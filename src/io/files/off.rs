//! Reader of OFF files (Object File Format of Geomview), in text: vertices and faces. Colors, normals and texture coordinates are
//! ignored.

use super::FileError;
use super::polygons::add_polygon;
use super::text_lines::{TextFile, number, words};
use crate::mesh::TriangleSoup;
use std::path::Path;

/// Header words of files with three coordinates per vertex, perhaps followed by further numbers.
const HEADERS: [&[u8]; 6] = [b"OFF", b"COFF", b"NOFF", b"CNOFF", b"STOFF", b"STCNOFF"];

pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<TriangleSoup, FileError> {
    let file = TextFile {
        path,
        format: "OFF",
        bytes,
    };
    let without_comment = |line: &'_ [u8]| line.split(|&byte| byte == b'#').next().map(<[u8]>::len);
    let mut lines = file
        .lines()
        .map(|line| &line[..without_comment(line).unwrap_or(0)])
        .filter(|line| words(line).next().is_some());
    let end = &bytes[bytes.len()..];
    let mut next = |expected: &str| {
        lines
            .next()
            .ok_or_else(|| file.syntax_error(end, format!("expected {expected}")))
    };
    let mut line = next("the word OFF")?;
    // The counts follow in the same word, on the same line or on the next one.
    let after_header = |header: &&[u8]| {
        let rest = line.trim_ascii_start().strip_prefix(*header)?;
        let is_end = |byte: &u8| byte.is_ascii_whitespace() || byte.is_ascii_digit();
        rest.first().is_none_or(is_end).then_some(rest)
    };
    let Some(rest) = HEADERS.iter().find_map(after_header) else {
        return Err(file.syntax_error(line, "expected the word OFF"));
    };
    let mut first = words(rest).peekable();
    let counts: Vec<&[u8]> = if first.peek().is_some() {
        first.collect()
    } else {
        line = next("the numbers of vertices and faces")?;
        words(line).collect()
    };
    let count = |index: usize| counts.get(index).and_then(|word| number::<usize>(word));
    let [Some(vertex_count), Some(face_count)] = [count(0), count(1)] else {
        return Err(file.syntax_error(line, "expected the numbers of vertices and faces"));
    };
    let mut soup = TriangleSoup::default();
    for _ in 0..vertex_count {
        let line = next("a vertex")?;
        soup.vertices.push(file.coordinates(line, words(line))?);
    }
    for _ in 0..face_count {
        let line = next("a face")?;
        let corners = face(line, vertex_count).ok_or_else(|| {
            let cause =
                format!("expected the number of corners and their indices below {vertex_count}");
            file.syntax_error(line, cause)
        })?;
        add_polygon(&mut soup, &corners).map_err(|cause| file.syntax_error(line, cause))?;
    }
    Ok(soup)
}

/// Corners of a face, or `None` if there are too few, or an index is out of range.
fn face(line: &[u8], vertex_count: usize) -> Option<Vec<usize>> {
    let mut numbers = words(line);
    let corner_count: usize = number(numbers.next()?)?;
    let corners = numbers.by_ref().take(corner_count).map(number::<usize>);
    let corners: Vec<usize> = corners.collect::<Option<_>>()?;
    let is_valid = corners.len() == corner_count && corners.iter().all(|&v| v < vertex_count);
    is_valid.then_some(corners)
}
