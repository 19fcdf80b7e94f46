//! Bodies that would pass through each other within one step: sliding, spinning, falling from rest, pushed or hit by a body on a path.

use super::scenes::{brick, finger, steps};
use crate::scenes::{GRAVITY, at, box_shape};
use crate::support::worlds::{dynamic, fixed, icosphere, plan_of, rubbing, sliding_at};
use hydroelastic::contact::HalfSpace;
use hydroelastic::dynamics::{
    Body, BodyState, Control, Integrator, KinematicPath, Material, State, World,
};
use hydroelastic::spatial::{Pose, Wrench};
use nalgebra::{Vector3, vector};
use std::sync::Arc;

const STIFF: f64 = 1e9;

/// Returns the final state after steps with error control.
fn end(world: &World, time_step: f64, steps: usize) -> State {
    let plan = plan_of(Integrator::Sdirk3, time_step, steps).recording_every(steps);
    let trajectory = world.rollout(&plan).run().unwrap();
    trajectory.last().clone()
}

fn ball(name: &str, radius: f64, mass: f64) -> Body {
    let shape = icosphere(radius, 1);
    let skin = Material::elastic(STIFF).with_dissipation(0.1);
    dynamic(name, shape, skin, mass)
}

fn falling(bodies: Vec<Body>) -> World {
    let world = World::new(bodies).unwrap();
    world.with_gravity(vector![0.0, 0.0, -GRAVITY]).unwrap()
}

fn floor() -> Body {
    fixed("floor", HalfSpace::rigid(), Material::rigid())
}

#[test]
fn a_puck_that_slides_on_a_floor_stops_at_a_thin_wall() {
    for (speed, thickness, size, time_step) in [
        (10.0, 0.002, 0.01, 5e-3),
        (20.0, 0.002, 0.01, 5e-3),
        (40.0, 0.01, 0.05, 5e-3),
        (10.0, 0.01, 0.02, 1e-2),
    ] {
        for phase in 0..5 {
            let skin = rubbing(STIFF, 0.3, 0.1);
            let distance = 0.2 + speed * time_step * f64::from(phase) / 5.0;
            let puck = brick("puck", [size, size, 0.01], skin)
                .with_pose(at(-distance, 0.0, 0.005 - 1e-7))
                .with_velocity(vector![speed, 0.0, 0.0]);
            let wall = fixed("wall", box_shape([thickness, 1.0, 0.3]), skin);
            let world = falling(vec![puck, floor(), wall.with_pose(at(0.0, 1e-3, 0.1))]);
            let end = end(&world, time_step, steps(0.7 / speed, time_step) + 1);
            let x = end.bodies[0].position().x;
            assert!(x < 0.0, "{speed} {thickness} {phase}: x = {x}");
        }
    }
}

#[test]
fn a_rod_that_spins_meets_a_small_ball() {
    let skin = Material::elastic(STIFF);
    for spin in [50.0, 200.0] {
        // At the tip, the peg is outside the boxes around the rod at all stages.
        for (phase, place) in [(-0.3, 0.4), (-0.5, 0.4), (-0.9, 0.4), (-0.2175, 0.495)] {
            let rotation = vector![0.0, 0.0, phase];
            let rod = brick("rod", [1.0, 0.01, 0.01], skin)
                .with_pose(Pose::from_rotation_vector(&rotation, Vector3::zeros()))
                .with_angular_velocity(vector![0.0, 0.0, spin]);
            let shape = icosphere(0.005, 1);
            let peg = fixed("peg", shape, skin);
            let world = World::new(vec![rod, peg.with_pose(at(place, 0.0, 0.001))]).unwrap();
            // The rollout ends well after the rod reaches the peg, and before the rod's other end does.
            let end = end(&world, 5e-3, if spin > 100.0 { 2 } else { 6 });
            let speed = end.bodies[0].velocity().norm();
            // Without contact, the center does not move.
            assert!(speed > 0.01, "{spin} {phase}: its center moves at {speed}");
        }
    }
}

