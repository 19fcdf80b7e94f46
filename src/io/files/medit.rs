//! Reader of Medit files (`.mesh`), ASCII.

use super::FileError;
use super::cursor::Cursor;
use super::file_contents::{Cell, FileContents};
use super::scalar::Scalar;
use std::path::Path;

/// Cells, their number of vertices and their name.
const CELLS: [(&str, Cell, usize); 7] = [
    ("Tetrahedra", Cell::Tet, 4),
    ("TetrahedraP2", Cell::HigherTet, 10),
    ("Triangles", Cell::Face, 3),
    ("Quadrilaterals", Cell::Face, 4),
    ("Hexahedra", Cell::Solid("hexahedron"), 8),
    ("Prisms", Cell::Solid("prism"), 6),
    ("Pyramids", Cell::Solid("pyramid"), 5),
];

/// Reads a Medit file. Sections other than vertices and cells are skipped.
pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<FileContents, FileError> {
    let mut cursor = Cursor::new(path, "Medit", bytes);
    let mut contents = FileContents::default();
    if !cursor.is_at_end() && !cursor.rest().starts_with(b"MeshVersionFormatted") {
        return Err(cursor.error("expected MeshVersionFormatted, which begins an ASCII file"));
    }
    let mut is_known = false;
    while !cursor.is_at_end() {
        let start = cursor;
        let name = cursor.word()?;
        let is_number = name.parse::<f64>().is_ok();
        if is_number && is_known {
            return Err(start.error("expected a keyword, because all stated entries were read"));
        }
        is_known = !is_number;
        if name.eq_ignore_ascii_case("End") {
            break;
        } else if name.eq_ignore_ascii_case("Dimension") {
            if cursor.parsed::<i64>()? != 3 {
                return Err(start.error("expected a mesh of dimension 3"));
            }
        } else if name.eq_ignore_ascii_case("Vertices") {
            read_vertices(&mut cursor, &mut contents)?;
        } else if let Some(cells) = CELLS
            .iter()
            .find(|cells| cells.0.eq_ignore_ascii_case(name))
        {
            for _ in 0..cursor.parsed::<usize>()? {
                let vertices = cursor.integers(Scalar::I32, cells.2)?;
                // The reference of the cell.
                cursor.parsed::<f64>()?;
                contents.add(cells.1, &vertices);
            }
        } else {
            // Other keywords and their numbers are skipped.
            is_known = false;
        }
    }
    Ok(contents)
}

fn read_vertices(cursor: &mut Cursor, contents: &mut FileContents) -> Result<(), FileError> {
    for _ in 0..cursor.parsed::<usize>()? {
        contents.vertices.push(cursor.position()?);
        cursor.parsed::<f64>()?;
        contents
            .tags
            .push(contents.vertices.len().try_into().unwrap_or(i64::MAX));
    }
    Ok(())
}
