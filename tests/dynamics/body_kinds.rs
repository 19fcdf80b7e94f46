//! Dynamic and other bodies: fixed and kinematic bodies, ignored pairs, shared shapes.

use crate::scenes::{
    ROUND_OFF, SKIN, at, ball, ball_shape, box_shape, down, floor, leapfrog, still_at,
};
use crate::support::worlds::{EXPLICIT, dynamic, plan_of, sliding_at, turned};
use hydroelastic::dynamics::{Body, BodyState, Mass, Material, World, WorldError};
use hydroelastic::gradient::Parameter;
use hydroelastic::spatial::{Pose, Twist};
use nalgebra::{Matrix3, Vector3, vector};
use std::sync::Arc;

/// Asserts that two states of a body are the same, bit for bit.
fn assert_same(a: &BodyState, b: &BodyState) {
    assert_eq!(a.pose.translation(), b.pose.translation());
    assert_eq!(a.pose.rotation(), b.pose.rotation());
    assert_eq!(a.twist.linear, b.twist.linear);
    assert_eq!(a.twist.angular, b.twist.angular);
}

#[test]
fn ignored_pairs_do_not_push() {
    let falling = || ball("ball").with_pose(at(0.0, 0.0, 0.15));
    let alone = World::new(vec![falling()]).unwrap();
    let alone = alone.with_gravity(down()).unwrap();
    for names in [["ball", "floor"], ["floor", "ball"]] {
        let world = World::new(vec![falling(), floor(SKIN)]).unwrap();
        let world = world.with_gravity(down()).unwrap();
        let last = |world: &World| leapfrog(world, 1e-3).nth(199).unwrap().unwrap();
        let bounced = last(&world);
        let world = world.with_ignored(names[0], names[1]).unwrap();
        let passed = last(&world);
        assert_same(&passed.bodies[0], &last(&alone).bodies[0]);
        assert!(passed.bodies[0].pose.translation().z < -0.04);
        assert!(bounced.bodies[0].pose.translation().z > 0.05);
        let inside = leapfrog(&world, 1e-3).take(200).map(Result::unwrap);
        let polygons = inside.map(|state| world.topology(&state).unwrap().polygon_count());
        assert_eq!(polygons.sum::<usize>(), 0);
    }
}

#[test]
fn an_ignored_pair_leaves_the_other_pairs() {
    let world = World::new(vec![
        ball("left").with_pose(at(-0.1, 0.0, 0.09)),
        ball("right").with_pose(at(0.05, 0.0, 0.09)),
        floor(SKIN),
    ]);
    let world = world.unwrap().with_ignored("left", "right").unwrap();
    let next = leapfrog(&world, 1e-3).next().unwrap().unwrap();
    for body in &next.bodies[..2] {
        assert!(body.twist.linear.z > 0.0);
        assert!(body.twist.linear.x.abs() < 1e-6 * body.twist.linear.z);
    }
}

#[test]
fn fixed_bodies_never_move() {
    let skin = Material {
        friction: Some(0.5),
        ..SKIN
    };
    let tilted = turned([0.1, 0.2, 0.3], [0.0, 0.0, -0.25]);
    let rock = Body::fixed("rock", box_shape([1.0, 1.0, 0.4]), skin).unwrap();
    let rock = rock.with_pose(tilted);
    let thrown = ball("ball").with_velocity(vector![0.0, 0.0, -5.0]);
    let world = World::new(vec![rock, thrown.with_pose(at(0.0, 0.0, 0.1))]).unwrap();
    let start = world.initial_state();
    let mut hits = 0;
    for integrator in EXPLICIT {
        for state in world.rollout(&plan_of(integrator, 1e-4, 1_000)).take(1_000) {
            let state = state.unwrap();
            assert_same(&state.bodies[0], &start.bodies[0]);
            hits += usize::from(world.topology(&state).unwrap().polygon_count() > 0);
        }
    }
    assert!(hits > 100, "{hits}");
}

#[test]
fn bodies_that_forces_do_not_move_do_not_touch_each_other() {
    let slab = Body::fixed("slab", box_shape([1.0, 1.0, 1.0]), SKIN).unwrap();
    let sunk = Body::kinematic("sunk", ball_shape(), SKIN, Arc::new(|_| still_at(0.4))).unwrap();
    let world = World::new(vec![slab, sunk, floor(SKIN)]).unwrap();
    assert_eq!(
        world
            .topology(&world.initial_state())
            .unwrap()
            .polygon_count(),
        0
    );
}

/// Returns a block that moves along x at 1 m/s and starts just beside a ball of 1 kg.
fn pushed_ball() -> World {
    let path = |time: f64| BodyState {
        pose: at(time, 0.0, 0.0),
        twist: sliding_at(Vector3::x()),
    };
    let block = box_shape([0.2, 0.4, 0.4]);
    let pusher = Body::kinematic("pusher", block, SKIN, Arc::new(path)).unwrap();
    World::new(vec![ball("ball").with_pose(at(0.205, 0.0, 0.0)), pusher]).unwrap()
}

#[test]
fn a_prescribed_body_follows_its_path_whatever_it_pushes() {
    let world = pushed_ball();
    for integrator in EXPLICIT {
        for state in world.rollout(&plan_of(integrator, 1e-3, 200)).take(200) {
            let state = state.unwrap();
            let pusher = &state.bodies[1];
            let off_path = pusher.pose.translation() - vector![state.time, 0.0, 0.0];
            assert!(off_path.amax() < ROUND_OFF);
            assert_eq!(pusher.pose.rotation(), &Matrix3::identity());
            assert_eq!(pusher.twist.linear, Vector3::x());
        }
    }
}

