//! Ready-made shapes: sizes, volumes, and fields that are the true distance to the surface.

use hydroelastic::mesh::{FieldTet, MeshError, PressureField, shapes};
use nalgebra::{Vector3, vector};
use proptest::prelude::*;
use std::collections::BTreeSet;
use std::f64::consts::{PI, TAU};

/// A rounding or two, relative.
const ROUND_OFF: f64 = 1e-15;

/// Sums over many tetrahedra, relative to the result.
const SUM_ROUND_OFF: f64 = 1e-13;

/// A field evaluated at a point, relative to its largest value, in a mesh of ordinary proportions.
const EXACT: f64 = 1e-13;

/// The same where edges of the core are so short beside the shape that gradients lose digits, or
/// where they were left out for that reason.
const NEARLY_DEGENERATE: f64 = 1e-5;

/// How far outside its tetrahedron (in barycentric coordinates) a point on a face may come out.
const ON_FACE: f64 = 1e-9;

fn ball_volume(radius: f64) -> f64 {
    4.0 / 3.0 * PI * radius.powi(3)
}

fn assert_relative(found: f64, expected: f64, tolerance: f64) {
    let error = (found - expected).abs();
    assert!(
        error <= tolerance * expected.abs(),
        "{found:e} is not {expected:e}"
    );
}

/// The extent at a point, from the tetrahedron the point lies deepest in.
fn extent_at(field: &PressureField, point: &Vector3<f64>) -> f64 {
    let depth = |tet: &FieldTet| {
        let coordinates = tet.barycentric.iter().map(|field| field.at(point));
        coordinates.fold(f64::INFINITY, f64::min)
    };
    let deepest = field
        .tets()
        .iter()
        .max_by(|a, b| depth(a).total_cmp(&depth(b)));
    let tet = deepest.unwrap();
    assert!(depth(tet) >= -ON_FACE, "{point} lies in no tetrahedron");
    tet.extent.at(point)
}

/// What every ready-made field promises.
fn assert_sound(field: &PressureField) {
    let mesh = field.mesh();
    for (index, tet) in field.tets().iter().enumerate() {
        assert!(mesh.tetrahedron(index).signed_volume() > 0.0);
        assert!(!tet.is_inert());
        // The surface is where the extent is 0, and faces between three corners of it.
        let faces = [[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]];
        for (index, face) in faces.iter().enumerate() {
            let is_zero = face.iter().all(|&corner| tet.extents[corner] == 0.0);
            assert_eq!(tet.zero_faces & 1 << index != 0, is_zero);
        }
    }
    for (vertex, extent) in field.extents().iter().enumerate() {
        let expected = if mesh.is_on_surface(vertex) {
            0.0_f64
        } else {
            1.0
        };
        assert_eq!(extent.to_bits(), expected.to_bits());
    }
}

// Balls.

#[test]
fn icospheres_have_twenty_times_four_to_the_k_tetrahedra() {
    for (subdivisions, tets) in [20, 80, 320, 1280, 5120, 20480].into_iter().enumerate() {
        let field = shapes::icosphere(0.3, subdivisions).unwrap();
        assert_eq!(field.mesh().tet_count(), tets);
        assert_eq!(field.mesh().surface_triangles().len(), tets);
        // Euler: V − E + F = 2 on the surface, and the centre.
        assert_eq!(field.mesh().vertex_count(), tets / 2 + 2 + 1);
        assert_sound(&field);
    }
}

#[test]
fn surface_vertices_of_an_icosphere_lie_on_the_sphere() {
    for (subdivisions, radius) in [(0, 1.0), (1, 0.1), (2, 7.3), (3, 1e-6), (4, 1e6)] {
        let field = shapes::icosphere(radius, subdivisions).unwrap();
        let (mesh, mut inner) = (field.mesh(), 0);
        for (vertex, position) in mesh.vertices().iter().enumerate() {
            if mesh.is_on_surface(vertex) {
                assert_relative(position.norm(), radius, ROUND_OFF);
            } else {
                assert_eq!(*position, Vector3::zeros());
                inner += 1;
            }
        }
        assert_eq!(inner, 1);
        assert_relative(field.reach(), radius, ROUND_OFF);
    }
}

