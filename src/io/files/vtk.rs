//! Reader of VTK files, legacy and XML: unstructured grids and polygons.

use super::file_contents::FileContents;
use super::vtk_data_set::DataSet;
use super::{FileError, vtk_legacy, vtk_xml};
use crate::mesh::TriangleSoup;
use std::path::Path;

/// Reads a VTK file. The contents select the format.
fn read(path: &Path, bytes: &[u8]) -> Result<DataSet, FileError> {
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    if text.trim_ascii_start().starts_with(b"<") {
        vtk_xml::read(path, text)
    } else {
        vtk_legacy::read(path, bytes)
    }
}

fn damaged(path: &Path, cause: impl Into<String>) -> FileError {
    FileError::Syntax {
        path: path.into(),
        format: "VTK",
        source: cause.into().into(),
    }
}

/// Reads the tetrahedra of an unstructured grid.
pub(super) fn read_grid(path: &Path, bytes: &[u8]) -> Result<FileContents, FileError> {
    let data = read(path, bytes)?;
    if data.is_surface() {
        return Err(FileError::HoldsSurface { path: path.into() });
    }
    data.into_contents().map_err(|cause| damaged(path, cause))
}

/// Reads the triangles of polygons and triangle strips, in the unit of the file. A grid with solid cells is an error, because its faces
/// may be parts of its surface or lie inside.
pub(super) fn read_polygons(path: &Path, bytes: &[u8]) -> Result<TriangleSoup, FileError> {
    let data = read(path, bytes)?;
    if data.has_solids() {
        return Err(FileError::HoldsGrid { path: path.into() });
    }
    data.triangles().map_err(|cause| damaged(path, cause))
}
