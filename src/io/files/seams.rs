//! Seams of tetrahedral meshes: faces that coincide, but do not share vertices. They arise if parts are meshed separately.
//!
//! A seam belongs to the surface of the mesh, so the pressure is zero on it although it lies inside the body.

use super::{FileWarning, MeshFile};
use crate::mesh::TetMesh;
use nalgebra::Vector3;
use rustc_hash::{FxHashMap, FxHashSet};

/// Distance between vertices up to which a seam is reported, divided by the size of the mesh. Files in single precision have
/// duplicated vertices that differ by less.
const REPORTED: f64 = 1e-6;

/// Joins seams by merging vertices within a tolerance (m), if the result is a valid mesh. Reports joined seams and the seams that
/// remain.
pub(super) fn join(file: &mut MeshFile, tolerance: f64) {
    let first = first_nearby(&file.mesh, tolerance);
    let pair_count = coincident_faces(&file.mesh, &first).len();
    if pair_count > 0
        && let Some(welded) = welded(&file.mesh, &first)
    {
        let vertex_count = file.mesh.vertex_count() - welded.vertex_count();
        file.mesh = welded;
        for values in file.point_data.values_mut() {
            let mut vertex = 0..;
            values.retain(|_| vertex.next().is_some_and(|vertex| first[vertex] == vertex));
        }
        file.warnings.push(FileWarning::WeldedVertices {
            vertex_count,
            pair_count,
        });
    }
    let size = 2.0 * file.mesh.aabb().half_extents().amax();
    let first = first_nearby(&file.mesh, tolerance.max(REPORTED * size));
    let seam = coincident_faces(&file.mesh, &first);
    let Some(corner) = seam.first().map(|face| face[0]) else {
        return;
    };
    let vertices = file.mesh.vertices();
    let joined = seam.as_flattened().iter();
    let distances = joined.map(|&vertex| (vertices[vertex] - vertices[first[vertex]]).norm());
    file.warnings.push(FileWarning::Seam {
        pair_count: seam.len(),
        distance: distances.fold(0.0, f64::max),
        at: vertices[corner],
    });
}

/// Returns the first vertex within a tolerance (m) of each vertex of the surface. Inner vertices are returned unchanged.
fn first_nearby(mesh: &TetMesh, tolerance: f64) -> Vec<usize> {
    let vertices = mesh.vertices();
    let mut cells: FxHashMap<[u64; 3], Vec<usize>> = FxHashMap::default();
    let first = |(vertex, position): (usize, &Vector3<f64>)| {
        if !mesh.is_on_surface(vertex) {
            return vertex;
        }
        let nearby = cells_around(position, tolerance);
        let mut candidates = nearby.iter().filter_map(|cell| cells.get(cell)).flatten();
        let near = candidates.find(|&&other| (vertices[other] - position).norm() <= tolerance);
        if let Some(&near) = near {
            return near;
        }
        cells
            .entry(cell(position, tolerance))
            .or_default()
            .push(vertex);
        vertex
    };
    vertices.iter().enumerate().map(first).collect()
}

/// Cell of a grid whose cells are wider than twice the tolerance (m). With a tolerance of zero, each position is a cell.
fn cell(position: &Vector3<f64>, tolerance: f64) -> [u64; 3] {
    let width = 4.0 * tolerance;
    let coordinate = |x: f64| if width > 0.0 { (x / width).floor() } else { x };
    // Adding zero maps −0 to +0.
    std::array::from_fn(|axis| (coordinate(position[axis]) + 0.0).to_bits())
}

/// Cells that are within a tolerance (m) of a position.
fn cells_around(position: &Vector3<f64>, tolerance: f64) -> Vec<[u64; 3]> {
    let corner = |k: u8| {
        Vector3::from_fn(|axis, _| {
            if k >> axis & 1 == 1 {
                tolerance
            } else {
                -tolerance
            }
        })
    };
    let mut cells: Vec<_> = (0..8)
        .map(|k| cell(&(position + corner(k)), tolerance))
        .collect();
    cells.sort_unstable();
    cells.dedup();
    cells
}

/// Surface triangles that coincide with a previous one if each vertex is replaced by the first nearby vertex.
fn coincident_faces(mesh: &TetMesh, first: &[usize]) -> Vec<[usize; 3]> {
    let mut previous = FxHashSet::default();
    let mut faces = mesh.surface_triangles().to_vec();
    faces.retain(|face| {
        let mut key = face.map(|vertex| first[vertex]);
        key.sort_unstable();
        key[0] != key[1] && key[1] != key[2] && !previous.insert(key)
    });
    faces
}

/// Returns the mesh in which each vertex is replaced by the first nearby vertex, or `None` if that is not a valid mesh.
fn welded(mesh: &TetMesh, first: &[usize]) -> Option<TetMesh> {
    let mut new_index = vec![0; first.len()];
    let mut vertices = Vec::new();
    for (vertex, position) in mesh.vertices().iter().enumerate() {
        if first[vertex] == vertex {
            new_index[vertex] = vertices.len();
            vertices.push(*position);
        }
    }
    let tets = mesh
        .tets()
        .iter()
        .map(|tet| tet.map(|vertex| new_index[first[vertex]]));
    TetMesh::new(vertices, tets.collect()).ok()
}
