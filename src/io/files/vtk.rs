//! Reader of VTK files, legacy and XML: unstructured grids and polygons.

use super::file_contents::FileContents;
use super::vtk_data_set::DataSet;
use super::{FileError, vtk_legacy, vtk_xml};
use crate::mesh::TriangleSoup;
use std::path::Path;

/// Reads a VTK file. The contents select the format.
fn read(path: &Path, bytes: &[u8]) -> Result<DataSet, FileError> {
    if bytes.trim_ascii_start().starts_with(b"<") {
        vtk_xml::read(path, bytes)
    } else {
        vtk_legacy::read(path, bytes)
    }
}

/// Reads the tetrahedra of an unstructured grid.
pub(super) fn read_grid(path: &Path, bytes: &[u8]) -> Result<FileContents, FileError> {
    let data = read(path, bytes)?;
    if data.is_surface() {
        return Err(FileError::HoldsSurface { path: path.into() });
    }
    let contents = data.into_contents();
    contents.map_err(|cause| FileError::syntax(path, "VTK", cause))
}

/// Reads the triangles of polygons and triangle strips, in the unit of the file. A grid with solid cells is an error, because its faces
/// may be parts of its surface or lie inside.
pub(super) fn read_polygons(path: &Path, bytes: &[u8]) -> Result<TriangleSoup, FileError> {
    let data = read(path, bytes)?;
    if data.has_solids() {
        return Err(FileError::HoldsGrid { path: path.into() });
    }
    let triangles = data.triangles();
    triangles.map_err(|cause| FileError::syntax(path, "VTK", cause))
}
