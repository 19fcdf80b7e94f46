//! Checks of the number, the indices and the shapes of the triangles of a surface.

use super::SurfaceError;
use nalgebra::Vector3;

/// Thinness tolerance: the smallest ratio of a triangle's height over its longest edge to that edge. A thinner triangle
/// has a normal with fewer than four correct digits, like the gradients of a flat tetrahedron.
const THINNESS: f64 = 1e-12;

/// Checks that there are at least 4 triangles, and that a `u32` can count triangles and vertices.
pub(super) fn check_size(vertex_count: usize, triangle_count: usize) -> Result<(), SurfaceError> {
    let (count, limit) = (vertex_count.max(triangle_count), u32::MAX as usize);
    if triangle_count < 4 {
        let count = triangle_count;
        Err(SurfaceError::TooFewTriangles { count })
    } else if count > limit {
        Err(SurfaceError::TooLarge { count, limit })
    } else {
        Ok(())
    }
}

/// Checks that all vertex indices are in range.
pub(super) fn check_range(
    triangles: &[[usize; 3]],
    vertex_count: usize,
) -> Result<(), SurfaceError> {
    for (triangle, corners) in triangles.iter().enumerate() {
        if let Some(&vertex) = corners.iter().find(|&&vertex| vertex >= vertex_count) {
            return Err(SurfaceError::VertexOutOfRange {
                triangle,
                vertex,
                vertex_count,
            });
        }
    }
    Ok(())
}

/// Checks that each triangle has three different corners, and that all vertices are used.
pub(super) fn check_corners(
    triangles: &[[usize; 3]],
    vertex_count: usize,
) -> Result<(), SurfaceError> {
    let mut used = vec![false; vertex_count];
    for (triangle, corners) in triangles.iter().enumerate() {
        for (corner, &vertex) in corners.iter().enumerate() {
            if corners[..corner].contains(&vertex) {
                return Err(SurfaceError::RepeatedVertex { triangle, vertex });
            }
            used[vertex] = true;
        }
    }
    match used.iter().position(|used| !used) {
        Some(vertex) => Err(SurfaceError::UnusedVertex { vertex }),
        None => Ok(()),
    }
}

/// Checks that a triangle is not degenerate to within rounding error, and that its area does not underflow.
pub(super) fn check_thickness(
    triangle: usize,
    corners: [Vector3<f64>; 3],
) -> Result<(), SurfaceError> {
    if is_thin(corners) {
        let [at, ..] = corners;
        Err(SurfaceError::ThinTriangle { triangle, at })
    } else {
        Ok(())
    }
}

/// Returns true if a triangle is degenerate to within rounding error, or its area underflows.
pub(super) fn is_thin([a, b, c]: [Vector3<f64>; 3]) -> bool {
    let twice_area = (b - a).cross(&(c - a)).norm();
    let edges = [b - a, c - b, a - c];
    let longest_edge = edges.iter().map(nalgebra::Matrix::norm).fold(0.0, f64::max);
    // Not `<=` alone, so that NaN is thin.
    twice_area <= THINNESS * longest_edge.powi(2) || twice_area.is_nan()
}
