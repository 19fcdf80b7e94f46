//! STL, binary and ASCII.

use super::FileError;
use super::surface_file::Soup;
use super::text_lines::{TextFile, words};
use nalgebra::Vector3;
use std::path::Path;

/// Bytes before the number of triangles in a binary file, and with it.
const HEADER: usize = 80;
const PREFIX: usize = HEADER + 4;

/// Bytes of a triangle in a binary file: its normal, three corners, and two bytes more.
const RECORD: usize = 50;
const NORMAL: usize = 12;
const CORNER: usize = 12;

pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<Soup, FileError> {
    if is_text(bytes) {
        let format = "ASCII STL";
        let file = TextFile {
            path,
            format,
            bytes,
        };
        return read_text(file);
    }
    read_binary(path, bytes)
}

/// Whether the file is ASCII. The header of a binary file may begin with the same word, but then the length is right, or there
/// are zeros: each triangle has two, if its colour is not given.
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

/// How many triangles there is room for in a binary file, and what is left over.
fn records_in(bytes: &[u8]) -> (usize, usize) {
    let length = bytes.len().saturating_sub(PREFIX);
    (length / RECORD, length % RECORD)
}

fn read_binary(path: &Path, bytes: &[u8]) -> Result<Soup, FileError> {
    let Some(count) = announced(bytes) else {
        return Err(FileError::TooShort {
            path: path.into(),
            part: "header".into(),
            found: bytes.len(),
            expected: PREFIX,
        });
    };
    let (limit, rest) = records_in(bytes);
    if count > limit {
        return Err(FileError::TooLong {
            path: path.into(),
            part: "list of triangles".into(),
            found: count,
            limit,
        });
    }
    if count < limit || rest > 0 {
        let offset = PREFIX + count * RECORD;
        return Err(FileError::Unread {
            path: path.into(),
            offset,
            found: super::stopped::beginning(&bytes[offset..]),
        });
    }
    let records = bytes[PREFIX..].chunks_exact(RECORD);
    let triangles = records.map(|record| std::array::from_fn(|corner| position(record, corner)));
    Ok(triangles.collect())
}

/// A corner of a triangle.
fn position(record: &[u8], corner: usize) -> Vector3<f64> {
    let numbers = &record[NORMAL + corner * CORNER..];
    Vector3::from_fn(|axis, _| {
        let bytes = numbers[4 * axis..].first_chunk().copied();
        f64::from(f32::from_le_bytes(bytes.unwrap_or_default()))
    })
}

/// The words that a line can begin with, in lower case.
type Expected = &'static [&'static str];

/// What has been read of an ASCII file.
struct Reader {
    expected: Expected,
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
