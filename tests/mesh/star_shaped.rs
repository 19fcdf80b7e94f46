//! Solids inside closed triangle surfaces, filled from a point that sees the whole surface.

use hydroelastic::contact::{ContactBody, ContactPair, Shape};
use hydroelastic::mesh::{MeshError, PressureField, TriangleSurface, shapes};
use hydroelastic::spatial::Pose;
use nalgebra::{Vector3, vector};
use proptest::prelude::*;
use std::collections::BTreeSet;

/// Relative rounding error of sums over some hundred tetrahedra.
const SUM_ROUND_OFF: f64 = 1e-13;

/// Difference, relative to the largest component, of wrenches of equal fields whose centers differ by rounding.
const SAME_WRENCH: f64 = 1e-12;

fn surface_of(field: &PressureField) -> TriangleSurface {
    TriangleSurface::around(field.mesh()).unwrap()
}

/// Extrudes a polygon in the plane z = 0, given with its triangles, to z = 1.
fn prism(polygon: &[[f64; 2]], caps: &[[usize; 3]]) -> TriangleSurface {
    let count = polygon.len();
    let level = |z: f64| polygon.iter().map(move |&[x, y]| vector![x, y, z]);
    let sides = (0..count).flat_map(|here| {
        let next = (here + 1) % count;
        [
            [here, next, count + next],
            [here, count + next, count + here],
        ]
    });
    let bottom = caps.iter().map(|&[a, b, c]| [a, c, b]);
    let top = caps.iter().map(|cap| cap.map(|vertex| count + vertex));
    let triangles = bottom.chain(top).chain(sides).collect();
    let vertices = level(0.0).chain(level(1.0)).collect();
    TriangleSurface::new(vertices, triangles).unwrap()
}

/// Returns two arms of length 3 and width 1. The shape is star-shaped about any point of the square in which the arms meet.
fn letter_l() -> TriangleSurface {
    let polygon = [
        [0.0, 0.0],
        [3.0, 0.0],
        [3.0, 1.0],
        [1.0, 1.0],
        [1.0, 3.0],
        [0.0, 3.0],
    ];
    prism(&polygon, &[[0, 1, 3], [1, 2, 3], [0, 3, 5], [3, 4, 5]])
}

fn cube() -> TriangleSurface {
    surface_of(&shapes::cuboid([1.0; 3]).unwrap())
}

fn assert_relative(actual: f64, expected: f64, tolerance: f64) {
    let error = (actual - expected).abs();
    assert!(
        error <= tolerance * expected.abs(),
        "{actual:e} is not {expected:e}"
    );
}

// Valid results.

#[test]
fn a_tetrahedron_has_the_volume_and_center_of_the_textbook() {
    let vertices = vec![
        vector![1.0, 1.0, 1.0],
        vector![1.5, 1.0, 1.0],
        vector![1.0, 1.25, 1.0],
        vector![1.0, 1.0, 3.0],
    ];
    let triangles = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    let tetrahedron = TriangleSurface::new(vertices, triangles).unwrap();
    let field = shapes::star_shaped(&tetrahedron).unwrap();
    let mass = field.mesh().mass_properties(1.0).unwrap();
    assert_relative(mass.mass, 0.5 * 0.25 * 2.0 / 6.0, SUM_ROUND_OFF);
    let center = vector![1.125, 1.0625, 1.5];
    assert!((mass.center_of_mass - center).amax() <= SUM_ROUND_OFF);
    assert!((field.mesh().vertices()[4] - center).amax() <= SUM_ROUND_OFF);
    assert_eq!(field.extents(), [0.0, 0.0, 0.0, 0.0, 1.0]);
}

#[test]
fn the_surface_of_an_icosphere_gives_the_icosphere() {
    let sphere = shapes::icosphere(0.3, 3).unwrap();
    let field = shapes::star_shaped_about(Vector3::zeros(), &surface_of(&sphere)).unwrap();
    assert_eq!(field.mesh().vertices(), sphere.mesh().vertices());
    assert_eq!(field.extents(), sphere.extents());
    let corners = |field: &PressureField| {
        let sorted = field.mesh().tets().iter().map(|tet| {
            let mut sorted = *tet;
            sorted.sort_unstable();
            sorted
        });
        sorted.collect::<BTreeSet<_>>()
    };
    assert_eq!(corners(&field), corners(&sphere));
}

#[test]
fn the_surface_of_a_box_is_pressed_as_the_box() {
    let box_itself = shapes::cuboid([0.3, 0.2, 0.1]).unwrap();
    let field = shapes::star_shaped(&surface_of(&box_itself)).unwrap();
    let [ours, expected] = [field, box_itself].map(Shape::new);
    let ball = Shape::new(shapes::icosphere(0.1, 2).unwrap());
    for turn in [
        vector![0.0, 0.0, 0.0],
        vector![0.3, -0.2, 0.5],
        vector![1.0, 1.0, -2.0],
    ] {
        let ball = ContactBody::new(
            &ball,
            Pose::from_translation(vector![0.02, 0.01, 0.13]),
            1e5,
        );
        let wrench = |shape: &Shape| {
            let pose = Pose::from_rotation_vector(&turn, Vector3::zeros());
            let block = ContactBody::new(shape, pose, 1e6).unwrap();
            ContactPair::new(ball.unwrap(), block).wrench().on_a
        };
        let (actual, expected) = (wrench(&ours), wrench(&expected));
        let largest = expected.force.amax();
        assert!(largest > 1.0, "no contact at {turn}");
        assert!((actual.force - expected.force).amax() <= SAME_WRENCH * largest);
        assert!((actual.torque - expected.torque).amax() <= SAME_WRENCH * largest);
    }
}

