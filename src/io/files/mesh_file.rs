#[cfg(feature = "vtk")]
use super::vtk;
use super::{FileError, extension::known_extension, gmsh};
use crate::mesh::{PressureField, TetMesh};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// What the name of a mesh file can end in.
#[cfg(feature = "vtk")]
const EXTENSIONS: &[&str] = &["msh", "vtk", "vtu"];
#[cfg(not(feature = "vtk"))]
const EXTENSIONS: &[&str] = &["msh"];

/// A tetrahedral mesh from a file.
#[derive(Debug, Clone)]
pub struct MeshFile {
    /// The mesh: all tetrahedra of the file, and the vertices they use, in the order of the file.
    pub mesh: TetMesh,
    /// The point-data arrays with one number per vertex, by name (VTK only).
    pub point_data: BTreeMap<String, Vec<f64>>,
    path: PathBuf,
}

/// Reads a tetrahedral mesh (m), in the format that the extension of the file's name tells, in
/// upper or lower case:
///
/// - `.msh`: Gmsh 4.1, ASCII or binary. Of its data sections (`$NodeData`) none is read, so
///   extents have to come from the distance to the surface, or from a VTK file.
/// - `.vtk` (feature `vtk`): VTK legacy unstructured grid, ASCII or binary, up to version 5.1.
/// - `.vtu` (feature `vtk`): VTK XML unstructured grid of one piece, ASCII or inline binary, uncompressed or
///   compressed with zlib. VTK calls that the data mode ascii or binary, as opposed to appended.
///
/// Elements of lower dimension (points, lines, surface triangles) and vertices that no tetrahedron
/// uses are left out.
///
/// # Errors
/// If the file cannot be read or understood, has no tetrahedra, has tetrahedra of higher order or
/// other solid elements, or if [`TetMesh::new`] refuses the mesh.
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
    /// The mesh with one of its point-data arrays as extents (any unit: pressure = modulus ×
    /// extent).
    ///
    /// # Errors
    /// If there is no array of that name, or if [`PressureField::new`] refuses it.
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
