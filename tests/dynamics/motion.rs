//! Motion against closed forms, and conserved quantities.

use crate::scenes::{GRAVITY, at};
use crate::support::balls::fine_ball;
use crate::support::worlds::{cuboid, dynamic, fixed, icosphere};
use hydroelastic::dynamics::{Body, Mass, Material, Plan, State, World};
use hydroelastic::gradient::{Experiment, FinalPosition, Parameter};
use hydroelastic::spatial::MassProperties;
use nalgebra::{Matrix3, Vector3, vector};
use std::sync::Arc;

/// Modulus (Pa) of a nearly rigid body. Relative to it, the bodies of these tests are soft to one part in ten thousand.
const RIGID: f64 = 1e13;

/// The table's tolerance, including the error of the mesh.
const TABLE: f64 = 1e-3;

/// Tolerance of the derivative of a mirrored bounce, at the stated time steps.
const MIRROR: f64 = 1e-6;

/// The table's tolerance of the rebound.
const RESTITUTION: f64 = 1e-4;

/// The table's tolerance of sums that are conserved at any time step.
const SUMS: f64 = 1e-9;

/// Returns a floor whose surface is z = 0.
fn floor(material: Material) -> Body {
    let slab = Arc::new(cuboid([2.0, 2.0, 0.5]));
    fixed("floor", slab, material).with_pose(at(0.0, 0.0, -0.25))
}

fn sphere_inertia(mass: f64, radius: f64) -> Mass {
    Mass::Properties(MassProperties {
        mass,
        center_of_mass: Vector3::zeros(),
        inertia: Matrix3::identity() * (0.4 * mass * radius * radius),
    })
}

/// Returns a ball of 0.1 m and 1 kg above a rigid floor, with its center at a height.
fn ball_over_floor(material: Material, height: f64, velocity: f64) -> World {
    let ball = Arc::new(fine_ball(0.1, 64, 40));
    let ball = Body::dynamic("ball", ball, material, sphere_inertia(1.0, 0.1)).unwrap();
    let rigid = Material {
        modulus: Some(RIGID),
        ..material
    };
    let start = ball
        .with_pose(at(0.0, 0.0, height))
        .with_velocity(vector![0.0, 0.0, velocity]);
    World::new(vec![start, floor(rigid)]).unwrap()
}

fn with_gravity(world: World) -> World {
    world.with_gravity(vector![0.0, 0.0, -GRAVITY]).unwrap()
}

fn height(state: &State) -> f64 {
    state.bodies[0].pose.translation().z
}

fn upward(state: &State) -> f64 {
    state.bodies[0].twist.linear.z
}

#[test]
fn a_dropped_ball_reaches_the_depth_and_the_force_of_the_energy_balance() {
    // The ball starts just above the floor, with the speed of a fall of 0.5 m.
    let (start, speed) = (0.1005, (2.0 * GRAVITY * 0.4995_f64).sqrt());
    let world = with_gravity(ball_over_floor(Material::elastic(1e6), start, -speed));
    let time_step = 2e-5;
    let mut rollout = world.rollout(&Plan::new(time_step, 0).unwrap());
    let turning = rollout.find(|state| upward(state.as_ref().unwrap()) >= 0.0);
    let lowest = turning.unwrap().unwrap();
    let depth = 0.1 - height(&lowest);
    assert!((depth / 0.017_446_8 - 1.0).abs() < TABLE, "{depth}");
    // The force follows from the change of velocity over one step at the turning point.
    let next = rollout.next().unwrap().unwrap();
    let force = (upward(&next) - upward(&lowest)) / time_step + GRAVITY;
    assert!((force / 845.045 - 1.0).abs() < TABLE, "{force}");
}

#[test]
fn a_ball_swings_about_its_rest_depth_with_the_period_of_the_linear_stiffness() {
    let (rest_depth, amplitude) = (1.777_659e-3, 2e-6);
    let start = 0.1 - rest_depth + amplitude;
    let world = with_gravity(ball_over_floor(Material::elastic(1e6), start, 0.0));
    let time_step = 5e-5;
    let rollout = world.rollout(&Plan::new(time_step, 3_599).unwrap());
    let states: Vec<State> = rollout.take(3_599).map(Result::unwrap).collect();
    // The mean over whole periods is the rest depth, and the period is the time between downward crossings.
    let mut crossings = Vec::new();
    let mean = states.iter().map(height).sum::<f64>() / states.len() as f64;
    for pair in states.windows(2) {
        let (before, after) = (height(&pair[0]) - mean, height(&pair[1]) - mean);
        if before > 0.0 && after <= 0.0 {
            crossings.push(pair[0].time + time_step * before / (before - after));
        }
    }
    assert!(crossings.len() >= 2, "{crossings:?}");
    let period = (crossings[crossings.len() - 1] - crossings[0]) / (crossings.len() - 1) as f64;
    assert!((period / 0.059_987_5 - 1.0).abs() < TABLE, "{period}");
    assert!(
        ((0.1 - mean) / rest_depth - 1.0).abs() < TABLE,
        "{}",
        0.1 - mean
    );
}

