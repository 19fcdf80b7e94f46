//! Robots that hold bodies, in implicit steps of 5 ms.

use crate::support::robots::{CARRIED, FRICTION, hand, pads};
use crate::support::worlds::{GRAVITY, IMPLICIT, plan_of};
use hydroelastic::dynamics::{Integrator, State, Work, World};
use nalgebra::vector;

/// Time step (s).
const TIME_STEP: f64 = 5e-3;

/// Relative error of the creep speed. Contact surfaces of boxes bend near their edges, where the force is not along the slide.
const CREEP: f64 = 0.01;

/// Returns the states after each step and the work of all steps.
fn motion(world: &World, integrator: Integrator, steps: usize) -> (Vec<State>, Work) {
    let mut rollout = world.rollout(&plan_of(integrator, TIME_STEP, steps));
    let mut work = Work::default();
    let states = (0..steps).map(|_| {
        rollout.advance().unwrap();
        work += rollout.step_report().unwrap().work;
        rollout.state().clone()
    });
    (states.collect(), work)
}

/// At the slip tolerance s, the box creeps at s·r/√(1 − r²). The load r is the weight relative to the largest friction force of both pads.
#[test]
fn a_box_between_pads_on_slides_creeps_at_the_speed_of_the_friction_law() {
    for (force, mass) in [(12.0, 0.045), (20.0, 1.0)] {
        let load = mass * GRAVITY / (2.0 * FRICTION * force);
        for integrator in IMPLICIT {
            let world = pads(force, mass);
            let creep = world.slip_tolerance() * load / (1.0 - load * load).sqrt();
            let (states, work) = motion(&world, integrator, 100);
            let height = |step: usize| states[step].bodies[0].position().z;
            let speed = (height(59) - height(99)) / (40.0 * TIME_STEP);
            println!(
                "{force} N, {integrator:?}: fall {:.1e} m, {:.4} of the creep speed, {work:?}",
                -height(99),
                speed / creep
            );
            assert!((speed / creep - 1.0).abs() < CREEP, "{}", speed / creep);
            assert!(height(99) > -1e-3, "{}", height(99));
            assert_eq!(work.failures, 0, "{force} N, {integrator:?}");
        }
    }
}

#[test]
fn a_hand_of_twenty_joints_carries_a_ball() {
    for integrator in IMPLICIT {
        let world = hand(0.1);
        let (states, work) = motion(&world, integrator, 130);
        let [start, end] =
            [&world.initial_state(), &states[129]].map(|state| *state.bodies[0].position());
        let off = end - start - vector![CARRIED, 0.0, CARRIED];
        println!("{integrator:?}: off {:?} m, {work:?}", off.as_slice());
        // The ball creeps in the hand, and sinks into the floor before.
        assert!(off.norm() < 1e-3, "{off}");
        assert_eq!(work.failures, 0, "{integrator:?}");
    }
}
