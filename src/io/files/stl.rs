//! Reader of binary and ASCII STL files.
//!
//! The crate stl_io reads binary files after this module has checked their length. This module reads ASCII files itself, because
//! stl_io rounds their numbers to single precision, which deforms a part that was drawn far from the origin. A ball of 5 mm at a
//! distance of 1 km has corners up to 0.035 mm off (`cargo test --test io far_from_the_origin -- --nocapture`). stl_io also stops
//! after the first solid, accepts keywords in lower case only, and rejects normals that are not numbers.

use super::FileError;
use super::syntax_error::excerpt;
use super::text_lines::{TextFile, words};
use super::triangle_soup::TriangleSoup;
use nalgebra::Vector3;
use std::io::Cursor;
use std::path::Path;

/// Size of the header of a binary file (bytes). Its content has no meaning.
const HEADER_SIZE: usize = 80;

/// Size of the header and the triangle count of a binary file (bytes).
const PREFIX_SIZE: usize = HEADER_SIZE + 4;

/// Size of a triangle in a binary file (bytes): the normal, three corners, and two further bytes.
const RECORD_SIZE: usize = 50;

pub(super) fn read(path: &Path, bytes: Vec<u8>) -> Result<TriangleSoup, FileError> {
    if is_text(&bytes) {
        return read_text(TextFile {
            path,
            format: "ASCII STL",
            bytes: &bytes,
        });
    }
    check_length(path, &bytes)?;
    read_binary(bytes).map_err(|source| FileError::Syntax {
        path: path.into(),
        format: "binary STL",
        source: source.into(),
    })
}

/// Whether the file is ASCII.
///
/// An ASCII file begins with the word "solid". The header of a binary file may begin with it too. In this case the length of the
/// file matches its triangle count, or the file contains zero bytes, because each triangle without a color ends with two of them.
fn is_text(bytes: &[u8]) -> bool {
    let begins_with_solid = words(bytes)
        .next()
        .is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    let is_binary_length = stated_count(bytes).is_some_and(|count| records_in(bytes) == (count, 0));
    begins_with_solid && !is_binary_length && !bytes.contains(&0)
}

/// Triangle count in the header of a binary file, or `None` if the file is too short.
fn stated_count(bytes: &[u8]) -> Option<usize> {
    let count = bytes.get(HEADER_SIZE..)?.first_chunk()?;
    usize::try_from(u32::from_le_bytes(*count)).ok()
}

/// Number of whole triangles in a binary file, and number of remaining bytes.
fn records_in(bytes: &[u8]) -> (usize, usize) {
    let length = bytes.len().saturating_sub(PREFIX_SIZE);
    (length / RECORD_SIZE, length % RECORD_SIZE)
}

/// Checks that the length of a binary file matches its triangle count.
fn check_length(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    let path = path.into();
    let Some(count) = stated_count(bytes) else {
        return Err(FileError::TooShort {
            path,
            part: "header".into(),
            found: bytes.len(),
            expected: PREFIX_SIZE,
        });
    };
    let (limit, rest) = records_in(bytes);
    if count > limit {
        return Err(FileError::TooLong {
            path,
            part: "list of triangles".into(),
            found: count,
            limit,
        });
    }
    if count < limit || rest > 0 {
        let offset = PREFIX_SIZE + count * RECORD_SIZE;
        return Err(FileError::Unread {
            path,
            offset,
            found: excerpt(&bytes[offset..]),
        });
    }
    Ok(())
}

/// Triangles of a binary file. Overwrites the first byte of the header with a line feed, because stl_io reads a file as text if its
/// first line begins with "solid ".
fn read_binary(mut bytes: Vec<u8>) -> std::io::Result<TriangleSoup> {
    if let Some(first) = bytes.first_mut() {
        *first = b'\n';
    }
    let mut file = Cursor::new(bytes);
    let triangles = stl_io::create_stl_reader(&mut file)?;
    let position = |vertex: stl_io::Vertex| Vector3::from(vertex.0).cast();
    triangles
        .map(|triangle| Ok(triangle?.vertices.map(position)))
        .collect()
}

/// Keywords, in lower case.
type Keywords = &'static [&'static str];

/// State of the reader of an ASCII file.
struct Reader {
    /// Keywords that the next line can begin with.
    expected: Keywords,
    /// Corners of the incomplete triangle.
    corners: Vec<Vector3<f64>>,
    triangles: TriangleSoup,
}

fn read_text(file: TextFile<'_>) -> Result<TriangleSoup, FileError> {
    let mut reader = Reader {
        expected: &["solid"],
        corners: Vec::new(),
        triangles: TriangleSoup::new(),
    };
    for line in file.lines() {
        reader.read_line(file, line)?;
    }
    if reader.expected == ["solid"] {
        return Ok(reader.triangles);
    }
    let end = &file.bytes[file.bytes.len()..];
    Err(file.syntax_error(end, format!("expected one of {:?}", reader.expected)))
}

impl Reader {
    fn read_line(&mut self, file: TextFile<'_>, line: &[u8]) -> Result<(), FileError> {
        let mut words = words(line);
        let Some(first) = words.next() else {
            return Ok(());
        };
        let is_first = |word: &&&str| first.eq_ignore_ascii_case(word.as_bytes());
        let Some(word) = self.expected.iter().find(is_first) else {
            let cause = format!("expected one of {:?}", self.expected);
            return Err(file.syntax_error(line, cause));
        };
        if *word == "vertex" {
            self.corners.push(file.coordinates(line, words)?);
        }
        self.expected = match *word {
            "solid" | "endfacet" => &["facet", "endsolid"],
            "facet" => &["outer"],
            "outer" => &["vertex"],
            "vertex" if self.corners.len() < 3 => &["vertex"],
            "vertex" => &["endloop"],
            "endloop" => &["endfacet"],
            _ => &["solid"],
        };
        if let [a, b, c] = self.corners[..] {
            self.triangles.push([a, b, c]);
            self.corners.clear();
        }
        Ok(())
    }
}