/// Returns the derivatives of the named body's final position with respect to its initial position and velocity along an axis.
fn by_start(world: &World, body: &str, axis: usize, time_step: f64, steps: usize) -> [f64; 2] {
    let experiment = Experiment::new(world, &Plan::new(time_step, steps).unwrap());
    let outcome = FinalPosition::of_body(world, body).unwrap();
    let parameters = [
        Parameter::initial_position(body),
        Parameter::initial_velocity(body),
    ];
    let jacobian = experiment.jacobian(&parameters, &outcome).unwrap().jacobian;
    [jacobian[(axis, axis)], jacobian[(axis, 3 + axis)]]
}

#[test]
fn a_lossless_bounce_mirrors_the_start_at_any_stiffness() {
    let ball = Arc::new(icosphere(0.1, 2));
    // 0.3 s in steps of 50, 25 and 10 µs, because stiffer balls have shorter bounces.
    for (modulus, steps) in [(1e4, 6_000), (1e5, 12_000), (1e6, 30_000)] {
        let skin = Material::elastic(modulus);
        let falling = dynamic("ball", Arc::clone(&ball), skin, 1.0);
        let falling = falling
            .with_pose(at(0.0, 0.0, 0.15))
            .with_velocity(vector![0.0, 0.0, -1.0]);
        let world = World::new(vec![falling, floor(skin)]).unwrap();
        let error = (by_start(&world, "ball", 2, 0.3 / steps as f64, steps)[0] + 1.0).abs();
        assert!(error <= MIRROR, "{modulus:e}: {error:e}");
    }
}

#[test]
fn the_derivative_through_a_bounce_converges_at_second_order() {
    let ball = Arc::new(icosphere(0.1, 2));
    let skin = Material::elastic(1e4);
    let falling = dynamic("ball", ball, skin, 1.0);
    let falling = falling
        .with_pose(at(0.0, 0.0, 0.15))
        .with_velocity(vector![0.0, 0.0, -1.0]);
    let world = World::new(vec![falling, floor(skin)]).unwrap();
    // The error depends on the times within a step at which contact begins and ends, so the test averages over several starts.
    let error = |steps: usize| {
        let errors = (0..8).map(|k| {
            let steps = steps + k * steps / 50;
            (by_start(&world, "ball", 2, 0.3 / steps as f64, steps)[0] + 1.0).powi(2)
        });
        (errors.sum::<f64>() / 8.0).sqrt()
    };
    let order = (error(600) / error(2_400)).log(4.0);
    assert!(order > 1.7, "order {order}");
}

#[test]
fn hunt_crossley_restitution_is_that_of_the_integrated_law() {
    for (product, ratio) in [(0.1, 0.937_476), (0.5, 0.748_435), (1.0, 0.593_624)] {
        let material = Material {
            dissipation: product,
            ..Material::elastic(1e5)
        };
        let ball = Arc::new(icosphere(0.1, 2));
        let falling = dynamic("ball", ball, material, 1.0);
        let falling = falling
            .with_pose(at(0.0, 0.0, 0.11))
            .with_velocity(vector![0.0, 0.0, -1.0]);
        // Against a rigid floor, the whole surface is flat, and its normal is along the velocity.
        let rigid = Material {
            modulus: Some(RIGID),
            ..material
        };
        let world = World::new(vec![falling, floor(rigid)]).unwrap();
        let plan = Plan::new(1e-5, 12_000).unwrap().recording_every(12_000);
        let trajectory = world.rollout(&plan).run().unwrap();
        let rebound = upward(trajectory.last());
        assert!(
            (rebound - ratio).abs() < RESTITUTION,
            "{product}: {rebound}"
        );
    }
}

/// Collides two equal balls on a line, the second of which is at rest. Returns the derivatives of the second ball's position after 1 s with
/// respect to both positions and both velocities.
fn by_starts_of_two_balls(modulus: f64, steps: usize) -> [f64; 4] {
    let ball = Arc::new(fine_ball(0.1, 24, 16));
    let body = |name: &str| {
        let (shape, skin) = (Arc::clone(&ball), Material::elastic(modulus));
        Body::dynamic(name, shape, skin, sphere_inertia(1.0, 0.1)).unwrap()
    };
    let first = body("first").with_velocity(vector![0.0, 0.0, 1.0]);
    let world = World::new(vec![first, body("second").with_pose(at(0.0, 0.0, 0.52))]).unwrap();
    let plan = Plan::new(1.0 / steps as f64, steps).unwrap();
    let experiment = Experiment::new(&world, &plan.recording_every(steps));
    let parameters = [
        Parameter::initial_position("first"),
        Parameter::initial_position("second"),
        Parameter::initial_velocity("first"),
        Parameter::initial_velocity("second"),
    ];
    let jacobian = experiment
        .jacobian(
            &parameters,
            &FinalPosition::of_body(&world, "second").unwrap(),
        )
        .unwrap();
    [2, 5, 8, 11].map(|column| jacobian.jacobian[(2, column)])
}

