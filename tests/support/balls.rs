//! Balls that are fine enough at two poles to have the contact of a smooth sphere there.

use hydroelastic::contact::Shape;
use hydroelastic::mesh::{PressureField, TetMesh};
use nalgebra::Vector3;
use std::f64::consts::{PI, TAU};

/// Returns a ball about the z axis whose rings are dense at both poles. Its field is 1 − r/R as in an icosphere. Chords cut off the
/// sphere's arcs; the rings have a larger radius that compensates for this on average.
///
/// `segments` is the number of triangles around the axis, and `rings` the number of rings from a pole to the equator.
pub fn fine_ball(radius: f64, segments: usize, rings: usize) -> Shape {
    let mut vertices = vec![Vector3::new(0.0, 0.0, -radius)];
    let mut tets = Vec::new();
    let angles: Vec<f64> = ring_angles(rings).collect();
    for (ring, angle) in angles.iter().enumerate() {
        let before = if ring == 0 { 0.0 } else { angles[ring - 1] };
        let after = angles.get(ring + 1).copied().unwrap_or(PI);
        let stand_off = 1.0 + ((angle - before).powi(2) + (after - angle).powi(2)) / 24.0;
        for k in 0..segments {
            let around = TAU * k as f64 / segments as f64;
            let (z, across) = (-angle.cos(), angle.sin() / polygon_shrinkage(segments));
            let direction = Vector3::new(across * around.cos(), across * around.sin(), z);
            vertices.push(direction * (stand_off * radius));
        }
    }
    let (top, center) = (vertices.len(), vertices.len() + 1);
    vertices.push(Vector3::new(0.0, 0.0, radius));
    vertices.push(Vector3::zeros());
    let at = |ring: usize, k: usize| 1 + ring * segments + k % segments;
    for k in 0..segments {
        tets.push([center, 0, at(0, k + 1), at(0, k)]);
        tets.push([
            center,
            top,
            at(angles.len() - 1, k),
            at(angles.len() - 1, k + 1),
        ]);
        for ring in 1..angles.len() {
            let [a, b] = [at(ring - 1, k), at(ring - 1, k + 1)];
            let [c, d] = [at(ring, k), at(ring, k + 1)];
            tets.extend([[center, a, b, d], [center, a, d, c]]);
        }
    }
    let mut extents = vec![0.0; vertices.len()];
    extents[center] = 1.0;
    let mesh = TetMesh::new(vertices, tets).unwrap();
    Shape::new(PressureField::new(mesh, extents).unwrap())
}

/// Yields angles from the south pole, which grow with a power and are mirrored at the equator.
fn ring_angles(rings: usize) -> impl Iterator<Item = f64> {
    let south = (1..=rings).map(move |ring| PI / 2.0 * (ring as f64 / rings as f64).powi(2));
    let north = south.clone().rev().skip(1).map(|angle| PI - angle);
    south.chain(north)
}

/// Returns the square root of the area of a regular polygon divided by that of its circumscribed circle.
fn polygon_shrinkage(segments: usize) -> f64 {
    let step = TAU / segments as f64;
    (step.sin() / step).sqrt()
}
