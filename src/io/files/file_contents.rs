use super::FileError;
use crate::mesh::TetMesh;
use nalgebra::Vector3;
use std::collections::BTreeMap;
use std::path::Path;

/// Arrays with one number per vertex, by name.
pub(super) type PointData = BTreeMap<String, Vec<f64>>;

/// Unvalidated vertices, tetrahedra and point data of a file.
#[derive(Debug, Default)]
pub(super) struct FileContents {
    /// Positions of the vertices (m).
    pub vertices: Vec<Vector3<f64>>,
    /// Vertex indices of the tetrahedra, which may be out of range.
    pub tets: Vec<[u64; 4]>,
    /// One number per vertex, by name.
    pub point_data: PointData,
}

impl FileContents {
    /// Returns the mesh and the point data, without the vertices that no tetrahedron uses.
    ///
    /// # Errors
    /// - If there are no tetrahedra, or a vertex index is out of range.
    /// - If [`TetMesh::new`] returns an error.
    pub fn into_mesh(self, path: &Path) -> Result<(TetMesh, PointData), FileError> {
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
        let mesh = mesh.map_err(|source| FileError::Mesh {
            path: path.into(),
            source,
        })?;
        let kept_data = |(name, values)| (name, kept(values, &is_used));
        Ok((mesh, self.point_data.into_iter().map(kept_data).collect()))
    }

    /// Returns the tetrahedra after checking their vertex indices.
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
    let values = values.into_iter().zip(is_kept);
    values
        .filter(|(_, is_kept)| **is_kept)
        .map(|(value, _)| value)
        .collect()
}
