//! Seams of tetrahedral meshes: faces that coincide, but do not share vertices. They arise if parts are meshed separately.
//!
//! A seam belongs to the surface of the mesh, so the pressure is zero on it although it lies inside the body.

use super::{FileWarning, MeshFile};
use crate::mesh::{TetMesh, first_in_chain};
use rustc_hash::FxHashSet;

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

/// Returns the first vertex of the chain of each vertex of the surface: neighbors in a chain are at most a tolerance (m) apart. Inner
/// vertices are returned unchanged.
fn first_nearby(mesh: &TetMesh, tolerance: f64) -> Vec<usize> {
    let on_surface = (0..mesh.vertex_count()).filter(|&vertex| mesh.is_on_surface(vertex));
    let on_surface: Vec<usize> = on_surface.collect();
    first_in_chain(mesh.vertices(), &on_surface, tolerance)
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
