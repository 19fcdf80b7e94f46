//! The intersection of half-planes as this library has it: what is left of a polygon is clipped by
//! one after the other. A corner is made only on an edge that crosses a border, between its ends, so none
//! is far away.

use super::half_planes::HalfPlane;
use hydroelastic::geometry::{AffineField, ConvexPolygon, Tetrahedron};
use nalgebra::{Vector3, vector};

/// What the clip takes for zero (m): the rounding of a coordinate.
const ROUND_OFF: f64 = 1e-15;

/// A triangle, as the slice of a tetrahedron at z = 0, clipped by each of the half-planes.
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

/// [`HalfPlane::depth`] as a field.
fn depth_field(side: &HalfPlane) -> AffineField {
    let gradient = vector![-side.direction.y, side.direction.x, 0.0];
    AffineField {
        gradient,
        offset: -gradient.xy().dot(&side.point),
    }
}
