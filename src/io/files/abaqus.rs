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
    /// Displacement of an instance of a part.
    Instance,
    Other,
}

/// Keywords that make or move nodes and elements.
const UNREADABLE: [&str; 8] = [
    "*SYSTEM", "*NGEN", "*ELGEN", "*NCOPY", "*ELCOPY", "*NFILL", "*NMAP", "*INCLUDE",
];

/// Remedy in messages.
const REMEDY: &str =
    "write all nodes and elements in one file, for example by exporting an orphan mesh";

/// Reads an Abaqus file. Keywords other than `*NODE` and `*ELEMENT` are skipped.
pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<FileContents, FileError> {
    let mut cursor = Cursor::new(path, "Abaqus", bytes);
    let mut contents = FileContents::default();
    let mut block = Block::Other;
    let mut instances = Instances::default();
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
            block = block_of(line).map_err(|cause| start.error(cause))?;
            if let Block::Instance = block {
                instances.parts.push(part_of(line));
                instances.check().map_err(|cause| start.error(cause))?;
            }
            continue;
        }
        match block {
            Block::Nodes => {
                let (tag, position) = node(line, &start)?;
                contents.tags.push(tag);
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
            Block::Instance => {
                instances.has_displacement = true;
                instances.check().map_err(|cause| start.error(cause))?;
            }
            Block::Other => {}
        }
    }
    if element.is_empty() {
        return Ok(contents);
    }
    Err(cursor.error("the last element is incomplete"))
}

/// Label and position of a node.
fn node(line: &str, start: &Cursor) -> Result<(i64, Vector3<f64>), FileError> {
    if line.trim_end_matches(',').split(',').count() == 3 {
        let cause =
            "expected three coordinates, but found two: two-dimensional models have no tetrahedra";
        return Err(start.error(cause));
    }
    let mut words = line.split(',').map(str::trim);
    let tag = words.next().and_then(|word| word.parse().ok());
    let mut position = Vector3::zeros();
    for coordinate in &mut position {
        *coordinate = number(words.next(), start)?;
    }
    let tag = tag.ok_or_else(|| start.error("expected a node label"))?;
    Ok((tag, position))
}

fn number<T: FromStr>(word: Option<&str>, line: &Cursor) -> Result<T, FileError> {
    let number = word.and_then(|word| word.parse().ok());
    number.ok_or_else(|| line.error("expected numbers separated by commas"))
}

/// Name of the part of an instance, in upper case.
fn part_of(line: &str) -> Option<String> {
    let line = line.to_ascii_uppercase();
    let mut options = line.split(',').filter_map(|option| option.split_once('='));
    let (_, name) = options.find(|(option, _)| option.trim() == "PART")?;
    Some(name.trim().trim_matches('"').into())
}

/// Instances of parts in the lines that have been read.
#[derive(Default)]
struct Instances {
    /// Name of the part of each instance, if it has one.
    parts: Vec<Option<String>>,
    has_displacement: bool,
}

impl Instances {
    /// Returns an error if a part has several instances, or if there are several instances and one of them has a displacement.
    fn check(&self) -> Result<(), String> {
        let Some((last, before)) = self.parts.split_last() else {
            return Ok(());
        };
        match last {
            Some(part) if before.contains(last) => Err(format!(
                "more than one *INSTANCE of the part {part} cannot be read: {REMEDY}"
            )),
            _ if self.has_displacement && !before.is_empty() => Err(format!(
                "more than one *INSTANCE, with a displacement, cannot be read: {REMEDY}"
            )),
            _ => Ok(()),
        }
    }
}

/// Block that a line with a keyword begins.
fn block_of(line: &str) -> Result<Block, String> {
    let line = line.to_ascii_uppercase().replace([' ', '\t'], "");
    let mut words = line.split(',');
    let keyword = words.next().unwrap_or_default();
    let is_read = ["*NODE", "*ELEMENT"].contains(&keyword);
    let is_elsewhere = |word: &&str| {
        is_read
            && (word.starts_with("INPUT=") || word.starts_with("SYSTEM="))
            && *word != "SYSTEM=R"
    };
    let unreadable = UNREADABLE.contains(&keyword).then_some(keyword);
    if let Some(found) = unreadable.or_else(|| words.clone().find(is_elsewhere)) {
        return Err(format!("{found} cannot be read: {REMEDY}"));
    }
    Ok(match keyword {
        "*NODE" => Block::Nodes,
        "*INSTANCE" => Block::Instance,
        "*ELEMENT" => {
            let kind = words.find_map(|word| word.strip_prefix("TYPE="));
            let (cell, count) = element(kind.unwrap_or_default());
            Block::Elements(cell, count)
        }
        _ => Block::Other,
    })
}

/// Cell of a type of element, and its number of nodes, or 0 if it is unknown.
fn element(kind: &str) -> (Cell, usize) {
    match kind {
        _ if kind.starts_with("C3D4") => (Cell::Tet, 4),
        _ if kind.starts_with("C3D10") => (Cell::HigherTet, 10),
        _ if kind.starts_with("C3D20") => (Cell::Solid("hexahedron"), 20),
        _ if kind.starts_with("C3D8") => (Cell::Solid("hexahedron"), 8),
        _ if kind.starts_with("C3D") => (Cell::Solid("solid of another type"), 0),
        _ if kind.starts_with(['T', 'B']) => (Cell::Line, 0),
        _ => (Cell::Face, 0),
    }
}
