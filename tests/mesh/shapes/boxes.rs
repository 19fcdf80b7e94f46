//! Cuboids: sizes, volumes, and fields that are the exact distance to the surface.

use super::field_checks::{
    EXACT, NEARLY_DEGENERATE, SUM_ROUND_OFF, assert_relative, assert_sound, extent_at,
    proptest_config, spread_points,
};
use hydroelastic::mesh::shapes;
use nalgebra::Vector3;
use proptest::prelude::*;

#[test]
fn a_cuboid_has_twelve_tetrahedra_and_nine_vertices() {
    for lengths in [
        [1.0, 1.0, 1.0],
        [0.2, 3.0, 1.5],
        [1e-3, 1.0, 1.0],
        [1e-7; 3],
    ] {
        let field = shapes::cuboid(lengths).unwrap();
        assert_eq!(
            (field.mesh().tet_count(), field.mesh().vertex_count()),
            (12, 9)
        );
        assert_sound(&field);
        assert_relative(
            field.mesh().volume(),
            lengths.iter().product(),
            SUM_ROUND_OFF,
        );
        let aabb = field.mesh().aabb();
        assert_eq!(aabb.upper, Vector3::from(lengths) / 2.0);
        assert_eq!(aabb.lower, -aabb.upper);
    }
}

/// Returns the distance (m) from a point in a box about the origin to its surface.
fn distance_in_box(lengths: [f64; 3], point: &Vector3<f64>) -> f64 {
    (Vector3::from(lengths) / 2.0 - point.abs()).min()
}

/// Returns the largest error of the field of a box, relative to the largest distance.
fn error_of_box(lengths: [f64; 3]) -> f64 {
    let field =
        shapes::distance_cuboid(lengths).unwrap_or_else(|error| panic!("{lengths:?}: {error}"));
    assert_sound(&field);
    assert_relative(
        field.mesh().volume(),
        lengths.iter().product(),
        SUM_ROUND_OFF,
    );
    let depth = lengths.iter().copied().fold(f64::INFINITY, f64::min) / 2.0;
    let errors = spread_points(300).map(|point| {
        let point = (point.add_scalar(-0.5)).component_mul(&Vector3::from(lengths));
        (extent_at(&field, &point) - distance_in_box(lengths, &point) / depth).abs()
    });
    errors.fold(0.0, f64::max)
}

fn permutations([a, b, c]: [f64; 3]) -> [[f64; 3]; 6] {
    [
        [a, b, c],
        [a, c, b],
        [b, a, c],
        [b, c, a],
        [c, a, b],
        [c, b, a],
    ]
}

#[test]
fn distance_cuboids_have_the_true_distance() {
    let boxes = [
        [1.0, 2.0, 3.0],
        [1.0, 1.0, 2.5],
        [0.3, 0.7, 0.7],
        [2.0, 2.0, 2.0],
        [0.1, 0.2, 0.3],
        [1.0, 10.0, 10.0],
        [1.0, 1.0, 10.0],
    ];
    for lengths in boxes.into_iter().flat_map(permutations) {
        let error = error_of_box(lengths);
        assert!(error <= EXACT, "{error:e} for {lengths:?}");
    }
}

#[test]
fn distance_cuboids_of_extreme_proportions_have_the_true_distance() {
    let boxes = [
        [1.0, 1000.0, 1000.0],
        [1.0, 1.0, 1000.0],
        [1.0, 30.0, 1000.0],
        [1e-3, 1.0, 1.0],
        [1e-3, 1e-3, 1.0],
    ];
    for lengths in boxes.into_iter().flat_map(permutations) {
        let error = error_of_box(lengths);
        assert!(error <= NEARLY_DEGENERATE, "{error:e} for {lengths:?}");
    }
}

#[test]
fn distance_cuboids_with_nearly_equal_edges_have_the_distance() {
    for step in (1..=16).map(|power| 10.0_f64.powi(-power)) {
        for long in [1.0, 2.0, 100.0] {
            let boxes = [
                [1.0, 1.0 + step, long],
                [1.0, 1.0 + step, 1.0 + step],
                [1.0, 1.0 + step, 1.0 + 2.0 * step],
                [1.0, 1.0 + step, 1.0 + step.sqrt()],
            ];
            for lengths in boxes.into_iter().flat_map(permutations) {
                let error = error_of_box(lengths);
                assert!(error <= NEARLY_DEGENERATE, "{error:e} for {lengths:?}");
            }
        }
    }
}

proptest! {
    #![proptest_config(proptest_config())]

    #[test]
    fn distance_cuboids_exist_for_all_proportions_to_a_thousand(
        logs in prop::array::uniform3(0.0..3.0),
        near in prop::option::of((0_usize..3, 0_usize..3, -16.0..-3.0)),
    ) {
        let mut lengths = logs.map(|log: f64| 10.0_f64.powf(log));
        if let Some((axis, other_axis, log)) = near {
            let step: f64 = 10.0_f64.powf(log);
            lengths[axis] = lengths[other_axis] * (1.0 + step);
        }
        prop_assert!(error_of_box(lengths) <= NEARLY_DEGENERATE);
    }
}
