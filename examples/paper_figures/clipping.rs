//! The intersection of half-planes as in this library: a polygon is clipped by one half-plane after the other. A new corner always lies on
//! an edge that crosses a border, between the ends of the edge, so no corner is far away.

use super::half_planes::HalfPlane;
use hydroelastic::geometry::{AffineField, ConvexPolygon, Tetrahedron};
use nalgebra::{Vector3, vector};

/// Tolerance of clipping (m): the rounding error of a coordinate.
const ROUND_OFF: f64 = 1e-15;

/// Returns a triangle, the slice of a tetrahedron at z = 0, clipped by each of the half-planes.
pub fn clipped(triangle: [[f64; 2]; 3], sides: &[HalfPlane; 3]) -> ConvexPolygon {
    let [a, b, c] = triangle.map(|[x, y]| vector![2.0 * x, 2.0 * y, -1.0]);
    let tetrahedron = Tetrahedron {
        corners: [a, b, c, Vector3::z()],
    };
    let whole = tetrahedron.sliced(&[-1.0, -1.0, -1.0, 1.0]);
    let bits = [0b1_0000, 0b10_0000, 0b100_0000];
    sides.iter().zip(bits).fold(whole, |polygon, (side, bit)| {
        polygon.clipped(&depth_field(side), ROUND_OFF, bit)
    })
}

/// Returns [`HalfPlane::depth`] as a field.
fn depth_field(side: &HalfPlane) -> AffineField {
    let gradient = vector![-side.direction.y, side.direction.x, 0.0];
    AffineField {
        gradient,
        offset: -gradient.xy().dot(&side.point),
    }
}
