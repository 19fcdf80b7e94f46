//! Tracing finds the same pairs as culling.

use super::{Shapes, rigid};
use crate::support::scenes::{Random, grid};
use crate::support::worlds::{at, cuboid, icosphere};
use hydroelastic::contact::{ContactBody, ContactPair, Culling, Partner, Search, Shape};
use hydroelastic::mesh::PressureField;
use hydroelastic::spatial::Pose;
use nalgebra::vector;

/// Tolerance times the area, for polygons that exist in one search only because of round-off.
const SAME: f64 = 1e-12;

fn assert_same_surface(pair: &ContactPair, culling: Culling) {
    let expected = pair.with_search(Search::Culling(culling));
    let (actual, all) = (
        pair.wrench().on_a.to_vector(),
        expected.wrench().on_a.to_vector(),
    );
    assert!((actual - all).amax() <= SAME * all.amax(), "{actual} {all}");
    let area = expected.surface().area();
    assert!((pair.surface().area() - area).abs() <= SAME * area);
}

#[test]
fn all_searches_find_the_same_surface() {
    let shapes = Shapes::mixed();
    shapes.for_pairs(300, 61, |pair, random| {
        assert_same_surface(pair, Culling::default());
        // On a half-space there is no tracing, and both are the same search.
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

/// If a rigid body is wholly inside a compliant body, no triangle crosses the surface of the compliant body.
#[test]
fn a_rigid_body_inside_a_soft_one_is_found() {
    let big = icosphere(1.0, 2);
    let small = rigid(&icosphere(0.2, 1));
    let inside = at(0.3, 0.2, 0.1);
    let a = ContactBody::new(&big, Pose::identity(), 1e5).unwrap();
    let pair = ContactPair::new(a, Partner::rigid(&small, inside).unwrap());
    assert_same_surface(&pair, Culling::default());
    // The whole surface is in contact.
    let triangles = 0..small.surface().triangles().len();
    let areas = triangles.map(|triangle| {
        let [a, b, c] = small.surface().corners(triangle);
        (b - a).cross(&(c - a)).norm() / 2.0
    });
    let area: f64 = areas.sum();
    assert!((pair.surface().area() - area).abs() <= SAME * area);
}

/// The cost depends on the number of polygons, not on the number of triangles of a large surface.
#[test]
fn a_large_rigid_surface_costs_what_is_touched() {
    let ball = icosphere(0.1, 2);
    let fine = rigid(&icosphere(10.0, 6));
    let a = ContactBody::new(&ball, at(0.0, 0.0, 10.09), 1e5);
    let pair = ContactPair::new(a.unwrap(), Partner::rigid(&fine, Pose::identity()).unwrap());
    let work = pair.work_count();
    assert!(work.polygons > 0);
    assert!(work.candidate_pairs <= 8 * work.polygons, "{work:?}");
}

/// The same holds for large triangles: the search examines only pairs at the rim of a triangle and inside it.
#[test]
fn a_large_rigid_triangle_costs_what_is_touched() {
    let ball = icosphere(0.1, 3);
    let cube = rigid(&cuboid([1.0; 3]));
    let below = at(0.0, 0.0, -0.5);
    let mut random = Random::new(63);
    for _ in 0..50 {
        let position = vector![random.between(-0.3, 0.3), random.between(-0.3, 0.3), 0.096];
        let pose = Pose::from_rotation_vector(&random.rotation_vector(), position);
        let a = ContactBody::new(&ball, pose, 1e5).unwrap();
        let pair = ContactPair::new(a, Partner::rigid(&cube, below).unwrap());
        let work = pair.work_count();
        assert!(work.polygons > 0);
        assert!(work.candidate_pairs <= 4 * work.polygons, "{work:?}");
        assert_same_surface(&pair, Culling::default());
    }
}

/// Returns a cube of edge 1.5 about the origin, with pressure only at the vertices with x < 0.
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

/// The search also finds a rigid body that lies mostly in tetrahedra without pressure.
#[test]
fn a_rigid_body_inside_is_found_from_tetrahedra_without_pressure() {
    let half = half_inert_cube();
    let ball = rigid(&icosphere(0.2, 2));
    let mut random = Random::new(64);
    for _ in 0..50 {
        let position = vector![random.between(0.3, 0.4), 0.1, 0.05];
        let pose = Pose::from_rotation_vector(&random.rotation_vector(), position);
        let a = ContactBody::new(&half, Pose::identity(), 1e5).unwrap();
        let pair = ContactPair::new(a, Partner::rigid(&ball, pose).unwrap());
        assert!(!pair.surface().is_empty());
        assert_same_surface(&pair, Culling::default());
    }
}

/// Tetrahedra without pressure exert no force and are no part of the contact surface, no matter which search visits them.
#[test]
fn tetrahedra_without_pressure_are_not_touched() {
    let half = half_inert_cube();
    let ball = rigid(&icosphere(0.6, 1));
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

/// If a rigid body is wholly inside a compliant body, one of its sides may lie in tetrahedra without pressure and another side in
/// tetrahedra with pressure.
#[test]
fn a_rigid_body_half_inside_tetrahedra_without_pressure_is_found() {
    let half = half_inert_cube();
    let small = rigid(&icosphere(0.25, 1));
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
