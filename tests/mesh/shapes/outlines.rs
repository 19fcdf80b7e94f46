//! Solids of revolution, extrusions, tori and compounds: volumes, fields, rates and errors.

use approx::assert_relative_eq;
use hydroelastic::contact::{ContactBody, ContactPair, Partner, Shape};
use hydroelastic::mesh::{MeshError, PressureField, ShapeRates, TriangleSurface, shapes};
use hydroelastic::spatial::Pose;
use nalgebra::vector;
use std::f64::consts::{PI, TAU};

/// Relative error of sums of a few thousand volumes.
const ROUND_OFF: f64 = 1e-12;
/// Relative error of central differences over a change of 1e-6.
const DIFFERENCES: f64 = 1e-6;

/// Profile of a cup with a thin wall and bottom (m).
const CUP: [[f64; 2]; 6] = [
    [0.0, 0.0],
    [0.03, 0.0],
    [0.04, 0.1],
    [0.036, 0.1],
    [0.026, 0.004],
    [0.0, 0.004],
];
/// Concave base of a prism (m), without equal lengths.
const ANGLE: [[f64; 2]; 6] = [
    [0.0, 0.0],
    [0.11, 0.0],
    [0.1, 0.023],
    [0.021, 0.02],
    [0.02, 0.1],
    [0.0, 0.097],
];

fn area(outline: &[[f64; 2]]) -> f64 {
    let next = outline.iter().cycle().skip(1);
    let edges = outline.iter().zip(next);
    edges.map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum::<f64>() / 2.0
}

/// Volume of a profile turned in steps: Pappus' theorem, with the polygon's share of the circle.
fn turned_volume(outline: &[[f64; 2]], segments: usize) -> f64 {
    let next = outline.iter().cycle().skip(1);
    let moments = outline
        .iter()
        .zip(next)
        .map(|(a, b)| (a[0] * b[1] - a[1] * b[0]) * (a[0] + b[0]));
    let count = segments as f64;
    moments.sum::<f64>() / 6.0 * count * (TAU / count).sin()
}

#[test]
fn solids_of_revolution_and_extrusions_have_the_volume_of_their_outlines() {
    let ring = [[0.05, 0.0], [0.08, 0.01], [0.06, 0.03]];
    for profile in [&CUP[..], &ring] {
        let solid = shapes::lathe(profile, 24, 0.006).unwrap();
        let expected = turned_volume(profile, 24);
        assert_relative_eq!(solid.mesh().volume(), expected, max_relative = ROUND_OFF);
        let reversed: Vec<_> = profile.iter().rev().copied().collect();
        let reversed = shapes::lathe(&reversed, 24, 0.006).unwrap();
        assert_relative_eq!(reversed.mesh().volume(), expected, max_relative = ROUND_OFF);
        TriangleSurface::around(solid.mesh()).unwrap();
    }
    let prism = shapes::extrusion(&ANGLE, 0.2, 0.02).unwrap();
    let volume = prism.mesh().volume();
    assert_relative_eq!(volume, area(&ANGLE) * 0.2, max_relative = ROUND_OFF);
    let center = prism.mesh().mass_properties(1.0).unwrap().center_of_mass;
    assert!(center.z.abs() < ROUND_OFF, "{center}");
}

/// The distance inside a box is concave, so that the interpolated distance is at most the exact distance.
#[test]
fn an_extruded_square_has_the_force_of_its_distance() {
    let square = [[-0.1, -0.1], [0.1, -0.1], [0.1, 0.1], [-0.1, 0.1]];
    for resolution in [0.1, 0.04, 0.02] {
        let prism = Shape::new(shapes::extrusion(&square, 0.2, resolution).unwrap());
        for depth in [0.003, 0.01] {
            // ∫ min(depth, distance to the sides) over the face, with the slope modulus/0.1.
            let inner = 0.2 - 2.0 * depth;
            let exact = 1e6 * (0.04 + inner * inner + 0.2 * inner) * depth / 3.0;
            let pose = Pose::from_translation(vector![0.0, 0.0, 0.1 - depth]);
            let body = ContactBody::new(&prism, pose, 1e5).unwrap();
            let pair = ContactPair::new(body, Partner::rigid_half_space(Pose::identity()).unwrap());
            let force = pair.wrench().on_a.force.z;
            assert!(
                0.995 * exact <= force && force <= exact,
                "{force} of {exact}"
            );
        }
    }
}

#[test]
fn a_torus_has_its_volume_and_extent_1_on_the_circle_of_its_tube() {
    let torus = shapes::torus(0.1, 0.03, 64, 32).unwrap();
    let exact = 2.0 * PI * PI * 0.1 * 0.03 * 0.03;
    assert_relative_eq!(torus.mesh().volume(), exact, max_relative = 0.02);
    for (vertex, &extent) in torus.mesh().vertices().iter().zip(torus.extents()) {
        let distance = (vertex.xy().norm() - 0.1).hypot(vertex.z);
        assert_relative_eq!(extent, 1.0 - distance / 0.03, epsilon = ROUND_OFF);
    }
}

