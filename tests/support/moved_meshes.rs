//! Meshes whose vertices move, for differences.

use hydroelastic::mesh::TetMesh;
use nalgebra::Vector3;

/// Where vertices have come to after a time, at these velocities.
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

/// The mesh whose vertices have moved so.
pub fn moved_mesh(mesh: &TetMesh, velocities: &[Vector3<f64>], time: f64) -> TetMesh {
    let vertices = moved_vertices(mesh.vertices(), velocities, time);
    TetMesh::new(vertices, mesh.tets().to_vec()).unwrap()
}