fn assert_exchanged([x1, x2, v1, v2]: [f64; 4], epsilon: f64, mesh: f64) {
    assert!((x1 + x2 - 1.0).abs() <= SUMS && (v1 + v2 - 1.0).abs() <= SUMS);
    assert!((x1 - 1.0).abs() <= TABLE && x2.abs() <= TABLE, "{x1} {x2}");
    assert!((v2 / epsilon - 1.0).abs() <= mesh, "{v2}");
}

#[test]
fn two_balls_on_a_line_exchange_the_derivatives_by_their_starts() {
    // ε is that of smooth spheres. With stiffer balls, fewer triangles touch.
    assert_exchanged(by_starts_of_two_balls(1e5, 10_000), 0.020_784, 0.01);
    assert_exchanged(by_starts_of_two_balls(1e6, 20_000), 0.009_399, 0.03);
}

#[test]
fn the_sums_of_derivatives_by_two_starts_hold_at_any_time_step() {
    for (modulus, steps) in [(1e4, 200), (1e5, 700), (1e8, 3_000)] {
        let [x1, x2, v1, v2] = by_starts_of_two_balls(modulus, steps);
        let sums = [x1 + x2 - 1.0, v1 + v2 - 1.0];
        assert!(sums.iter().all(|sum| sum.abs() <= SUMS), "{sums:?}");
    }
}

#[test]
#[ignore = "half a million steps in dual numbers: a minute"]
fn two_stiff_balls_exchange_the_derivatives_by_their_starts() {
    assert_exchanged(by_starts_of_two_balls(1e8, 500_000), 0.001_991_9, 0.07);
}

/// Returns a flat block of 1 kg at rest on the floor, pressed in by its weight.
fn resting_block(material: Material, tilt: f64) -> World {
    let block = Arc::new(cuboid([0.3, 0.3, 0.04]));
    let block = dynamic("block", block, material, 1.0);
    let body_height = 0.02 - tilt.cos() * REST_DEPTH_OF_BLOCK;
    let world = World::new(vec![
        block.with_pose(at(0.0, 0.0, body_height)),
        floor(material),
    ])
    .unwrap();
    let down = vector![tilt.sin(), 0.0, -tilt.cos()] * GRAVITY;
    world.with_gravity(down).unwrap()
}

/// Rest depth (m) of the block: its weight divided by area times pressure gradient, 50 and 4 MPa/m in series. It is nearly exact, so the
/// block hardly oscillates. The dissipation that damps the remaining motion also acts at the block's rim, by 2e-4 of the friction at 1 s/m.
const REST_DEPTH_OF_BLOCK: f64 = GRAVITY / (0.09 * 3.704e6);

#[test]
fn a_sliding_block_stops_after_the_distance_of_coulomb_friction() {
    let material = Material {
        dissipation: 1.0,
        friction: Some(0.5),
        ..Material::elastic(1e6)
    };
    let speed = 1.0;
    let world = sliding(&resting_block(material, 0.0), speed);
    let plan = Plan::new(2e-5, 20_000).unwrap().recording_every(20_000);
    let last = world.rollout(&plan).run();
    let distance = last.unwrap().last().bodies[0].pose.translation().x;
    let expected = speed * speed / (2.0 * 0.5 * GRAVITY);
    assert!(
        (distance / expected - 1.0).abs() < TABLE,
        "{distance} {expected}"
    );
}

fn sliding(world: &World, speed: f64) -> World {
    let bodies = world.bodies().to_vec();
    let [block, floor]: [Body; 2] = bodies.try_into().unwrap();
    let gravity = *world.gravity();
    let world = World::new(vec![block.with_velocity(vector![speed, 0.0, 0.0]), floor]).unwrap();
    world
        .with_gravity(gravity)
        .unwrap()
        .with_slip_tolerance(1e-4)
        .unwrap()
}

#[test]
fn a_block_slides_down_an_incline_with_the_acceleration_that_friction_leaves() {
    let (tilt, friction) = (0.5_f64, 0.3);
    let material = Material {
        dissipation: 1.0,
        friction: Some(friction),
        ..Material::elastic(1e6)
    };
    let world = resting_block(material, tilt)
        .with_slip_tolerance(1e-4)
        .unwrap();
    let plan = Plan::new(2e-5, 20_000).unwrap().recording_every(10_000);
    let states = world.rollout(&plan).run().unwrap();
    let [_, middle, end] = states.states() else {
        panic!("three states are recorded")
    };
    let speed = |state: &State| state.bodies[0].twist.linear.x;
    let actual = (speed(end) - speed(middle)) / (end.time - middle.time);
    let expected = GRAVITY * (tilt.sin() - friction * tilt.cos());
    assert!(
        (actual / expected - 1.0).abs() < TABLE,
        "{actual} {expected}"
    );
}
