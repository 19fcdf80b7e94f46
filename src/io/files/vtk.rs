use super::syntax_error::{excerpt, syntax_error_at};
use super::{FileError, data_set_fields, file_contents::FileContents, vtu_lengths, xml};
use nalgebra::Vector3;
use percent_encoding::percent_decode_str;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::error::Error;
use std::path::Path;
use vtkio::model::{
    Attribute, CellType, Cells, DataSet, Piece, UnstructuredGridPiece, VertexNumbers,
};
use vtkio::{IOBuffer, Vtk, parser, xml::VTKFile};

/// Reads a legacy VTK file.
pub(super) fn read_legacy(path: &Path, bytes: &[u8]) -> Result<FileContents, FileError> {
    let bytes = &*data_set_fields::mask_fields(bytes);
    let (rest, vtk) = parser::parse_be(bytes).map_err(|error| {
        let mut rest = &bytes[bytes.len()..];
        let cause = error.map(|cause| {
            rest = cause.input;
            cause.code
        });
        syntax_error_at(rest, cause.to_string(), (path, "legacy VTK", bytes))
    })?;
    // vtkio stops without an error at the first text that it cannot parse.
    if !rest.trim_ascii().is_empty() {
        return Err(FileError::Unread {
            path: path.into(),
            offset: bytes.len() - rest.len(),
            found: excerpt(rest.trim_ascii()),
        });
    }
    let contents = contents(path, vtk.data)?;
    // VTK percent-encodes names in legacy files, but not in XML files.
    let point_data = contents.point_data.into_iter();
    let point_data = point_data.map(|(name, data)| (percent_decoded(&name), data));
    Ok(FileContents {
        point_data: point_data.collect(),
        ..contents
    })
}

/// Decodes a percent-encoded name. Returns the name unchanged if the decoded bytes are not UTF-8.
fn percent_decoded(name: &str) -> String {
    let text = percent_decode_str(name).decode_utf8();
    text.map_or_else(|_| name.to_owned(), Cow::into_owned)
}

/// Reads a VTK XML file.
pub(super) fn read_xml(path: &Path, bytes: &[u8]) -> Result<FileContents, FileError> {
    const FORMAT: &str = "VTK XML";
    // Appended raw data is not XML, so this check comes first.
    vtu_lengths::check_inline(path, bytes)?;
    xml::check(bytes).map_err(|error| xml_error(path, FORMAT, error))?;
    let file = VTKFile::parse(bytes).map_err(|error| xml_error(path, FORMAT, error))?;
    vtu_lengths::check(path, &file)?;
    let vtk = Vtk::try_from(file).map_err(|error| xml_error(path, FORMAT, error))?;
    contents(path, vtk.data)
}

fn xml_error(
    path: &Path,
    format: &'static str,
    source: impl Error + Send + Sync + 'static,
) -> FileError {
    FileError::Syntax {
        path: path.into(),
        format,
        source: Box::new(source),
    }
}

fn contents(path: &Path, data: DataSet) -> Result<FileContents, FileError> {
    let unsupported = |found: String| FileError::Unsupported {
        path: path.into(),
        found,
        expected: "an unstructured grid of one piece",
    };
    let DataSet::UnstructuredGrid { pieces, .. } = data else {
        return Err(unsupported("another kind of data set".into()));
    };
    let piece_count = pieces.len();
    match <[Piece<UnstructuredGridPiece>; 1]>::try_from(pieces) {
        Ok([Piece::Inline(grid)]) => contents_of_grid(path, &grid),
        Ok(_) => Err(unsupported("a reference to another file".into())),
        Err(_) => Err(unsupported(format!("{piece_count} pieces"))),
    }
}

fn contents_of_grid(path: &Path, grid: &UnstructuredGridPiece) -> Result<FileContents, FileError> {
    let vertices = vertices(path, &grid.points)?;
    let point_data = point_data(&grid.data.point, vertices.len());
    Ok(FileContents {
        tets: tets(path, &grid.cells)?,
        vertices,
        point_data,
    })
}

fn vertices(path: &Path, points: &IOBuffer) -> Result<Vec<Vector3<f64>>, FileError> {
    let coordinates: Vec<f64> = points.cast_into().unwrap_or_default();
    let (vertices, rest) = coordinates.as_chunks::<3>();
    if !rest.is_empty() {
        return Err(FileError::TooShort {
            path: path.into(),
            part: "last point".into(),
            found: rest.len(),
            expected: 3,
        });
    }
    Ok(vertices.iter().map(|&vertex| vertex.into()).collect())
}

