//! Reader of Gmsh files: versions 1, 2, 4.0 and 4.1, ASCII or binary.

use super::cursor::Cursor;
use super::file_contents::{Cell, FileContents};
use super::scalar::{ByteOrder, Scalar};
use super::{FileError, mujoco, text_lines::excerpt};
use std::path::Path;

/// Version of the format, as far as it determines the layout of nodes and elements.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Version {
    V1,
    V2,
    V40,
    V41,
}

/// Header of a block of nodes or elements.
struct Block {
    dimension: i64,
    /// Type of the elements. For nodes, 1 if they have parameters.
    kind: i64,
    count: usize,
}

struct Reader<'a> {
    cursor: Cursor<'a>,
    version: Version,
    contents: FileContents,
}

/// Returns true if the first section of the bytes is that of a Gmsh file.
pub(super) fn has_header(path: &Path, bytes: &[u8]) -> bool {
    let section = Reader::new(path, bytes).next_section();
    matches!(section, Some("MeshFormat" | "NOD"))
}

/// Reads a Gmsh file. Sections other than nodes and elements are skipped.
pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<FileContents, FileError> {
    if !has_header(path, bytes) {
        if mujoco::has_stated_length(bytes) {
            return Err(FileError::HoldsSurface { path: path.into() });
        }
        let found = excerpt(bytes.trim_ascii_start());
        return Err(unsupported(path, &format!("the header {found:?}")));
    }
    let mut reader = Reader::new(path, bytes);
    while let Some(section) = reader.next_section() {
        match section {
            "MeshFormat" => reader.read_format()?,
            "Nodes" | "NOD" => reader.read_nodes(false)?,
            "ParametricNodes" => reader.read_nodes(true)?,
            "Elements" | "ELM" => reader.read_elements()?,
            _ => reader.skip_section(section),
        }
        reader.check_end(section)?;
    }
    Ok(reader.contents)
}

fn unsupported(path: &Path, found: &str) -> FileError {
    FileError::Unsupported {
        path: path.into(),
        found: found.into(),
        expected: "Gmsh versions 1, 2.0 to 2.2, 4.0 and 4.1 (\"$NOD\", or \"$MeshFormat\" and \"4.1 0 8\" or \"4.1 1 8\")",
    }
}

impl<'a> Reader<'a> {
    fn new(path: &'a Path, bytes: &'a [u8]) -> Self {
        Self {
            cursor: Cursor::new(path, "Gmsh", bytes),
            version: Version::V1,
            contents: FileContents::default(),
        }
    }

