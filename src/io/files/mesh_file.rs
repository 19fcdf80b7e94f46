#[cfg(feature = "vtk")]
use super::vtk;
use super::{FileError, extension::known_extension, gmsh};
use crate::mesh::{PressureField, TetMesh};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Extensions of mesh files.
#[cfg(feature = "vtk")]
const EXTENSIONS: &[&str] = &["msh", "vtk", "vtu"];
#[cfg(not(feature = "vtk"))]
const EXTENSIONS: &[&str] = &["msh"];

/// A tetrahedral mesh from a file.
#[derive(Debug, Clone)]
pub struct MeshFile {
    /// Mesh (m): all tetrahedra of the file and the vertices of these tetrahedra, in the order of the file.
    pub mesh: TetMesh,
    /// Point-data arrays with one number per vertex, by name (VTK only).
    pub point_data: BTreeMap<String, Vec<f64>>,
    path: PathBuf,
}

/// Reads a tetrahedral mesh (m). The extension of the file name, in upper or lower case, selects the format:
///
/// - `.msh`: Gmsh 4.1, ASCII or binary. Data sections (`$NodeData`) are ignored, so compute the extents from the distance to the
///   surface, or use a VTK file.
/// - `.vtk` (feature `vtk`): VTK legacy unstructured grid, ASCII or binary, up to version 5.1.
/// - `.vtu` (feature `vtk`): VTK XML unstructured grid of one piece, ASCII or inline binary, uncompressed or compressed with zlib.
///   These are the data modes ascii and binary of VTK. The data mode appended is not supported.
///
/// Elements of lower dimension (points, lines, surface triangles) and vertices that no tetrahedron uses are ignored.
///
/// # Errors
/// - If the file cannot be read or parsed.
/// - If the file has no tetrahedra, tetrahedra of higher order, or other solid elements.
/// - If [`TetMesh::new`] returns an error.
pub fn read_mesh(path: impl AsRef<Path>) -> Result<MeshFile, FileError> {
    let path = path.as_ref();
    let extension = known_extension(path, EXTENSIONS)?;
    let bytes = std::fs::read(path).map_err(|source| FileError::Read {
        path: path.into(),
        source,
    })?;
    let contents = match extension {
        #[cfg(feature = "vtk")]
        "vtk" => vtk::read_legacy(path, &bytes)?,
        #[cfg(feature = "vtk")]
        "vtu" => vtk::read_xml(path, &bytes)?,
        _ => gmsh::read(path, bytes)?,
    };
    let (mesh, point_data) = contents.into_mesh(path)?;
    Ok(MeshFile {
        mesh,
        point_data,
        path: path.into(),
    })
}

impl MeshFile {
    /// Pressure field of the mesh, with the named point-data array as extents (any unit: pressure = modulus × extent).
    ///
    /// # Errors
    /// - If the file has no array of this name with one number per vertex.
    /// - If [`PressureField::new`] returns an error.
    pub fn pressure_field(mut self, extents: &str) -> Result<PressureField, FileError> {
        let Some(values) = self.point_data.remove(extents) else {
            return Err(FileError::NoSuchArray {
                path: self.path,
                name: extents.into(),
                found: self.point_data.into_keys().collect(),
            });
        };
        PressureField::new(self.mesh, values).map_err(|source| FileError::Mesh {
            path: self.path,
            source,
        })
    }
}