/// Arrays of point data with one number per vertex.
fn point_data(attributes: &[Attribute], vertex_count: usize) -> BTreeMap<String, Vec<f64>> {
    let mut point_data = BTreeMap::new();
    let mut add = |name: &str, component_count: usize, data: &IOBuffer| {
        if component_count == 1
            && data.len() == vertex_count
            && let Some(values) = data.cast_into()
        {
            point_data.insert(name.into(), values);
        }
    };
    for attribute in attributes {
        match attribute {
            Attribute::DataArray(array) => add(&array.name, array.num_comp(), &array.data),
            Attribute::Field { data_array, .. } => {
                for array in data_array {
                    add(&array.name, array.num_comp(), &array.data);
                }
            }
        }
    }
    point_data
}

/// Tetrahedra of the file.
///
/// # Errors
/// If the file has other solid cells, or a cell has the wrong number of corners.
fn tets(path: &Path, cells: &Cells) -> Result<Vec<[u64; 4]>, FileError> {
    let corners = cell_corners(path, cells)?;
    let mut tets = Vec::new();
    for (cell, (&kind, corners)) in cells.types.iter().zip(corners).enumerate() {
        if is_tet(path, kind)? {
            let found = corners.len();
            tets.push(corners.try_into().map_err(|_| FileError::TooShort {
                path: path.into(),
                part: format!("list of corners of cell {cell}"),
                found,
                expected: 4,
            })?);
        }
    }
    Ok(tets)
}

/// Whether a cell is a linear tetrahedron.
///
/// # Errors
/// If the cell is another solid.
fn is_tet(path: &Path, kind: CellType) -> Result<bool, FileError> {
    use CellType as C;
    let (path, found) = (path.into(), format!("{kind:?}"));
    match kind {
        C::Tetra => Ok(true),
        C::Vertex
        | C::PolyVertex
        | C::Line
        | C::PolyLine
        | C::Triangle
        | C::TriangleStrip
        | C::Polygon
        | C::Pixel
        | C::Quad
        | C::QuadraticEdge
        | C::QuadraticTriangle
        | C::QuadraticQuad => Ok(false),
        C::QuadraticTetra
        | C::ParametricTetraRegion
        | C::HigherOrderTetrahedron
        | C::LagrangeTetrahedron
        | C::BezierTetrahedron => Err(FileError::HigherOrder { path, found }),
        _ => Err(FileError::OtherSolid { path, found }),
    }
}

/// Vertex indices of each cell.
fn cell_corners(path: &Path, cells: &Cells) -> Result<Vec<Vec<u64>>, FileError> {
    let cell_count = cells.types.len();
    let corners = match &cells.cell_verts {
        VertexNumbers::Legacy { vertices, .. } => counted_corners(vertices),
        VertexNumbers::XML {
            connectivity,
            offsets,
        } => {
            // In legacy files of version 5.1, the list of offsets begins with 0.
            let begins_with_zero = offsets.len() == cell_count + 1;
            sliced_corners(connectivity, &offsets[usize::from(begins_with_zero)..])
        }
    };
    if corners.len() < cell_count {
        return Err(FileError::TooShort {
            path: path.into(),
            part: "list of cells".into(),
            found: corners.len(),
            expected: cell_count,
        });
    }
    Ok(corners)
}

/// Corners of the cells in a list in which the number of corners precedes the corners of each cell. Stops at an incomplete cell.
fn counted_corners(mut list: &[u32]) -> Vec<Vec<u64>> {
    let mut cells = Vec::new();
    while let Some((&count, rest)) = list.split_first() {
        let Some((corners, rest)) = rest.split_at_checked(count as usize) else {
            break;
        };
        cells.push(corners.iter().copied().map(u64::from).collect());
        list = rest;
    }
    cells
}

/// Corners of the cells, from a list of all corners and the end of each cell in this list. Stops at an end that is out of range.
fn sliced_corners(connectivity: &[u64], ends: &[u64]) -> Vec<Vec<u64>> {
    let mut start = 0;
    let slice = ends.iter().map_while(|&end| {
        let end = usize::try_from(end).ok()?;
        let corners = connectivity.get(start..end)?;
        start = end;
        Some(corners.to_vec())
    });
    slice.collect()
}

#[cfg(test)]
mod tests {
    use super::percent_decoded;

    #[test]
    fn names_are_decoded_where_that_gives_text() {
        assert_eq!(
            percent_decoded("a%20name%20with%20spaces"),
            "a name with spaces"
        );
        assert_eq!(percent_decoded("plain"), "plain");
        assert_eq!(percent_decoded("100%"), "100%");
        assert_eq!(percent_decoded("50%zz%+f"), "50%zz%+f");
        assert_eq!(percent_decoded("%c3%a9"), "é");
        assert_eq!(percent_decoded("%ff"), "%ff");
    }
}