    /// Moves to the contents of the next section and returns its name.
    fn next_section(&mut self) -> Option<&'a str> {
        while !self.cursor.is_at_end() {
            let line = std::str::from_utf8(self.cursor.line()).unwrap_or_default();
            if let Some(name) = line.strip_prefix('$') {
                return Some(name.trim_ascii_end());
            }
        }
        None
    }

    fn skip_section(&mut self, name: &str) {
        let end = format!("$End{name}");
        let rest = self.cursor.rest();
        let length = rest
            .windows(end.len())
            .position(|window| window == end.as_bytes());
        // A section without an end is the last one.
        let _ = self.cursor.take(length.unwrap_or(rest.len()));
    }

    /// Reads the end of a section.
    fn check_end(&mut self, name: &str) -> Result<(), FileError> {
        let mut after = self.cursor;
        let end = format!("$End{name}");
        if after.is_at_end() || after.word()?.eq_ignore_ascii_case(&end) {
            // The end of a section of elements is required, because its last number may be truncated.
            if self.cursor.is_at_end() && matches!(name, "Nodes" | "Elements" | "NOD" | "ELM") {
                return Err(after.error(format!("{end} is missing")));
            }
            self.cursor = after;
            return Ok(());
        }
        Err(self.cursor.error(format!("expected {end}")))
    }

    fn read_format(&mut self) -> Result<(), FileError> {
        let words = self.cursor.line_words();
        let version = match words.first().copied() {
            Some("1" | "1.0") => Some(Version::V1),
            Some("2" | "2.0" | "2.1" | "2.2") => Some(Version::V2),
            Some("4" | "4.0") => Some(Version::V40),
            Some("4.1") => Some(Version::V41),
            _ => None,
        };
        let is_binary = match words.get(1..) {
            Some(["0", "8"]) => Some(false),
            Some(["1", "8"]) => Some(true),
            _ => None,
        };
        let (Some(version), Some(is_binary)) = (version, is_binary) else {
            let found = excerpt(words.join(" ").as_bytes());
            let found = format!("the header {found:?}");
            return Err(unsupported(self.cursor.path(), &found));
        };
        self.version = version;
        if is_binary {
            let one = self.cursor;
            self.cursor.binary = match self.cursor.take(Scalar::I32.size)? {
                [1, 0, 0, 0] => Some(ByteOrder::Little),
                [0, 0, 0, 1] => Some(ByteOrder::Big),
                _ => return Err(one.error("expected the number 1 in 4 bytes")),
            };
        }
        Ok(())
    }

    /// Number of nodes or elements in versions 1 and 2, which is a line of text in binary files too.
    fn text_count(&mut self) -> Result<usize, FileError> {
        let start = self.cursor;
        let words = self.cursor.line_words();
        let count = words.first().and_then(|word| word.parse().ok());
        count.ok_or_else(|| start.error("expected a number of entries"))
    }

    /// Number of blocks of a section in version 4.
    fn block_count(&mut self) -> Result<usize, FileError> {
        let count = self.cursor.count(Scalar::U64)?;
        let others = if self.version == Version::V41 { 3 } else { 1 };
        self.cursor.integers(Scalar::U64, others)?;
        Ok(count)
    }

    /// Header of a block in version 4.
    fn block(&mut self) -> Result<Block, FileError> {
        let (first, second) = (
            self.cursor.integer(Scalar::I32)?,
            self.cursor.integer(Scalar::I32)?,
        );
        Ok(Block {
            dimension: if self.version == Version::V41 {
                first
            } else {
                second
            },
            kind: self.cursor.integer(Scalar::I32)?,
            count: self.cursor.count(Scalar::U64)?,
        })
    }

    fn read_nodes(&mut self, are_parametric: bool) -> Result<(), FileError> {
        if matches!(self.version, Version::V1 | Version::V2) {
            for _ in 0..self.text_count()? {
                let tag = self.cursor.integer(Scalar::I32)?;
                self.contents.tags.push(tag);
                self.contents.vertices.push(self.cursor.position()?);
                if are_parametric {
                    let dimension = self.cursor.integer(Scalar::I32)?;
                    self.cursor.integer(Scalar::I32)?;
                    // Only nodes on curves and surfaces have parameters.
                    self.skip_parameters(if dimension == 3 { 0 } else { dimension })?;
                }
            }
            return Ok(());
        }
        for _ in 0..self.block_count()? {
            let block = self.block()?;
            let parameter_count = if block.kind == 0 { 0 } else { block.dimension };
            if self.version == Version::V41 {
                let tags = self.cursor.integers(Scalar::U64, block.count)?;
                self.contents.tags.extend(tags);
            }
            for _ in 0..block.count {
                if self.version == Version::V40 {
                    let tag = self.cursor.integer(Scalar::I32)?;
                    self.contents.tags.push(tag);
                }
                self.contents.vertices.push(self.cursor.position()?);
                self.skip_parameters(parameter_count)?;
            }
        }
        Ok(())
    }

    fn skip_parameters(&mut self, count: i64) -> Result<(), FileError> {
        (0..count.min(3)).try_for_each(|_| self.cursor.real(Scalar::F64).map(|_| ()))
    }

    fn read_elements(&mut self) -> Result<(), FileError> {
        match self.version {
            Version::V1 => {
                for _ in 0..self.text_count()? {
                    let [_, kind, _, _, count] = self.integers()?;
                    self.read_element(kind, Some(count), Scalar::I32)?;
                }
            }
            Version::V2 if self.cursor.binary.is_some() => {
                let mut remaining = self.text_count()?;
                while remaining > 0 {
                    let [kind, count, tag_count] = self.integers()?;
                    for _ in 0..count {
                        self.skip_integers(tag_count.saturating_add(1))?;
                        self.read_element(kind, None, Scalar::I32)?;
                    }
                    remaining = remaining.saturating_sub(usize::try_from(count).unwrap_or(0));
                }
            }
            Version::V2 => {
                for _ in 0..self.text_count()? {
                    let [_, kind, tag_count] = self.integers()?;
                    self.skip_integers(tag_count)?;
                    self.read_element(kind, None, Scalar::I32)?;
                }
            }
            Version::V40 | Version::V41 => {
                let is_new = self.version == Version::V41;
                let index = if is_new { Scalar::U64 } else { Scalar::I32 };
                for _ in 0..self.block_count()? {
                    let block = self.block()?;
                    for _ in 0..block.count {
                        self.cursor.integer(index)?;
                        self.read_element(block.kind, None, index)?;
                    }
                }
            }
        }
        Ok(())
    }

    fn integers<const N: usize>(&mut self) -> Result<[i64; N], FileError> {
        let mut integers = [0; N];
        for integer in &mut integers {
            *integer = self.cursor.integer(Scalar::I32)?;
        }
        Ok(integers)
    }

    fn skip_integers(&mut self, count: i64) -> Result<(), FileError> {
        (0..count).try_for_each(|_| self.cursor.integer(Scalar::I32).map(|_| ()))
    }

    /// Reads the corners of an element. Version 1 states their number.
    fn read_element(
        &mut self,
        kind: i64,
        stated_count: Option<i64>,
        index: Scalar,
    ) -> Result<(), FileError> {
        let start = self.cursor;
        let unknown = || start.error(format!("elements of the unknown type {kind}"));
        let (cell, count) = element(kind).ok_or_else(unknown)?;
        if stated_count.is_some_and(|stated| usize::try_from(stated) != Ok(count)) {
            let cause = format!("elements of type {kind} have {count} nodes");
            return Err(start.error(cause));
        }
        let corners = self.cursor.integers(index, count)?;
        self.contents.add(cell, &corners);
        Ok(())
    }
}

/// Number of nodes of each element type, from type 0 on. It is 0 for unknown types and for types with any number of nodes.
const NODE_COUNTS: [usize; 39] = [
    0, 2, 3, 4, 4, 8, 6, 5, 3, 6, 9, 10, 27, 18, 14, 1, 8, 20, 15, 13, 9, 10, 12, 15, 15, 21, 4, 5,
    6, 20, 35, 56, 22, 28, 0, 0, 16, 25, 36,
];

/// Kind of cell and number of nodes of an element type.
fn element(kind: i64) -> Option<(Cell, usize)> {
    let cell = match kind {
        4 => Cell::Tet,
        11 | 29..=33 | 71 => Cell::HigherTet,
        5 | 12 | 17 | 92 | 93 => Cell::Solid("hexahedron"),
        6 | 13 | 18 => Cell::Solid("prism"),
        7 | 14 | 19 => Cell::Solid("pyramid"),
        1 | 8 | 15 | 26..=28 => Cell::Line,
        _ => Cell::Face,
    };
    let count = match kind {
        71 => 84,
        92 => 64,
        93 => 125,
        _ => *NODE_COUNTS.get(usize::try_from(kind).ok()?)?,
    };
    (count > 0).then_some((cell, count))
}
