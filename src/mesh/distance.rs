use super::TetMesh;
use super::surface_tree::SurfaceTree;
use crate::threads;

/// For each vertex its distance (m) to the surface: 0 on it.
pub(super) fn distances(mesh: &TetMesh) -> Vec<f64> {
    let tree = SurfaceTree::of(mesh);
    threads::values_of(mesh.vertex_count(), |vertex| {
        if mesh.is_on_surface(vertex) {
            0.0
        } else {
            tree.distance_to(&mesh.vertices()[vertex])
        }
    })
}

/// Over the largest of them: in [0, 1]. All zero where no vertex lies inside.
pub(super) fn normalized(mut distances: Vec<f64>) -> Vec<f64> {
    let largest = distances.iter().copied().fold(0.0, f64::max);
    if largest > 0.0 {
        for distance in &mut distances {
            *distance /= largest;
        }
    }
    distances
}
