//! Meshes with moving vertices, for differences.

use hydroelastic::mesh::TetMesh;
use nalgebra::Vector3;

/// Returns the vertices after a time at these velocities.
pub fn moved_vertices(
    vertices: &[Vector3<f64>],
    velocities: &[Vector3<f64>],
    time: f64,
) -> Vec<Vector3<f64>> {
    let pairs = vertices.iter().zip(velocities);
    pairs
        .map(|(vertex, velocity)| vertex + velocity * time)
        .collect()
}

/// Returns the mesh after a time at these velocities of its vertices.
pub fn moved_mesh(mesh: &TetMesh, velocities: &[Vector3<f64>], time: f64) -> TetMesh {
    let vertices = moved_vertices(mesh.vertices(), velocities, time);
    TetMesh::new(vertices, mesh.tets().to_vec()).unwrap()
}
