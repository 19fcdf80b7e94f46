use super::{FileError, FileWarning, MeshFile, MeshOptions, mesh_warnings, seams};
use crate::mesh::TetMesh;
use nalgebra::Vector3;
use rustc_hash::FxHashMap;
use std::collections::BTreeMap;
use std::path::Path;

/// Arrays with one number per vertex, by name.
pub(super) type PointData = BTreeMap<String, Vec<f64>>;

/// Kind of a cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Cell {
    /// A tetrahedron of 4 vertices.
    Tet,
    /// A tetrahedron of more vertices. The first 4 are its corners.
    HigherTet,
    /// A face.
    Face,
    /// A point or a line.
    Line,
    /// Another solid, by name.
    Solid(&'static str),
}

/// Unvalidated vertices, tetrahedra and point data of a file.
#[derive(Debug, Default)]
pub(super) struct FileContents {
    /// Positions of the vertices, in the unit of the file.
    pub vertices: Vec<Vector3<f64>>,
    /// Tags by which cells refer to the vertices. If it is empty, cells refer to vertices by their indices.
    pub tags: Vec<i64>,
    /// One number per vertex, by name.
    pub point_data: PointData,
    tets: Vec<[i64; 4]>,
    /// First three vertices of each face.
    faces: Vec<[i64; 3]>,
    /// Number of tetrahedra of higher order, by their number of vertices.
    higher_orders: BTreeMap<usize, usize>,
    /// Number of other solids, by name.
    solids: BTreeMap<&'static str, usize>,
}

impl FileContents {
    /// Adds a cell. Returns false if it is a tetrahedron with an invalid number of vertices.
    pub fn add(&mut self, cell: Cell, vertices: &[i64]) -> bool {
        match (cell, vertices) {
            (Cell::Tet, &[a, b, c, d]) => self.tets.push([a, b, c, d]),
            (Cell::HigherTet, &[a, b, c, d, ..]) => {
                self.tets.push([a, b, c, d]);
                *self.higher_orders.entry(vertices.len()).or_default() += 1;
            }
            (Cell::Tet | Cell::HigherTet, _) => return false,
            (Cell::Face, &[a, b, c, ..]) => self.faces.push([a, b, c]),
            (Cell::Face | Cell::Line, _) => {}
            (Cell::Solid(name), _) => *self.solids.entry(name).or_default() += 1,
        }
        true
    }

    /// Returns the mesh and the point data, without the vertices that no tetrahedron uses.
    pub fn into_mesh(self, path: &Path, options: &MeshOptions) -> Result<MeshFile, FileError> {
        self.check_cells(path, options)?;
        let index = self.vertex_indices(path)?;
        let tets = self.tets.iter().enumerate().map(|(tet, corners)| {
            let path = path.into();
            let unknown = |vertex| FileError::UnknownVertex { path, tet, vertex };
            indices(corners, &index).map_err(unknown)
        });
        let tets = tets.collect::<Result<Vec<_>, _>>()?;
        let new_index = used_vertices(&tets, self.vertices.len());
        let is_ignored = |face: &&[i64; 3]| match indices(face, &index) {
            Ok(face) => face.iter().any(|&vertex| new_index[vertex].is_none()),
            Err(_) => true,
        };
        let count = self.faces.iter().filter(is_ignored).count();
        let vertices = kept(self.vertices, &new_index);
        let vertices = vertices.iter().map(|vertex| position(vertex, options));
        let tets = tets
            .iter()
            .map(|tet| tet.map(|v| new_index[v].unwrap_or_default()));
        let mesh = TetMesh::new(vertices.collect(), tets.collect());
        let mesh = mesh.map_err(|source| FileError::Mesh {
            path: path.into(),
            source,
        })?;
        let data = self.point_data.into_iter();
        let data = data.map(|(name, values)| (name, kept(values, &new_index)));
        let mut file = MeshFile {
            mesh,
            point_data: data.collect(),
            warnings: Vec::new(),
            path: path.into(),
        };
        seams::join(&mut file, options.weld_tolerance);
        let warnings = mesh_warnings::of(&file.mesh, options.placement.unit);
        file.warnings.extend(warnings);
        if count > 0 {
            file.warnings.push(FileWarning::IgnoredCells { count });
        }
        Ok(file)
    }

    /// Checks that there are tetrahedra, and no cells that cannot be ignored.
    fn check_cells(&self, path: &Path, options: &MeshOptions) -> Result<(), FileError> {
        let path = path.into();
        if !self.solids.is_empty() {
            let counts = self
                .solids
                .iter()
                .map(|(name, count)| format!("{name}: {count}"));
            let found = counts.collect::<Vec<_>>().join(", ");
            return Err(FileError::OtherSolid { path, found });
        }
        if let Some((&vertex_count, _)) = self.higher_orders.first_key_value()
            && !options.corners_only
        {
            return Err(FileError::HigherOrder {
                path,
                found: self.higher_orders.values().sum(),
                vertex_count,
            });
        }
        if self.tets.is_empty() {
            return Err(FileError::NoTetrahedra { path });
        }
        Ok(())
    }

    /// Returns a function from the tag of a vertex to its index.
    fn vertex_indices(
        &self,
        path: &Path,
    ) -> Result<impl Fn(i64) -> Option<usize> + use<>, FileError> {
        let mut indices = FxHashMap::default();
        for (index, &tag) in self.tags.iter().enumerate() {
            if indices.insert(tag, index).is_some() {
                let path = path.into();
                return Err(FileError::RepeatedTag { path, tag });
            }
        }
        let (has_tags, count) = (!self.tags.is_empty(), self.vertices.len());
        Ok(move |vertex| {
            if has_tags {
                indices.get(&vertex).copied()
            } else {
                usize::try_from(vertex).ok().filter(|&index| index < count)
            }
        })
    }
}

/// Indices of vertices.
///
/// # Errors
/// Returns the first unknown vertex.
fn indices<const N: usize>(
    vertices: &[i64; N],
    index: impl Fn(i64) -> Option<usize>,
) -> Result<[usize; N], i64> {
    let mut indices = [0; N];
    for (known, &vertex) in indices.iter_mut().zip(vertices) {
        *known = index(vertex).ok_or(vertex)?;
    }
    Ok(indices)
}

/// Index of each vertex among the vertices of tetrahedra, or `None` for other vertices.
fn used_vertices(tets: &[[usize; 4]], count: usize) -> Vec<Option<usize>> {
    let mut new_index = vec![None; count];
    for &vertex in tets.as_flattened() {
        new_index[vertex] = Some(0);
    }
    let used = new_index.iter_mut().flatten().enumerate();
    used.for_each(|(new, index)| *index = new);
    new_index
}

/// Position (m) in the body frame. Non-finite coordinates are returned unchanged, so that the error shows their values.
fn position(vertex: &Vector3<f64>, options: &MeshOptions) -> Vector3<f64> {
    if vertex.iter().all(|coordinate| coordinate.is_finite()) {
        options.placement.position(vertex)
    } else {
        *vertex
    }
}

/// Values of the vertices that have a new index.
fn kept<T>(values: Vec<T>, new_index: &[Option<usize>]) -> Vec<T> {
    let values = values.into_iter().zip(new_index);
    values
        .filter(|(_, new)| new.is_some())
        .map(|(value, _)| value)
        .collect()
}
