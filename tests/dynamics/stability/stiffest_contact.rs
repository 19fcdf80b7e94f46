//! The largest stable time step depends on the stiffest contact, and not on the origins of frames.

use super::scenes::{EDGE, FOUND, assert_close, cube_on_slab, falling_cube, limit, slab};
use crate::scenes::{at, box_shape};
use crate::support::worlds::{dynamic, rubbing};
use hydroelastic::contact::Shape;
use hydroelastic::dynamics::{Body, Material, Plan, RolloutError, World};
use hydroelastic::mesh::{PressureField, TetMesh, shapes};
use hydroelastic::spatial::Pose;
use nalgebra::{Vector3, vector};

#[test]
fn nothing_that_touches_is_no_limit() {
    let falling = falling_cube();
    assert!(
        falling
            .largest_stable_step(&falling.initial_state())
            .unwrap()
            .is_none()
    );
    let pressed = cube_on_slab(Material::elastic(1e6), 0.01);
    let ignoring = pressed.with_ignored("cube", "slab").unwrap();
    assert!(
        ignoring
            .largest_stable_step(&ignoring.initial_state())
            .unwrap()
            .is_none()
    );
    // Forces move neither of the two bodies.
    let skin = Material::elastic(1e6);
    let fixed = Body::fixed("cube", box_shape([EDGE; 3]), skin).unwrap();
    let still = World::new(vec![fixed.with_pose(at(0.0, 0.0, 0.09)), slab(skin)]).unwrap();
    assert!(
        still
            .largest_stable_step(&still.initial_state())
            .unwrap()
            .is_none()
    );
}

#[test]
fn the_limit_of_many_is_that_of_the_stiffest_contact_and_names_it() {
    let skin = Material::elastic(1e6);
    let beside = |name, x, depth, mass| {
        let body = dynamic(name, box_shape([EDGE; 3]), skin, mass);
        body.with_pose(at(x, 0.05, EDGE / 2.0 - depth))
    };
    // The lightest contact is the stiffest. The body in the air has no contact.
    let bodies = vec![
        beside("heavy", -0.5, 0.001, 2.0),
        slab(skin),
        beside("light", 0.03, 0.001, 0.5),
        beside("in the air", 0.5, -0.1, 0.01),
    ];
    let world = World::new(bodies.clone()).unwrap();
    let alone = World::new(bodies[1..3].to_vec()).unwrap();
    assert_close(limit(&world), limit(&alone), FOUND);
    let plan = Plan::new(2.0 * limit(&world), 1).unwrap();
    let mut rollout = world.rollout(&plan);
    let ended = rollout.next().unwrap();
    let Err(RolloutError::TimeStepTooLong { step, bodies, .. }) = ended else {
        panic!("{ended:?}")
    };
    assert_eq!((step, bodies), (1, ["slab".to_owned(), "light".to_owned()]));
}

#[test]
fn where_a_bodys_frame_has_its_origin_does_not_matter() {
    let skin = rubbing(1e6, 0.3, 0.5);
    let off = vector![0.3, -0.2, 0.5];
    let field = shapes::ellipsoid([0.1, 0.15, 0.2], 2).unwrap();
    let vertices = field.mesh().vertices().iter().map(|vertex| vertex - off);
    let mesh = TetMesh::new(vertices.collect(), field.mesh().tets().to_vec()).unwrap();
    let shifted = PressureField::new(mesh, field.extents().to_vec()).unwrap();
    let turn = vector![0.4, 0.3, 0.2];
    let limits = [(field, Vector3::zeros()), (shifted, off)].map(|(field, off)| {
        let body = dynamic("body", Shape::new(field), skin, 1.0);
        let upright = Pose::from_rotation_vector(&turn, Vector3::zeros());
        let origin = vector![0.03, 0.05, 0.11] + upright.rotation() * off;
        let body = body
            .with_pose(Pose::from_rotation_vector(&turn, origin))
            .with_velocity(vector![0.1, 0.2, -0.3]);
        limit(&World::new(vec![body, slab(skin)]).unwrap())
    });
    assert_close(limits[0], limits[1], FOUND);
}