/// Error of energies after a bounce of five hundred steps.
const BOUNCE: f64 = 1e-4;

#[test]
fn a_ball_leaves_a_pusher_at_twice_the_speed_of_the_pusher() {
    let world = pushed_ball();
    let mut before = world.initial_state();
    let mut touched = 0;
    for state in leapfrog(&world, 5e-5).take(4_000) {
        let state = state.unwrap();
        let gained = state.bodies[0].twist.linear.x - before.bodies[0].twist.linear.x;
        assert!(gained >= 0.0, "a pusher never pulls");
        // In the pusher's frame, no force does work.
        let relative = state.bodies[0].twist.linear - Vector3::x();
        let contact = world.diagnostics(&state).unwrap().contact_energy;
        let energy = relative.norm_squared() / 2.0 + contact;
        assert!((energy - 0.5).abs() < 10.0 * BOUNCE, "{energy}");
        touched += usize::from(contact > 0.0);
        before = state;
    }
    assert!(touched > 100, "{touched}");
    let momentum = world.diagnostics(&before).unwrap().momentum.linear;
    assert!(
        (momentum - vector![2.0, 0.0, 0.0]).amax() < BOUNCE,
        "{momentum}"
    );
}

#[test]
fn a_turning_pusher_pushes_with_the_velocity_of_its_surface() {
    // A roller rotates under a ball of the same shape. Friction moves the ball in the direction of the roller's top, and rotates it in the
    // opposite direction.
    let skin = Material {
        friction: Some(0.5),
        dissipation: 1.0,
        ..SKIN
    };
    let turning = |time: f64| BodyState {
        pose: Pose::from_rotation_vector(&vector![0.0, 10.0 * time, 0.0], Vector3::zeros()),
        twist: Twist {
            angular: vector![0.0, 10.0, 0.0],
            linear: Vector3::zeros(),
        },
    };
    let roller = Body::kinematic("roller", ball_shape(), skin, Arc::new(turning)).unwrap();
    let load = dynamic("load", ball_shape(), skin, 1.0);
    let world = World::new(vec![roller, load.with_pose(at(0.0, 0.0, 0.19))]).unwrap();
    let world = world.with_gravity(down()).unwrap();
    let last = leapfrog(&world, 1e-4).nth(99).unwrap().unwrap();
    let twist = &last.bodies[1].twist;
    assert!(twist.linear.x > 1e-3, "{}", twist.linear);
    assert!(twist.angular.y < -1e-2, "{}", twist.angular);
}

#[test]
fn bodies_may_share_a_shape() {
    let shape = ball_shape();
    let body = |name: &str| Body::dynamic(name, Arc::clone(&shape), SKIN, Mass::Total(1.0));
    let fixed = Body::fixed("three", Arc::clone(&shape), SKIN).unwrap();
    let world = World::new(vec![body("one").unwrap(), body("two").unwrap(), fixed]).unwrap();
    assert_eq!(Arc::strong_count(&shape), 4);
    assert!(
        world
            .bodies()
            .iter()
            .all(|body| Arc::ptr_eq(body.shape().compliant().unwrap(), &shape))
    );
    let lifted = world.lifted::<num_dual::Dual64>();
    assert_eq!(Arc::strong_count(&shape), 7);
    drop((world, lifted));
    assert_eq!(Arc::strong_count(&shape), 1);
}

#[test]
fn a_world_with_a_body_on_a_turning_path_can_be_changed() {
    let path = |time: f64| BodyState {
        pose: turned([0.3, 0.7 + time, -0.4], [3.0, 0.0, 0.0]),
        twist: Twist::zero(),
    };
    // The test uses many starts, because for some of them the path's rotation is not corrected for rounding.
    for start in 0..50 {
        let turning = Arc::new(move |time: f64| path(time + 0.1 * f64::from(start)));
        let skin = Material::elastic(1e5);
        let world = World::new(vec![
            dynamic("ball", ball_shape(), skin, 1.0),
            Body::kinematic("arm", ball_shape(), skin, turning).unwrap(),
        ]);
        let world = world.unwrap();
        let by = [Parameter::initial_velocity("ball")];
        let changed = world.perturbed(&by, &[1.0, 0.0, 0.0]).unwrap();
        assert!((changed.bodies()[0].initial_state().velocity().x - 1.0).abs() <= 0.0);
    }
}

#[test]
fn a_path_is_taken_out_of_a_world_and_put_back_with_the_same_bits() {
    let path = Arc::new(|time: f64| BodyState {
        twist: sliding_at(vector![1.0, 0.0, 0.0]),
        ..still_at(time - 0.2)
    });
    let driven = Body::kinematic("driven", ball_shape(), SKIN, path.clone()).unwrap();
    let world = World::new(vec![ball("ball").with_pose(at(0.0, 0.0, 0.19)), driven]).unwrap();
    let ends = |world: &World| leapfrog(world, 1e-3).nth(99).unwrap().unwrap();
    let still = world.clone().with_path("driven", None).unwrap();
    assert_same(&ends(&still).bodies[1], &still_at(-0.2));
    let moving = still.with_path("driven", Some(path.clone())).unwrap();
    for (actual, expected) in ends(&moving).bodies.iter().zip(ends(&world).bodies) {
        assert_same(actual, &expected);
    }
    assert_eq!(
        world.clone().with_path("ball", Some(path)).unwrap_err(),
        WorldError::Dynamic("ball".into())
    );
    let lost = Arc::new(|_| still_at(f64::NAN));
    assert!(matches!(
        world.with_path("driven", Some(lost)).unwrap_err(),
        WorldError::Pose { .. }
    ));
}
