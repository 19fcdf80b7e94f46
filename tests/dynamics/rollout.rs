//! Rollouts: all ways to advance them agree, and a failure leaves a defined state.

use crate::scenes::bits;
use crate::support::worlds::{EXPLICIT, at, cuboid, dynamic, falling, fixed, icosphere};
use hydroelastic::dynamics::{Material, Plan, Rollout, World};
use nalgebra::vector;
use num_dual::Dual64;

const TIME_STEP: f64 = 1e-3;

/// Returns a ball that falls on a floor.
fn scene(skin: Material) -> World {
    let ball = icosphere(0.1, 1);
    let floor = cuboid([1.0, 1.0, 0.2]);
    let ball = dynamic("ball", ball, skin, 1.0);
    falling(vec![
        ball.with_pose(at(0.0, 0.0, 0.21)),
        fixed("floor", floor, skin),
    ])
}

fn rollout(world: &World) -> Rollout {
    world.rollout(&Plan::new(TIME_STEP, 100).unwrap())
}

#[test]
fn advancing_leads_through_the_states_of_the_iterator() {
    let world = scene(Material::elastic(1e5).with_friction(0.4));
    let (mut advanced, recorded) = (rollout(&world), rollout(&world).run().unwrap());
    for (state, recorded) in rollout(&world).zip(&recorded.states()[1..]) {
        let state = bits(&state.unwrap());
        assert_eq!(bits(advanced.advance().unwrap()), state);
        assert_eq!(bits(advanced.state()), state);
        assert_eq!(bits(recorded), state);
    }
}

#[test]
fn passing_over_states_changes_none() {
    let world = scene(Material::elastic(1e5));
    let all: Vec<_> = rollout(&world).take(90).map(Result::unwrap).collect();
    let thinned = rollout(&world).step_by(7).map(Result::unwrap);
    for (index, state) in thinned.take(12).enumerate() {
        assert_eq!(bits(&state), bits(&all[7 * index]));
    }
}

#[test]
fn a_failed_rollout_keeps_its_last_finite_state_and_ends() {
    // The stiffness is so large that the first contact throws the ball until its pose overflows.
    let world = scene(Material::elastic(1e150).with_dissipation(1e150));
    let mut failing = rollout(&world);
    let finite = (failing.by_ref().take(1_000))
        .take_while(Result::is_ok)
        .count();
    assert!((1..1_000).contains(&finite), "{finite}");
    let last = bits(failing.state());
    let time = finite as f64 * TIME_STEP;
    assert_eq!(failing.state().time.to_bits(), time.to_bits());
    assert!(failing.next().is_none());
    assert!(failing.nth(3).is_none());
    let error = failing.advance().unwrap_err();
    assert_eq!(failing.advance().unwrap_err(), error);
    assert_eq!(bits(failing.state()), last);
    assert!(rollout(&world).nth(finite + 1).is_none());
    assert!(rollout(&world).nth(finite).unwrap().is_err());
}

/// Relative rounding error in the derivatives of a rotation after 20,000 steps.
const TANGENT: f64 = 1e-10;

#[test]
fn derivatives_of_a_rotation_stay_those_of_rotations_over_many_steps() {
    let brick = cuboid([0.1, 0.2, 0.3]);
    let brick = dynamic("brick", brick, Material::elastic(1e5), 1.0);
    let world = World::new(vec![brick.with_angular_velocity(vector![1.0, 5.0, -3.0])]).unwrap();
    let world = world.lifted::<Dual64>();
    for integrator in EXPLICIT {
        let mut start = world.initial_state();
        start.bodies[0].twist.angular.x.eps = 1.0;
        let plan = Plan::new(TIME_STEP, 20_000).unwrap();
        let mut rollout = world.rollout(&plan.with_integrator(integrator));
        rollout = rollout.with_state(start).unwrap();
        let last = rollout.nth(19_999).unwrap().unwrap();
        // RᵀR = I, so its derivative is zero.
        let rotation = last.bodies[0].pose.rotation();
        let gram = rotation.transpose() * rotation;
        let size = rotation.map(|entry| entry.eps).amax();
        let error = gram.map(|entry| entry.eps).amax();
        assert!(
            size > 1.0 && error <= TANGENT * size,
            "{error:e} of {size:e}"
        );
    }
}
