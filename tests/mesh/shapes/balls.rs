//! Icospheres and ellipsoids: vertices, volumes and fields.

use super::field_checks::{SUM_ROUND_OFF, assert_relative, assert_sound};
use hydroelastic::mesh::shapes;
use nalgebra::Vector3;
use std::f64::consts::PI;

/// Relative error of one or two rounding errors.
const ROUND_OFF: f64 = 1e-15;

fn ball_volume(radius: f64) -> f64 {
    4.0 / 3.0 * PI * radius.powi(3)
}

#[test]
fn icospheres_have_twenty_times_four_to_the_k_tetrahedra() {
    for (subdivisions, tets) in [20, 80, 320, 1280, 5120, 20480].into_iter().enumerate() {
        let field = shapes::icosphere(0.3, subdivisions).unwrap();
        assert_eq!(field.mesh().tet_count(), tets);
        assert_eq!(field.mesh().surface_triangles().len(), tets);
        // Euler's formula V − E + F = 2 on the surface, and the center.
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
    // Projection after every subdivision would give other edge lengths from the second subdivision on. Before projection, the first quarter
    // point of an icosahedron's edge is a + (b − a)/4, so its angle from a is that of 3a + b.
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
fn volumes_of_icospheres_grow_toward_the_ball_in_second_order() {
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
        // The ratio tends to 4, because half the edge length gives a quarter of the error.
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
