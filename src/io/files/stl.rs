//! STL, binary and ASCII.
//!
//! Binary files are read by stl_io, after their length has been checked. ASCII files are read here: stl_io rounds their numbers
//! to single precision, which bends a part that was drawn far from the origin, and nobody can give the digits back. A ball
//! of 5 mm, 1 km away, has corners up to 0.035 mm off (`cargo test --test io far_from_the_origin -- --nocapture`). It also
//! ends at the first solid, knows keywords in lower case only, and refuses normals that are no numbers.

use super::FileError;
use super::surface_file::Soup;
use super::text_lines::{TextFile, words};
use nalgebra::Vector3;
use std::io::Cursor;
use std::path::Path;

/// Bytes of the header of a binary file, which says nothing.
const HEADER: usize = 80;

/// Bytes before the first triangle of a binary file: the header, and the number of triangles.
const PREFIX: usize = HEADER + 4;

/// Bytes of a triangle in a binary file: its normal, three corners, and two bytes more.
const RECORD: usize = 50;

pub(super) fn read(path: &Path, bytes: Vec<u8>) -> Result<Soup, FileError> {
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

/// Whether the file is ASCII: it begins with the word "solid". The header of a binary file may begin so too, but then the file
/// has the length that it announces, or has bytes of zero: each triangle ends with two of them, unless a color is given.
fn is_text(bytes: &[u8]) -> bool {
    let begins = words(bytes)
        .next()
        .is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    let fits = announced(bytes).is_some_and(|count| records_in(bytes) == (count, 0));
    begins && !fits && !bytes.contains(&0)
}

/// The number of triangles that a binary file says it has.
fn announced(bytes: &[u8]) -> Option<usize> {
    let count = bytes.get(HEADER..)?.first_chunk()?;
    usize::try_from(u32::from_le_bytes(*count)).ok()
}

/// How many triangles a binary file has room for, and how many bytes are left over.
fn records_in(bytes: &[u8]) -> (usize, usize) {
    let length = bytes.len().saturating_sub(PREFIX);
    (length / RECORD, length % RECORD)
}

/// Checks that a binary file has the length of as many triangles as it says it has.
fn check_length(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    let path = path.into();
    let Some(count) = announced(bytes) else {
        return Err(FileError::TooShort {
            path,
            part: "header".into(),
            found: bytes.len(),
            expected: PREFIX,
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
        let offset = PREFIX + count * RECORD;
        return Err(FileError::Unread {
            path,
            offset,
            found: super::stopped::beginning(&bytes[offset..]),
        });
    }
    Ok(())
}

/// The triangles of a binary file. The first byte of its header, which says nothing, becomes the end of a line: stl_io takes a
/// file whose first line begins with "solid " for text.
fn read_binary(mut bytes: Vec<u8>) -> std::io::Result<Soup> {
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

/// The words that a line can begin with, in lower case.
type Expected = &'static [&'static str];

/// What has been read of an ASCII file.
struct Reader {
    /// What the next line has to begin with.
    expected: Expected,
    /// The corners so far of the triangle that is being read.
    corners: Vec<Vector3<f64>>,
    triangles: Soup,
}

fn read_text(file: TextFile<'_>) -> Result<Soup, FileError> {
    let mut reader = Reader {
        expected: &["solid"],
        corners: Vec::new(),
        triangles: Soup::new(),
    };
    for line in file.lines() {
        reader.read_line(file, line)?;
    }
    if reader.expected == ["solid"] {
        return Ok(reader.triangles);
    }
    let end = &file.bytes[file.bytes.len()..];
    Err(file.stopped(end, format!("one of {:?} was expected", reader.expected)))
}

impl Reader {
    fn read_line(&mut self, file: TextFile<'_>, line: &[u8]) -> Result<(), FileError> {
        let mut words = words(line);
        let Some(first) = words.next() else {
            return Ok(());
        };
        let is_first = |word: &&&str| first.eq_ignore_ascii_case(word.as_bytes());
        let Some(word) = self.expected.iter().find(is_first) else {
            let cause = format!("one of {:?} was expected", self.expected);
            return Err(file.stopped(line, cause));
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
