//! Reader of Abaqus input files (`.inp`): nodes and elements.

use super::FileError;
use super::cursor::Cursor;
use super::file_contents::{Cell, FileContents};
use nalgebra::Vector3;
use std::path::Path;
use std::str::FromStr;

/// Block of lines after a keyword.
#[derive(Clone, Copy)]
enum Block {
    Nodes,
    Elements(Cell, usize),
    Other,
}

/// Reads an Abaqus file. Keywords other than `*NODE` and `*ELEMENT` are skipped.
pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<FileContents, FileError> {
    let mut cursor = Cursor::new(path, "Abaqus", bytes);
    let mut contents = FileContents::default();
    let mut block = Block::Other;
    // Numbers of an element, which may continue on the next line.
    let mut element: Vec<i64> = Vec::new();
    while !cursor.rest().trim_ascii().is_empty() {
        let start = cursor;
        let text = String::from_utf8_lossy(cursor.line());
        let line = text.trim();
        if line.is_empty() || line.starts_with("**") {
            continue;
        }
        if line.starts_with('*') {
            if !element.is_empty() {
                return Err(start.error("the previous element is incomplete"));
            }
            block = block_of(line);
            continue;
        }
        match block {
            Block::Nodes => {
                let mut words = line.split(',').map(str::trim);
                let tag = words.next().and_then(|word| word.parse().ok());
                let mut position = Vector3::zeros();
                for coordinate in &mut position {
                    *coordinate = number(words.next(), &start)?;
                }
                contents
                    .tags
                    .push(tag.ok_or_else(|| start.error("expected a node label"))?);
                contents.vertices.push(position);
            }
            Block::Elements(cell, count) => {
                let words = line
                    .split(',')
                    .map(str::trim)
                    .filter(|word| !word.is_empty());
                for word in words {
                    element.push(number(Some(word), &start)?);
                }
                // Elements of unknown size are one line each.
                if element.len() > count {
                    if !contents.add(cell, &element[1..]) {
                        return Err(start.error(format!("expected {count} nodes of an element")));
                    }
                    element.clear();
                }
            }
            Block::Other => {}
        }
    }
    if element.is_empty() {
        return Ok(contents);
    }
    Err(cursor.error("the last element is incomplete"))
}

fn number<T: FromStr>(word: Option<&str>, line: &Cursor) -> Result<T, FileError> {
    let number = word.and_then(|word| word.parse().ok());
    number.ok_or_else(|| line.error("expected numbers separated by commas"))
}

/// Block that a line with a keyword begins.
fn block_of(line: &str) -> Block {
    let line = line.to_ascii_uppercase().replace(' ', "");
    let mut words = line.split(',');
    match words.next() {
        Some("*NODE") => Block::Nodes,
        Some("*ELEMENT") => {
            let kind = words.find_map(|word| word.strip_prefix("TYPE="));
            match kind.unwrap_or_default() {
                kind if kind.starts_with("C3D4") => Block::Elements(Cell::Tet, 4),
                kind if kind.starts_with("C3D10") => Block::Elements(Cell::HigherTet, 10),
                kind if kind.starts_with("C3D20") => Block::Elements(Cell::Solid("hexahedron"), 20),
                kind if kind.starts_with("C3D8") => Block::Elements(Cell::Solid("hexahedron"), 8),
                kind if kind.starts_with("C3D") => {
                    Block::Elements(Cell::Solid("solid of another type"), 0)
                }
                _ => Block::Elements(Cell::Flat, 0),
            }
        }
        _ => Block::Other,
    }
}
