//! Following finds what culling finds.

use super::{Shapes, rigid};
use crate::support::scenes::{Random, grid};
use hydroelastic::contact::{ContactBody, ContactPair, Culling, Partner, Search, Shape};
use hydroelastic::mesh::{PressureField, shapes};
use hydroelastic::spatial::Pose;
use nalgebra::vector;

/// Polygons that round-off makes and another search does not, times the area.
const SAME: f64 = 1e-12;

fn assert_same_surface(pair: &ContactPair, culling: Culling) {
    let expected = pair.with_search(Search::Culling(culling));
    let (found, all) = (
        pair.wrench().on_a.to_vector(),
        expected.wrench().on_a.to_vector(),
    );
    assert!((found - all).amax() <= SAME * all.amax(), "{found} {all}");
    let area = expected.surface().area();
    assert!((pair.surface().area() - area).abs() <= SAME * area);
}

#[test]
fn all_searches_find_the_same_surface() {
    let shapes = Shapes::mixed();
    shapes.for_pairs(300, 61, |pair, random| {
        assert_same_surface(pair, Culling::default());
        // On a half-space nothing is followed: both are the same search.
        if random.below(10) == 0 || pair.b().half_space_shape().is_some() {
            assert_same_surface(pair, Culling::NONE);
            let boxes = Culling {
                bounding_boxes: true,
                ..Culling::NONE
            };
            assert_same_surface(pair, boxes);
        }
    });
}

/// Of a rigid body all inside a compliant one no triangle crosses the other's surface.
#[test]
fn a_rigid_body_inside_a_soft_one_is_found() {
    let big = Shape::new(shapes::icosphere(1.0, 2).unwrap());
    let small = rigid(&Shape::new(shapes::icosphere(0.2, 1).unwrap()));
    let inside = Pose::from_translation(vector![0.3, 0.2, 0.1]);
    let a = ContactBody::new(&big, Pose::identity(), 1e5).unwrap();
    let pair = ContactPair::new(a, Partner::rigid(&small, inside).unwrap());
    assert_same_surface(&pair, Culling::default());
    // All of its surface is pressed on.
    let triangles = 0..small.surface().triangles().len();
    let areas = triangles.map(|triangle| {
        let [a, b, c] = small.surface().corners(triangle);
        (b - a).cross(&(c - a)).norm() / 2.0
    });
    let area: f64 = areas.sum();
    assert!((pair.surface().area() - area).abs() <= SAME * area);
}

/// The work is that of the polygons, not of the triangles of a large surface.
#[test]
fn a_large_rigid_surface_costs_what_is_touched() {
    let ball = Shape::new(shapes::icosphere(0.1, 2).unwrap());
    let fine = rigid(&Shape::new(shapes::icosphere(10.0, 6).unwrap()));
    let a = ContactBody::new(&ball, Pose::from_translation(vector![0.0, 0.0, 10.09]), 1e5);
    let pair = ContactPair::new(a.unwrap(), Partner::rigid(&fine, Pose::identity()).unwrap());
    let work = pair.work_count();
    assert!(work.polygons > 0);
    assert!(work.candidate_pairs <= 8 * work.polygons, "{work:?}");
}

/// A cube of edge 1.5 about the origin, without pressure where x < 0.
fn half_inert_cube() -> Shape {
    let field = grid(&[3, 3, 3], 0.5, |_| true).unwrap();
    let mesh = field.mesh().clone();
    let of_half = |vertex: usize| {
        let is_left = mesh.vertices()[vertex].x < 0.0;
        if is_left {
            field.extents()[vertex]
        } else {
            0.0
        }
    };
    let extents = (0..mesh.vertex_count()).map(of_half).collect();
    Shape::new(PressureField::with_inert_tets(mesh.clone(), extents).unwrap())
}

/// Tetrahedra without pressure press on nothing, and are no part of the contact surface, whichever search goes through them.
#[test]
fn tetrahedra_without_pressure_are_not_touched() {
    let half = half_inert_cube();
    let ball = rigid(&Shape::new(shapes::icosphere(0.6, 1).unwrap()));
    let mut random = Random::new(62);
    for _ in 0..50 {
        let pose = Pose::from_rotation_vector(&random.rotation_vector(), random.vector());
        let a = ContactBody::new(&half, Pose::identity(), 1e5).unwrap();
        for b in [
            Partner::rigid(&ball, pose).unwrap(),
            Partner::rigid_half_space(pose).unwrap(),
        ] {
            let pair = ContactPair::new(a, b);
            assert_same_surface(&pair, Culling::default());
            assert_same_surface(&pair, Culling::NONE);
        }
    }
}

/// Of a rigid body all inside a compliant one, one side may be in tetrahedra without pressure, and the other not.
#[test]
fn a_rigid_body_half_inside_tetrahedra_without_pressure_is_found() {
    let half = half_inert_cube();
    let small = rigid(&Shape::new(shapes::icosphere(0.25, 1).unwrap()));
    let (mut random, mut touching) = (Random::new(63), 0);
    for _ in 0..100 {
        let pose = Pose::from_rotation_vector(&random.rotation_vector(), random.vector() * 0.45);
        let a = ContactBody::new(&half, Pose::identity(), 1e5).unwrap();
        let pair = ContactPair::new(a, Partner::rigid(&small, pose).unwrap());
        assert_same_surface(&pair, Culling::default());
        touching += usize::from(!pair.surface().is_empty());
    }
    assert!(touching >= 50, "{touching}");
}
