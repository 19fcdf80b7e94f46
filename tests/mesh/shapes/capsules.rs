//! Capsules: sizes, volumes, and fields that approach the distance to the surface.

use super::field_checks::{SUM_ROUND_OFF, assert_relative, assert_sound, extent_at, spread_points};
use hydroelastic::mesh::shapes;
use nalgebra::{Vector3, vector};
use std::f64::consts::PI;

/// Error of the field of a polyhedron with 64 sides, relative to its largest value. It is the relative height of a segment of a circle,
/// (π/64)²/2, of both the ring and the meridian.
const POLYHEDRON: f64 = 2.5e-3;

#[test]
fn capsules_have_valid_fields_at_all_proportions() {
    for (radius, length) in [
        (1.0, 1.0),
        (1.0, 1e-3),
        (1e-3, 1.0),
        (1e3, 1e-6),
        (1e-6, 1e-6),
    ] {
        for segments in [3, 4, 5, 16, 33] {
            assert_sound(&shapes::capsule(radius, length, segments).unwrap());
        }
    }
}

#[test]
fn capsules_reach_to_their_poles_and_to_their_sides() {
    let field = shapes::capsule(0.5, 2.0, 16).unwrap();
    let vertices = field.mesh().vertices();
    let largest = |f: fn(&Vector3<f64>) -> f64| vertices.iter().map(f).fold(0.0, f64::max);
    assert_relative(largest(|v| v.z), 1.5, SUM_ROUND_OFF);
    assert_relative(largest(|v| -v.z), 1.5, SUM_ROUND_OFF);
    assert_relative(largest(|v| v.xy().norm()), 0.5, SUM_ROUND_OFF);
    for vertex in vertices {
        let end = vertex.z.clamp(-1.0, 1.0);
        let distance = (vertex - end * Vector3::z()).norm();
        assert!(
            distance == 0.0 || (distance - 0.5).abs() <= SUM_ROUND_OFF,
            "{vertex}"
        );
    }
}

#[test]
fn the_volume_converges_with_the_square_of_the_segments() {
    let (radius, length) = (0.5, 2.0);
    let round = PI * radius * radius * (length + 4.0 / 3.0 * radius);
    let error = |segments| {
        let volume = shapes::capsule(radius, length, segments)
            .unwrap()
            .mesh()
            .volume();
        round - volume
    };
    let ratio = error(64) / error(128);
    assert!((ratio - 4.0).abs() < 0.02, "{ratio}");
    assert!(error(128) > 0.0 && error(128) < 1e-3 * round);
}

#[test]
fn the_field_of_a_capsule_is_nearly_the_distance_to_the_surface() {
    let (radius, length) = (0.5, 2.0);
    let field = shapes::capsule(radius, length, 64).unwrap();
    for point in spread_points(2000) {
        let point = (point - vector![0.5, 0.5, 0.5]).component_mul(&vector![1.0, 1.0, 3.0]);
        let end = point.z.clamp(-length / 2.0, length / 2.0);
        let depth = 1.0 - (point - end * Vector3::z()).norm() / radius;
        if depth > POLYHEDRON {
            let error = extent_at(&field, &point) - depth;
            assert!(error.abs() <= POLYHEDRON, "{error:e} at {point}");
        }
    }
}