#[test]
fn icospheres_are_projected_once_at_the_end() {
    // Projecting after every subdivision would give other edge lengths from the second on. The
    // first quarter point of an icosahedron's edge lies at a + (b − a)/4 before projection, so its
    // angle from a is that of 3a + b.
    let cosine = 1.0 / 5.0_f64.sqrt();
    let (sine_part, cosine_part) = ((1.0 - cosine * cosine).sqrt(), 3.0 + cosine);
    let expected = 2.0 * (sine_part.atan2(cosine_part) / 2.0).sin();
    let field = shapes::icosphere(1.0, 2).unwrap();
    let corner = field.mesh().vertices()[0];
    let others = field.mesh().vertices()[1..].iter();
    let nearest = others
        .map(|v| (v - corner).norm())
        .fold(f64::INFINITY, f64::min);
    assert_relative(nearest, expected, SUM_ROUND_OFF);
}

#[test]
fn volumes_of_icospheres_grow_towards_the_ball_in_second_order() {
    let missing = |subdivisions: usize| {
        let volume = shapes::icosphere(0.5, subdivisions)
            .unwrap()
            .mesh()
            .volume();
        1.0 - volume / ball_volume(0.5)
    };
    // The icosahedron with circumradius 1.
    let golden = f64::midpoint(1.0, 5.0_f64.sqrt());
    let edge = 2.0 / (golden * 5.0_f64.sqrt()).sqrt();
    let icosahedron = 5.0 / 12.0 * (3.0 + 5.0_f64.sqrt()) * edge.powi(3);
    assert_relative(
        missing(0),
        1.0 - icosahedron / ball_volume(1.0),
        SUM_ROUND_OFF,
    );
    for subdivisions in 1..6 {
        let ratio = missing(subdivisions - 1) / missing(subdivisions);
        assert!(missing(subdivisions) > 0.0);
        // Towards 4: halved edges leave a quarter of the error.
        assert!((2.5..4.0).contains(&ratio), "{ratio}");
    }
}

#[test]
fn ellipsoids_are_stretched_icospheres() {
    let axes = [0.5, 1.0, 3.0];
    let (ball, ellipsoid) = (shapes::icosphere(1.0, 2), shapes::ellipsoid(axes, 2));
    let (ball, ellipsoid) = (ball.unwrap(), ellipsoid.unwrap());
    assert_sound(&ellipsoid);
    assert_eq!(ball.mesh().tets(), ellipsoid.mesh().tets());
    for (vertex, position) in ellipsoid.mesh().vertices().iter().enumerate() {
        if ellipsoid.mesh().is_on_surface(vertex) {
            let on_ball = position.component_div(&Vector3::from(axes));
            assert_relative(on_ball.norm(), 1.0, ROUND_OFF);
        }
    }
    assert_relative(
        ellipsoid.mesh().volume(),
        1.5 * ball.mesh().volume(),
        SUM_ROUND_OFF,
    );
}

// Boxes.

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

/// Distance (m) from a point in a box about the origin to its surface.
fn distance_in_box(lengths: [f64; 3], point: &Vector3<f64>) -> f64 {
    (Vector3::from(lengths) / 2.0 - point.abs()).min()
}

/// Low-discrepancy points in the unit cube.
fn spread_points(count: usize) -> impl Iterator<Item = Vector3<f64>> {
    // Powers of the reciprocal of the root of x⁴ = x + 1.
    let steps = vector![
        0.819_172_513_396_164_4,
        0.671_043_606_703_789_2,
        0.549_700_477_901_942_6
    ];
    (1..=count).map(move |k| steps.map(|step| (k as f64 * step).fract()))
}

/// Largest error of the field of a box, relative to the largest distance.
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
    #![proptest_config(ProptestConfig {
        failure_persistence: Some(Box::new(
            proptest::test_runner::FileFailurePersistence::WithSource("regressions"),
        )),
        ..ProptestConfig::with_cases(200)
    })]

    #[test]
    fn distance_cuboids_exist_for_all_proportions_to_a_thousand(
        logs in prop::array::uniform3(0.0..3.0),
        near in prop::option::of((0_usize..3, 0_usize..3, -16.0..-3.0)),
    ) {
        let mut lengths = logs.map(|log: f64| 10.0_f64.powf(log));
        if let Some((one, other, log)) = near {
            let step: f64 = 10.0_f64.powf(log);
            lengths[one] = lengths[other] * (1.0 + step);
        }
        prop_assert!(error_of_box(lengths) <= NEARLY_DEGENERATE);
    }

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

