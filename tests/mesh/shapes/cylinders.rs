//! Cylinders: sizes, volumes, and fields that are the exact distance to the surface.

use super::field_checks::{
    EXACT, NEARLY_DEGENERATE, SUM_ROUND_OFF, assert_relative, assert_sound, extent_at,
    proptest_config, spread_points,
};
use hydroelastic::mesh::shapes;
use nalgebra::{Vector3, vector};
use proptest::prelude::*;
use std::collections::BTreeSet;
use std::f64::consts::{PI, TAU};

proptest! {
    #![proptest_config(proptest_config())]

    #[test]
    fn cylinders_exist_for_all_proportions_to_a_thousand(
        radius_log in 0.0..3.0,
        length_log in 0.0..3.0,
        segments in 3_usize..40,
        near in prop::option::of(-16.0..-3.0),
    ) {
        let radius = 10.0_f64.powf(radius_log);
        let length = match near {
            Some(log) => 2.0 * inscribed(radius, segments) * (1.0 + 10.0_f64.powf(log)),
            None => 10.0_f64.powf(length_log),
        };
        prop_assert!(error_of_cylinder(radius, length, segments) <= NEARLY_DEGENERATE);
    }
}

fn inscribed(radius: f64, segments: usize) -> f64 {
    radius * (PI / segments as f64).cos()
}

/// Returns the distance (m) from a point in the prism to its surface.
fn distance_in_prism(radius: f64, length: f64, segments: usize, point: &Vector3<f64>) -> f64 {
    let to_side = |k: usize| {
        let (sine, cosine) = (TAU * (k as f64 + 0.5) / segments as f64).sin_cos();
        inscribed(radius, segments) - (point.x * cosine + point.y * sine)
    };
    (0..segments)
        .map(to_side)
        .fold(length / 2.0 - point.z.abs(), f64::min)
}

/// Returns the largest error of the field of a cylinder, relative to the largest distance.
fn error_of_cylinder(radius: f64, length: f64, segments: usize) -> f64 {
    let case = format!("{radius} × {length}, {segments} segments");
    let field = shapes::cylinder(radius, length, segments)
        .unwrap_or_else(|error| panic!("{case}: {error}"));
    assert_sound(&field);
    let base = 0.5 * segments as f64 * radius.powi(2) * (TAU / segments as f64).sin();
    assert_relative(field.mesh().volume(), base * length, SUM_ROUND_OFF);
    let depth = inscribed(radius, segments).min(length / 2.0);
    let error_at = |point: Vector3<f64>| {
        let distance = distance_in_prism(radius, length, segments, &point);
        (distance >= 0.0).then(|| (extent_at(&field, &point) - distance / depth).abs())
    };
    let size = vector![2.0 * radius, 2.0 * radius, length];
    spread_points(200)
        .map(|point| point.add_scalar(-0.5).component_mul(&size))
        .filter_map(error_at)
        .fold(0.0, f64::max)
}

#[test]
fn cylinders_have_the_true_distance() {
    for segments in [3, 4, 5, 6, 12, 31, 100] {
        for length in [0.1, 0.5, 1.0, 1.9, 2.1, 5.0] {
            let error = error_of_cylinder(1.0, length, segments);
            assert!(
                error <= EXACT,
                "{error:e} for length {length}, {segments} segments"
            );
        }
    }
}

#[test]
fn cylinders_as_long_as_wide_have_the_true_distance() {
    for (radius, segments) in [(1.0, 3), (0.3, 6), (0.7, 7), (1.0, 32), (0.1, 100)] {
        let length = 2.0 * inscribed(radius, segments);
        let error = error_of_cylinder(radius, length, segments);
        assert!(error <= EXACT, "{error:e} for {segments} segments");
        let field = shapes::cylinder(radius, length, segments).unwrap();
        // The core is a point. Each segment has one triangle in each base and two on the side.
        assert_eq!(field.mesh().tet_count(), 4 * segments);
        assert_eq!(field.mesh().vertex_count(), 2 * (segments + 1) + 1);
    }
}

#[test]
fn cylinders_nearly_as_long_as_wide_have_the_distance() {
    for power in 1..=16 {
        for (radius, segments) in [(1.0, 3), (0.3, 6), (1.0, 24), (2.0, 200)] {
            for sign in [-1.0, 1.0] {
                let length =
                    2.0 * inscribed(radius, segments) * (1.0 + sign * 10.0_f64.powi(-power));
                let error = error_of_cylinder(radius, length, segments);
                assert!(
                    error <= NEARLY_DEGENERATE,
                    "{error:e} at 1e-{power}, {segments} segments"
                );
            }
        }
    }
}

#[test]
fn cylinders_of_extreme_proportions_have_the_true_distance() {
    for (radius, length) in [(1.0, 1e-3), (1e-3, 1.0), (1e3, 1.0), (1e-6, 1e-3)] {
        for segments in [3, 8, 32] {
            let error = error_of_cylinder(radius, length, segments);
            assert!(
                error <= NEARLY_DEGENERATE,
                "{error:e} for {radius} × {length}, {segments} segments"
            );
        }
    }
}

#[test]
fn cylinders_with_many_segments_approach_the_round_one() {
    let field = shapes::cylinder(0.5, 2.0, 2000).unwrap();
    assert_sound(&field);
    let round = PI * 0.25 * 2.0;
    // An inscribed polygon omits (2π/n)²/6 of the circle.
    assert_relative(
        field.mesh().volume(),
        round * (1.0 - (TAU / 2000.0).powi(2) / 6.0),
        1e-11,
    );
    assert_relative(error_of_cylinder(0.5, 2.0, 2000) + 1.0, 1.0, EXACT);
    let ends: BTreeSet<u64> = field
        .mesh()
        .vertices()
        .iter()
        .map(|v| v.z.abs().to_bits())
        .collect();
    assert!(ends.contains(&1.0_f64.to_bits()));
}

#[test]
fn cylinders_with_many_segments_exist_at_all_lengths() {
    let segments = 20_000;
    for power in [2, 4, 6, 9, 12] {
        for sign in [-1.0, 1.0] {
            let stretch = 1.0 + sign * 10.0_f64.powi(-power);
            let length = 2.0 * inscribed(1.0, segments) * stretch;
            assert_sound(&shapes::cylinder(1.0, length, segments).unwrap());
        }
    }
}
