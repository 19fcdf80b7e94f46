//! Rollouts that end with numbers that are not finite, and initial states of rollouts.

use crate::scenes::{SKIN, at, ball, ball_shape, down, floor, still_at};
use crate::support::worlds::{EXPLICIT, dynamic};
use hydroelastic::dynamics::{
    Body, BodyState, Material, Plan, RolloutError, State, Trajectory, World, WorldError,
};
use hydroelastic::gradient::{Experiment, FinalPosition, GradientError, Parameter};
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use std::sync::Arc;

/// Returns a nearly weightless ball that falls on a floor with the largest possible stiffness, and another ball far away.
fn exploding() -> World {
    let stiff = Material::elastic(1e150);
    let falling = dynamic("falling", ball_shape(), stiff, 1e-200);
    let falling = falling.with_pose(at(0.0, 0.0, 1.0));
    let world = World::new(vec![
        ball("far").with_pose(at(5.0, 0.0, 0.0)),
        falling,
        floor(stiff),
    ]);
    world.unwrap().with_gravity(down()).unwrap()
}

/// Time step (s). The fall of 0.9 m takes 0.428 s, so the first evaluation in the floor is at 0.45 s, in the fifth step.
const LONG_STEP: f64 = 0.1;

fn explosion() -> RolloutError {
    RolloutError::NotFinite {
        step: 5,
        time: 5.0 * LONG_STEP,
        body: "falling".into(),
    }
}

#[test]
fn a_blow_up_ends_the_rollout_with_its_step_time_and_body() {
    let world = exploding();
    let mut rollout = world.rollout(&Plan::new(LONG_STEP, 5).unwrap());
    for _ in 0..4 {
        rollout.next().unwrap().unwrap();
    }
    let last = rollout.state().clone();
    let error = rollout.next().unwrap().unwrap_err();
    assert_eq!(error, explosion());
    assert_eq!(
        error.to_string(),
        "step 5 (t = 0.5 s) took body \"falling\" to a state that is not finite: the time step \
         may be too long for its stiffness (see World::largest_stable_step)"
    );
    assert!(rollout.next().is_none() && rollout.next().is_none());
    assert_eq!(rollout.state().time.to_bits(), last.time.to_bits());
}

#[test]
fn a_recording_that_blows_up_gives_what_it_has_recorded() {
    let world = exploding();
    for (every, count) in [(1, 5), (2, 3), (10, 1)] {
        let plan = Plan::new(LONG_STEP, 100).unwrap().recording_every(every);
        let interrupted = world.rollout(&plan).run().unwrap_err();
        assert_eq!(interrupted.error, explosion());
        assert_eq!(interrupted.to_string(), explosion().to_string());
        let states = interrupted.trajectory.states();
        assert_eq!(states.len(), count);
        let mut bodies = states.iter().flat_map(|state| &state.bodies);
        assert!(bodies.all(BodyState::is_finite));
    }
}

#[test]
fn a_rollout_that_has_blown_up_does_so_again_at_the_same_step() {
    let world = exploding();
    let mut rollout = world.rollout(&Plan::new(LONG_STEP, 1).unwrap());
    assert_eq!(rollout.by_ref().take(100).filter(Result::is_err).count(), 1);
    assert_eq!(rollout.run().unwrap_err().error, explosion());
}

#[test]
fn a_rollout_that_has_blown_up_starts_anew_from_another_state() {
    let world = exploding();
    let mut rollout = world.rollout(&Plan::new(LONG_STEP, 100).unwrap());
    assert_eq!(rollout.by_ref().take(100).filter(Result::is_err).count(), 1);
    let anew = rollout.with_state(world.initial_state()).unwrap();
    let (states, errors): (Vec<_>, Vec<_>) = anew.take(100).partition(Result::is_ok);
    assert_eq!(states.len(), 4);
    assert_eq!(errors[0].as_ref().unwrap_err(), &explosion());
}

#[test]
fn a_blow_up_ends_a_gradient() {
    let world = exploding();
    let experiment = Experiment::new(&world, &Plan::new(LONG_STEP, 20).unwrap());
    let outcome = FinalPosition::of_body(&world, world.bodies()[0].name()).unwrap();
    let expected = GradientError::Rollout(explosion());
    let jacobian = experiment.jacobian(&[Parameter::Gravity], &outcome);
    assert_eq!(jacobian.unwrap_err(), expected);
    assert_eq!(experiment.value(&outcome).unwrap_err(), expected);
}