/// Compares rates with central differences of fields with one changed number each.
fn check_rates(rates: &[ShapeRates], numbers: &[f64], field: impl Fn(&[f64]) -> PressureField) {
    assert_eq!(rates.len(), numbers.len());
    for (index, rates) in rates.iter().enumerate() {
        let changed = |change: f64| {
            let mut numbers = numbers.to_vec();
            numbers[index] += change;
            field(&numbers)
        };
        let change = 1e-6 * 0.1;
        let (more, less) = (changed(change), changed(-change));
        for vertex in 0..more.mesh().vertex_count() {
            let [high, low] = [&more, &less].map(|field| field.mesh().vertices()[vertex]);
            let error = (high - low) / (2.0 * change) - rates.vertices[vertex];
            assert!(
                error.norm() < DIFFERENCES,
                "number {index}, vertex {vertex}: {error}"
            );
            if !rates.ambiguous.contains(&vertex) {
                let slope = (more.extents()[vertex] - less.extents()[vertex]) / (2.0 * change);
                let error = slope - rates.extents[vertex];
                // Extents rise by up to 100 per meter.
                assert!(
                    error.abs() < 100.0 * DIFFERENCES,
                    "number {index}, vertex {vertex}: {error}"
                );
            }
        }
    }
}

#[test]
fn rates_match_differences_of_the_dimensions() {
    let torus = |numbers: &[f64]| shapes::torus(numbers[0], numbers[1], 8, 5).unwrap();
    check_rates(
        &shapes::torus_rates(0.1, 0.03, 8, 5).unwrap(),
        &[0.1, 0.03],
        torus,
    );
    let outline = |numbers: &[f64]| -> Vec<[f64; 2]> { numbers.as_chunks().0.to_vec() };
    let ring = [[0.05, 0.0], [0.083, 0.011], [0.061, 0.03]];
    let lathe = |numbers: &[f64]| shapes::lathe(&outline(numbers), 5, 0.021).unwrap();
    let rates = shapes::lathe_rates(&ring, 5, 0.021).unwrap();
    check_rates(&rates, ring.as_flattened(), lathe);
    let extrusion = |numbers: &[f64]| {
        let (length, points) = numbers.split_last().unwrap();
        shapes::extrusion(&outline(points), *length, 0.043).unwrap()
    };
    let rates = shapes::extrusion_rates(&ANGLE, 0.21, 0.043).unwrap();
    let numbers = [ANGLE.as_flattened(), &[0.21]].concat();
    check_rates(&rates, &numbers, extrusion);
}

#[test]
fn parts_of_a_compound_keep_their_fields_and_must_not_overlap() {
    let cube = shapes::cuboid([0.1, 0.1, 0.1]).unwrap();
    let at = |x: f64| Pose::from_translation(vector![x, 0.0, 0.0]);
    let touching = shapes::compound(&[(&cube, at(0.0)), (&cube, at(0.1))]).unwrap();
    let volume = touching.mesh().volume();
    assert_relative_eq!(volume, 2e-3, max_relative = ROUND_OFF);
    assert_eq!(
        touching.extents(),
        [cube.extents(), cube.extents()].concat()
    );
    let refused = shapes::compound(&[(&cube, at(0.0)), (&cube, at(0.3)), (&cube, at(0.09))]);
    let Err(MeshError::OverlappingParts { parts, depth, .. }) = refused else {
        panic!("{refused:?}");
    };
    assert_eq!(parts, [0, 2]);
    assert!(depth > 0.0 && depth < 0.0101, "{depth}");
    assert_eq!(shapes::compound(&[]).unwrap_err(), MeshError::Empty);
}

#[test]
fn invalid_dimensions_are_refused() {
    let bow = [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]];
    let fold = [[0.0, 0.0], [1.0, 0.0], [0.5, 0.0], [0.5, 1.0]];
    for outline in [bow, fold, [[0.0; 2]; 4]] {
        let refused = shapes::extrusion(&outline, 1.0, 0.5).unwrap_err();
        assert!(
            matches!(refused, MeshError::TouchingEdges { .. }),
            "{refused}"
        );
    }
    let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    for resolution in [1e-300, 1e-7] {
        let refused = shapes::extrusion(&square, 1e-6, resolution).unwrap_err();
        assert!(
            matches!(refused, MeshError::FineResolution { .. }),
            "{refused}"
        );
    }
    let refused = shapes::lathe(&CUP, 10_000, 0.001).unwrap_err();
    assert!(
        matches!(refused, MeshError::FineResolution { value: 0.001, .. }),
        "{refused}"
    );
    for value in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(shapes::extrusion(&square, value, 0.5).is_err());
        assert!(shapes::extrusion(&square, 1.0, value).is_err());
        assert!(shapes::lathe(&CUP, 8, value).is_err());
        assert!(shapes::torus(value, 0.1, 8, 8).is_err());
        assert!(shapes::torus(1.0, value, 8, 8).is_err());
    }
    for value in [f64::NAN, f64::INFINITY] {
        let refused = shapes::extrusion(&[[0.0, 0.0], [1.0, value], [0.0, 1.0]], 1.0, 0.5);
        assert!(matches!(
            refused,
            Err(MeshError::NonFiniteCoordinate { vertex: 1, .. })
        ));
    }
    let refused = shapes::lathe(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]], 8, 0.5).unwrap_err();
    let expected = MeshError::ProfileRadius {
        point: 0,
        radius: 0.0,
    };
    assert_eq!(refused, expected);
    assert!(shapes::lathe(&CUP, 2, 0.01).is_err());
    assert!(shapes::lathe(&[], 8, 0.01).is_err());
    let (radius, tube_radius) = (0.1, 0.1);
    let refused = shapes::torus(radius, tube_radius, 8, 8).unwrap_err();
    assert_eq!(
        refused,
        MeshError::ThickTube {
            radius,
            tube_radius
        }
    );
}