#[test]
fn a_ball_that_falls_from_rest_stays_above_a_floor_in_long_steps() {
    for (radius, time_step) in [(0.05, 0.2), (0.01, 0.1), (1e-3, 0.03)] {
        for phase in 0..5 {
            let height = radius * (1.5 + 2.0 * f64::from(phase));
            let body = ball("ball", radius, 1000.0 * radius.powi(3));
            let world = falling(vec![body.with_pose(at(0.0, 0.0, height)), floor()]);
            let z = end(&world, time_step, 3).bodies[0].position().z;
            assert!(z > 0.0, "{radius} {phase}: z = {z}");
        }
    }
}

#[test]
fn fast_balls_rebound_however_many_substeps_that_takes() {
    let plate = fixed(
        "plate",
        box_shape([0.01, 1.0, 1.0]),
        Material::elastic(1e12),
    );
    let bullet = ball("bullet", 0.01, 1e-3).with_velocity(vector![1000.0, 0.0, 0.0]);
    let world = World::new(vec![bullet.with_pose(at(-7.0, 0.1, 0.05)), plate]).unwrap();
    let velocity = end(&world, 0.02, 1).bodies[0].velocity().x;
    assert!(velocity < 0.0, "{velocity}");
}

#[test]
fn bodies_that_start_to_move_within_a_step_collide() {
    let shape = [0.01, 0.5, 0.5];
    let skin = Material::elastic(STIFF).with_dissipation(0.1);
    // A paddle that sweeps by 1 m within one step of 0.1 s, from rest to rest. The shorter sweep ends before the first stage.
    for duration in [0.1, 0.03] {
        let sweep: Arc<KinematicPath> = Arc::new(move |time| {
            let part = (time / duration).clamp(0.0, 1.0);
            let x = -0.5 + part * part * (3.0 - 2.0 * part);
            let speed = 6.0 * part * (1.0 - part) / duration;
            let twist = sliding_at(vector![speed, 0.0, 0.0]);
            let pose = at(x, 0.0, 0.0);
            BodyState { pose, twist }
        });
        let body = ball("ball", 0.02, 0.1);
        let world = World::new(vec![body, finger("paddle", shape, skin, sweep)]).unwrap();
        let x = end(&world, 0.1, 2).bodies[0].position().x;
        assert!(x > 0.5, "{duration}: {x}");
    }
    // A force of 10 N on 10 g, toward a wall.
    let force = vector![10.0, 0.0, 0.0];
    let push = Wrench {
        force,
        ..Wrench::zero()
    };
    let control = Control::new("ball", 0.1, vec![push]).unwrap();
    let wall = fixed("wall", box_shape(shape), skin);
    let bodies = vec![ball("ball", 0.02, 0.01), wall.with_pose(at(1.0, 0.0, 0.0))];
    let world = World::new(bodies).and_then(|world| world.with_control(control));
    let pushed = end(&world.unwrap(), 0.1, 1);
    let x = pushed.bodies[0].position().x;
    assert!(x < 1.0, "{x}");
}

/// A step of thirty bodies has four trials, too few for the tolerances. Substeps that are accepted with a larger error must not move bodies
/// through bodies that they already touched.
#[test]
fn a_swarm_whose_budget_is_used_up_stays_above_a_plate() {
    let skin = Material::elastic(STIFF).with_dissipation(0.3);
    let plate = fixed("plate", box_shape([1.0, 1.0, 0.005]), skin);
    let mut bodies = vec![plate.with_pose(at(0.0, 0.0, -0.0025))];
    for number in 0..30 {
        // Neighbors overlap slightly, so all bodies are one island.
        let place = [number % 6, number / 6].map(|place| 0.01999 * f64::from(place));
        let cube = brick(&format!("cube {number}"), [0.02; 3], skin)
            .with_pose(at(place[0], place[1], 0.05));
        bodies.push(cube.with_velocity(vector![0.0, 0.0, -40.0]));
    }
    let world = falling(bodies);
    let end = end(&world, 2e-2, 4);
    let lowest = end.bodies[1..].iter().map(|body| body.position().z);
    let lowest = lowest.fold(f64::INFINITY, f64::min);
    assert!(lowest > 0.0, "{lowest}");
}