// Cylinders.

fn inscribed(radius: f64, segments: usize) -> f64 {
    radius * (PI / segments as f64).cos()
}

/// Distance (m) from a point in the prism to its surface.
fn distance_in_prism(radius: f64, length: f64, segments: usize, point: &Vector3<f64>) -> f64 {
    let to_side = |k: usize| {
        let (sine, cosine) = (TAU * (k as f64 + 0.5) / segments as f64).sin_cos();
        inscribed(radius, segments) - (point.x * cosine + point.y * sine)
    };
    (0..segments)
        .map(to_side)
        .fold(length / 2.0 - point.z.abs(), f64::min)
}

/// Largest error of the field of a cylinder, relative to the largest distance.
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
        // The core is a point: the base fans, and two triangles a side.
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
    // An inscribed polygon misses (2π/n)²/6 of the circle.
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

// Bad input.

#[test]
fn shapes_too_slender_for_round_off_are_refused() {
    let is_flat = |found: Result<PressureField, MeshError>| {
        matches!(found, Err(MeshError::ZeroVolume { .. }))
    };
    assert!(is_flat(shapes::cuboid([1.0, 1.0, 1e-13])));
    assert!(is_flat(shapes::cuboid([1.0, 1e-7, 1e-7])));
    assert!(is_flat(shapes::distance_cuboid([1.0, 1e-7, 1e-7])));
    assert!(is_flat(shapes::cylinder(1e-7, 1.0, 6)));
    assert!(is_flat(shapes::ellipsoid([1.0, 1e-7, 1e-7], 2)));
}

#[test]
fn bad_dimensions_are_named_with_their_value() {
    for bad in [0.0, -1.0, f64::INFINITY, f64::NAN, -0.0, f64::NEG_INFINITY] {
        let is_named = |found: Result<PressureField, MeshError>, expected: &str| {
            matches!(found, Err(MeshError::InvalidDimension { name, value })
                if name == expected && value.to_bits() == bad.to_bits())
        };
        for axis in 0..3 {
            let mut lengths = [1.0, 2.0, 3.0];
            lengths[axis] = bad;
            assert!(is_named(shapes::cuboid(lengths), "edge length"), "{bad}");
            assert!(
                is_named(shapes::distance_cuboid(lengths), "edge length"),
                "{bad}"
            );
            assert!(
                is_named(shapes::ellipsoid(lengths, 1), "semi-axis"),
                "{bad}"
            );
        }
        assert!(is_named(shapes::icosphere(bad, 1), "radius"), "{bad}");
        assert!(is_named(shapes::cylinder(bad, 1.0, 8), "radius"), "{bad}");
        assert!(is_named(shapes::cylinder(1.0, bad, 8), "length"), "{bad}");
    }
    let message = shapes::icosphere(-2.0, 1).unwrap_err().to_string();
    assert_eq!(
        message,
        "the radius of a shape must be positive and finite, but is -2"
    );
}

#[test]
fn bad_resolutions_are_named_with_their_limits() {
    let error = |name, found, lowest, highest| MeshError::InvalidResolution {
        name,
        found,
        lowest,
        highest,
    };
    for found in [11, usize::MAX] {
        let expected = error("subdivisions", found, 0, 8);
        assert_eq!(shapes::icosphere(1.0, found).unwrap_err(), expected);
        assert_eq!(shapes::ellipsoid([1.0; 3], found).unwrap_err(), expected);
    }
    for found in [0, 2, 100_001, usize::MAX] {
        let expected = error("segments", found, 3, 100_000);
        assert_eq!(shapes::cylinder(1.0, 1.0, found).unwrap_err(), expected);
    }
    let message = shapes::cylinder(1.0, 1.0, 2).unwrap_err().to_string();
    assert_eq!(message, "a shape takes 3 to 100000 segments, not 2");
}