#[test]
fn a_path_that_leads_nowhere_ends_the_rollout() {
    let path = |time: f64| still_at(if time < 0.25 { 1.0 } else { f64::NAN });
    let lost = Body::kinematic("lost", ball_shape(), SKIN, Arc::new(path)).unwrap();
    let world = World::new(vec![ball("ball"), lost]).unwrap();
    let between = |time: f64| {
        still_at(if (time - 0.25).abs() < 0.01 {
            f64::NAN
        } else {
            1.0
        })
    };
    let between = Body::kinematic("lost", ball_shape(), SKIN, Arc::new(between)).unwrap();
    let between = World::new(vec![ball("ball"), between]).unwrap();
    let plan = Plan::new(0.1, 10).unwrap();
    for plan in [plan, plan.without_stability_check()] {
        // The middle of the third step, at which the leapfrog evaluates the contacts.
        let rollout = between.rollout(&plan);
        let error = rollout.run().unwrap_err().error;
        assert!(
            matches!(error, RolloutError::PathNotFinite { step: 3, .. }),
            "{error}"
        );
    }
    for integrator in EXPLICIT {
        let rollout = world.rollout(&plan.with_integrator(integrator));
        let error = rollout.run().unwrap_err().error;
        let RolloutError::PathNotFinite { step, body, .. } = error else {
            panic!("{error}")
        };
        assert_eq!((step, body.as_str()), (3, "lost"));
    }
}

#[test]
fn a_state_of_another_world_is_no_start() {
    let small = World::new(vec![ball("ball")]).unwrap();
    let large = exploding();
    let rollout = large.rollout(&Plan::new(LONG_STEP, 0).unwrap());
    let error = rollout.with_state(small.initial_state()).unwrap_err();
    let (found, expected) = (1, 3);
    assert_eq!(error, WorldError::StateSize { found, expected });
}

#[test]
fn a_rollout_does_not_start_from_a_state_that_is_not_usable() {
    let world = World::new(vec![ball("a"), ball("b").with_pose(at(1.0, 0.0, 0.0))]).unwrap();
    let changed = |change: fn(&mut BodyState)| {
        let mut state = world.initial_state();
        change(&mut state.bodies[1]);
        let plan = Plan::new(1e-3, 10).unwrap();
        let rollout = world.rollout(&plan);
        let error = rollout.with_state(state.clone()).unwrap_err();
        let errors = world.clone().with_initial_state(&state).unwrap_err();
        assert_eq!(error.to_string(), errors.to_string());
        error.to_string()
    };
    let spin = changed(|body| body.twist.angular.y = f64::NAN);
    assert!(spin.contains("the spin of body \"b\""), "{spin}");
    let velocity = changed(|body| body.twist.linear.x = f64::INFINITY);
    assert!(
        velocity.contains("the velocity of body \"b\""),
        "{velocity}"
    );
    let stretched = changed(|body| {
        let quaternion = UnitQuaternion::new_unchecked(Quaternion::new(2.0, 0.0, 0.0, 0.0));
        body.pose = Isometry3::from_parts(Translation3::identity(), quaternion).into();
    });
    assert!(stretched.contains("the pose of body \"b\""), "{stretched}");
}

#[test]
fn time_is_counted_in_steps_from_any_start() {
    let world = World::new(vec![ball("ball")]).unwrap();
    for start in [0.0, 1.0 / 3.0] {
        let mut state = world.initial_state();
        state.time = start;
        let rollout = world.rollout(&Plan::new(1e-3, 10_000).unwrap());
        let mut rollout = rollout.with_state(state).unwrap();
        let last = rollout.nth(9_999).unwrap().unwrap();
        assert_eq!(last.time.to_bits(), (start + 1e4 * 1e-3_f64).to_bits());
    }
}

#[test]
fn trajectories_are_made_of_states_in_the_order_of_time() {
    let world = World::new(vec![ball("ball")]).unwrap();
    let recorded = world.rollout(&Plan::new(1e-3, 3).unwrap()).run();
    let states = recorded.unwrap().states().to_vec();
    assert_eq!(Trajectory::new(states.clone()).unwrap().states().len(), 4);
    let refusal = |states: Vec<State>| Trajectory::new(states).unwrap_err();
    assert_eq!(refusal(Vec::new()), WorldError::NoState);
    let backwards = refusal(states.iter().rev().cloned().collect());
    assert!(matches!(backwards, WorldError::StateOrder { state: 1, .. }));
    let mut uneven = states;
    uneven[2].bodies.clear();
    let expected = WorldError::BodyCount {
        state: 2,
        found: 0,
        expected: 1,
    };
    assert_eq!(refusal(uneven), expected);
}
