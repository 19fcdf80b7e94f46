//! Reader of the two files of TetGen: vertices (`.node`) and tetrahedra (`.ele`).

use super::FileError;
use super::cursor::Cursor;
use super::file_contents::{Cell, FileContents};
use super::mesh_file::file_bytes;
use super::scalar::Scalar;
use std::path::Path;

/// Reads both files, by the path of one of them.
pub(super) fn read(path: &Path) -> Result<FileContents, FileError> {
    let mut contents = FileContents::default();
    let sibling = |extension: &str| match path.extension() {
        Some(given) if given.eq_ignore_ascii_case(extension) => path.to_owned(),
        _ => path.with_extension(extension),
    };
    let (nodes, tets) = (sibling("node"), sibling("ele"));
    read_nodes(
        Cursor::new(&nodes, "TetGen .node", &file_bytes(&nodes)?),
        &mut contents,
    )?;
    read_tets(
        Cursor::new(&tets, "TetGen .ele", &file_bytes(&tets)?),
        &mut contents,
    )?;
    Ok(contents)
}

/// Reads lines of an index, three coordinates, attributes and an optional boundary marker.
fn read_nodes(mut cursor: Cursor, contents: &mut FileContents) -> Result<(), FileError> {
    let start = cursor;
    let [count, dimension, attribute_count, marker_count] = numbers(&cursor.line_words());
    let (Some(count), Some(3)) = (count, dimension) else {
        return Err(start.error("expected the number of points and the dimension 3"));
    };
    let extra_counts = [attribute_count, marker_count].into_iter().flatten();
    let extra_count = extra_counts.fold(0, usize::saturating_add);
    for _ in 0..count {
        contents.tags.push(cursor.parsed()?);
        contents.vertices.push(cursor.position()?);
        cursor.reals(Scalar::F64, extra_count)?;
    }
    check_end(cursor, count)
}

/// Reads lines of an index, 4 or 10 vertices, and attributes.
fn read_tets(mut cursor: Cursor, contents: &mut FileContents) -> Result<(), FileError> {
    let start = cursor;
    let [count, vertex_count, attribute_count] = numbers(&cursor.line_words());
    let (Some(count), Some(vertex_count @ (4 | 10))) = (count, vertex_count) else {
        return Err(start.error("expected the number of tetrahedra, and 4 or 10 vertices for each"));
    };
    let cell = if vertex_count == 4 {
        Cell::Tet
    } else {
        Cell::HigherTet
    };
    for _ in 0..count {
        cursor.parsed::<i64>()?;
        contents.add(cell, &cursor.integers(Scalar::I32, vertex_count)?);
        cursor.reals(Scalar::F64, attribute_count.unwrap_or(0))?;
    }
    check_end(cursor, count)
}

/// Checks that nothing follows the stated number of entries.
fn check_end(mut cursor: Cursor, count: usize) -> Result<(), FileError> {
    if cursor.is_at_end() {
        return Ok(());
    }
    Err(cursor.error(format!(
        "expected the end of the file after {count} entries"
    )))
}

/// First words of a line as numbers. Missing and invalid numbers are `None`.
fn numbers<const N: usize>(words: &[&str]) -> [Option<usize>; N] {
    std::array::from_fn(|index| words.get(index)?.parse().ok())
}