proptest! {
    #[test]
    fn bumpy_balls_have_the_volume_under_their_triangles(
        radii in prop::collection::vec(0.2..2.0, 42),
        shift in prop::array::uniform3(-5.0..5.0),
    ) {
        let ball = surface_of(&shapes::icosphere(1.0, 1).unwrap());
        let bumpy = ball.vertices().iter().zip(&radii).map(|(direction, radius)| direction * *radius);
        let bumpy: Vec<Vector3<f64>> = bumpy.collect();
        let expected: f64 = ball.triangles().iter().map(|triangle| {
            let [a, b, c] = triangle.map(|vertex| bumpy[vertex]);
            a.dot(&b.cross(&c)) / 6.0
        }).sum();
        let shift = Vector3::from(shift);
        let shifted = bumpy.iter().map(|vertex| vertex + shift).collect();
        let shifted = TriangleSurface::new(shifted, ball.triangles().to_vec()).unwrap();
        let field = shapes::star_shaped_about(shift, &shifted).unwrap();
        prop_assert!((field.mesh().volume() - expected).abs() <= SUM_ROUND_OFF * 100.0 * expected);
        prop_assert_eq!(field.mesh().surface_triangles().len(), ball.triangles().len());
    }
}

#[test]
fn a_solid_can_be_filled_from_a_point_where_its_center_will_not_do() {
    // The center of volume, (1.1, 1.1), is outside.
    let refused = shapes::star_shaped(&letter_l()).unwrap_err();
    assert!(
        matches!(refused, MeshError::HiddenTriangle { .. }),
        "{refused}"
    );
    let field = shapes::star_shaped_about(vector![0.5, 0.5, 0.5], &letter_l()).unwrap();
    assert_relative(field.mesh().volume(), 5.0, SUM_ROUND_OFF);
}

// Rejected input.

#[test]
fn a_hidden_triangle_is_named_with_its_distance() {
    let outside = vector![0.0, 0.0, 0.75];
    let error = shapes::star_shaped_about(outside, &cube());
    let Err(MeshError::HiddenTriangle { triangle, distance }) = error else {
        panic!("expected HiddenTriangle")
    };
    let top = cube().corners(triangle).map(|corner| corner.z);
    assert_eq!(top.map(f64::to_bits), [0.5_f64.to_bits(); 3]);
    assert_relative(distance, 0.25, SUM_ROUND_OFF);
    let bad = shapes::star_shaped_about(vector![0.0, f64::NAN, 0.0], &cube());
    assert!(matches!(bad, Err(MeshError::NonFiniteInnerPoint { .. })));
}

#[test]
fn an_inner_point_in_the_plane_of_a_triangle_is_named_with_it() {
    let on_top = vector![0.0, 0.0, 0.5];
    let error = shapes::star_shaped_about(on_top, &cube());
    let Err(MeshError::TriangleSeenEdgeOn { triangle, volume }) = error else {
        panic!("expected TriangleSeenEdgeOn")
    };
    assert!(volume.abs() <= SUM_ROUND_OFF);
    let top = cube().corners(triangle).map(|corner| corner.z);
    assert_eq!(top.map(f64::to_bits), [0.5_f64.to_bits(); 3]);
}

#[test]
fn a_surface_within_a_surface_is_refused() {
    let inner = surface_of(&shapes::icosphere(0.5, 1).unwrap());
    let outer = inner.vertices().iter().map(|vertex| vertex * 2.0);
    let vertices: Vec<_> = inner.vertices().iter().copied().chain(outer).collect();
    let count = inner.vertices().len();
    let shifted = inner.triangles().iter().map(|t| t.map(|v| v + count));
    let triangles: Vec<_> = inner.triangles().iter().copied().chain(shifted).collect();
    let both = TriangleSurface::new(vertices, triangles).unwrap();
    assert_eq!(
        shapes::star_shaped(&both).unwrap_err().to_string(),
        "the surface surrounds the inner point 2 times, but must do so once"
    );
}

#[test]
fn a_solid_with_a_cavity_is_refused() {
    let outer = surface_of(&shapes::icosphere(1.0, 1).unwrap());
    let count = outer.vertices().len();
    let inner = outer.vertices().iter().map(|vertex| vertex * 0.5);
    let vertices = outer.vertices().iter().copied().chain(inner).collect();
    let inward = outer
        .triangles()
        .iter()
        .map(|&[a, b, c]| [a, c, b].map(|v| v + count));
    let triangles = outer.triangles().iter().copied().chain(inward).collect();
    let hollow = TriangleSurface::new(vertices, triangles).unwrap();
    let refused = shapes::star_shaped(&hollow).unwrap_err();
    let MeshError::HiddenTriangle { triangle, .. } = refused else {
        panic!("{refused}")
    };
    assert!(triangle >= outer.triangles().len());
}
