use super::TetMesh;
use crate::geometry::distance_to_triangle;
use nalgebra::Vector3;

/// For each vertex its distance to the surface over the largest such distance: an extent in
/// [0, 1], 0 on the surface. All zero where no vertex lies inside.
pub(super) fn normalised_distances(mesh: &TetMesh) -> Vec<f64> {
    let surface: Vec<BoundedTriangle> = mesh
        .surface_triangles()
        .iter()
        .map(|triangle| BoundedTriangle::new(triangle.map(|vertex| mesh.vertices()[vertex])))
        .collect();
    let distances: Vec<f64> = (0..mesh.vertex_count())
        .map(|vertex| {
            if mesh.is_on_surface(vertex) {
                0.0
            } else {
                distance_to(&surface, &mesh.vertices()[vertex])
            }
        })
        .collect();
    let largest = distances.iter().copied().fold(0.0, f64::max);
    if largest == 0.0 {
        return distances;
    }
    distances
        .iter()
        .map(|distance| distance / largest)
        .collect()
}

/// A triangle in a ball: most triangles are too far away to matter, and the ball shows it.
struct BoundedTriangle {
    corners: [Vector3<f64>; 3],
    center: Vector3<f64>,
    radius: f64,
}

impl BoundedTriangle {
    fn new(corners: [Vector3<f64>; 3]) -> Self {
        let center = (corners[0] + corners[1] + corners[2]) / 3.0;
        let distances = corners.iter().map(|corner| (corner - center).norm());
        Self {
            corners,
            center,
            radius: distances.fold(0.0, f64::max),
        }
    }
}

fn distance_to(surface: &[BoundedTriangle], point: &Vector3<f64>) -> f64 {
    surface.iter().fold(f64::INFINITY, |nearest, triangle| {
        if (point - triangle.center).norm() - triangle.radius >= nearest {
            return nearest;
        }
        nearest.min(distance_to_triangle(point, &triangle.corners))
    })
}
