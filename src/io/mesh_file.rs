use super::{FileError, gmsh, vtk};
use crate::mesh::{PressureField, TetMesh};
use nalgebra::Vector3;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// What the name of a mesh file can end in.
const EXTENSIONS: &[&str] = &["msh", "vtk", "vtu"];

/// A tetrahedral mesh from a file.
#[derive(Debug, Clone)]
pub struct MeshFile {
    /// The mesh: all tetrahedra of the file, and the vertices they use, in the order of the file.
    pub mesh: TetMesh,
    /// The point-data arrays with one number per vertex, by name (VTK only).
    pub point_data: BTreeMap<String, Vec<f64>>,
    path: PathBuf,
}

/// The vertices, tetrahedra and point data as they are in a file.
#[derive(Debug, Default)]
pub(super) struct FileContents {
    /// Positions of the vertices (m).
    pub vertices: Vec<Vector3<f64>>,
    /// Indices of vertices, each perhaps out of range.
    pub tets: Vec<[u64; 4]>,
    /// One number per vertex, by name.
    pub point_data: BTreeMap<String, Vec<f64>>,
}

/// Reads a tetrahedral mesh (m), in the format that the extension of the file's name tells, in
/// upper or lower case:
///
/// - `.msh`: Gmsh 4.1, ASCII or binary. Of its data sections (`$NodeData`) none is read, so
///   extents have to come from the distance to the surface, or from a VTK file.
/// - `.vtk`: VTK legacy unstructured grid, ASCII or binary, up to version 5.1.
/// - `.vtu`: VTK XML unstructured grid of one piece, ASCII or inline binary, uncompressed or
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
    let extension = extension(path);
    if !EXTENSIONS.contains(&extension.as_str()) {
        return Err(unknown_extension(path, EXTENSIONS));
    }
    let bytes = std::fs::read(path).map_err(|source| FileError::Read {
        path: path.into(),
        source,
    })?;
    let contents = match extension.as_str() {
        "msh" => gmsh::read(path, bytes)?,
        "vtk" => vtk::read_legacy(path, &bytes)?,
        _ => vtk::read_xml(path, &bytes)?,
    };
    contents.into_mesh_file(path)
}

/// The extension of a file's name, in lower case; empty if there is none.
pub(super) fn extension(path: &Path) -> String {
    let extension = path.extension().unwrap_or_default();
    extension.to_string_lossy().to_lowercase()
}

pub(super) fn unknown_extension(path: &Path, expected: &'static [&'static str]) -> FileError {
    FileError::UnknownExtension {
        path: path.into(),
        found: extension(path),
        expected,
    }
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

impl FileContents {
    fn into_mesh_file(self, path: &Path) -> Result<MeshFile, FileError> {
        if self.tets.is_empty() {
            return Err(FileError::NoTetrahedra { path: path.into() });
        }
        let tets = self.checked_tets(path)?;
        let is_used = self.used_vertices(&tets);
        let mut new_indices = vec![0; is_used.len()];
        for (new, old) in (0..is_used.len()).filter(|&v| is_used[v]).enumerate() {
            new_indices[old] = new;
        }
        let tets = tets.iter().map(|tet| tet.map(|v| new_indices[v])).collect();
        let mesh = TetMesh::new(kept(self.vertices, &is_used), tets);
        let kept_data = |(name, values)| (name, kept(values, &is_used));
        Ok(MeshFile {
            mesh: mesh.map_err(|source| FileError::Mesh {
                path: path.into(),
                source,
            })?,
            point_data: self.point_data.into_iter().map(kept_data).collect(),
            path: path.into(),
        })
    }

    /// The tetrahedra, with all indices in range.
    fn checked_tets(&self, path: &Path) -> Result<Vec<[usize; 4]>, FileError> {
        let vertex_count = self.vertices.len();
        let mut tets = Vec::with_capacity(self.tets.len());
        for (tet, corners) in self.tets.iter().enumerate() {
            let mut indices = [0; 4];
            for (index, &vertex) in indices.iter_mut().zip(corners) {
                *index = usize::try_from(vertex)
                    .ok()
                    .filter(|&index| index < vertex_count)
                    .ok_or_else(|| FileError::UnknownVertex {
                        path: path.into(),
                        tet,
                        vertex,
                    })?;
            }
            tets.push(indices);
        }
        Ok(tets)
    }

    fn used_vertices(&self, tets: &[[usize; 4]]) -> Vec<bool> {
        let mut is_used = vec![false; self.vertices.len()];
        for &vertex in tets.iter().flatten() {
            is_used[vertex] = true;
        }
        is_used
    }
}

fn kept<T>(values: Vec<T>, is_kept: &[bool]) -> Vec<T> {
    let marked = values.into_iter().zip(is_kept);
    marked.filter(|(_, kept)| **kept).map(|(v, _)| v).collect()
}
