//! Free rotating bodies: their path, energy, angular momentum, flips and time reversal.

use crate::scenes::{ROUND_OFF, SKIN, asymmetric, at, ball_shape, floor, leapfrog};
use crate::support::worlds::{EXPLICIT, dynamic, falling, plan_of};
use hydroelastic::contact::Shape;
use hydroelastic::dynamics::{Body, BodyState, Mass, Plan, State, World};
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::{MassProperties, Pose, rotation_from_vector};
use nalgebra::{Matrix3, Vector3, vector};
use std::sync::Arc;

/// Rounding error, amplified by the sensitivity of a tumbling or bouncing body.
const REVERSED: f64 = 1e-9;

/// Returns a free body with the given mass properties that translates and rotates.
fn tumbling(properties: MassProperties, spin: Vector3<f64>) -> World {
    let body = Body::dynamic("body", ball_shape(), SKIN, Mass::Properties(properties)).unwrap();
    let start = Pose::from_rotation_vector(&vector![0.5, 0.1, -0.4], vector![0.3, -0.2, 0.1]);
    let moving = body.with_pose(start).with_velocity(vector![0.2, -0.1, 0.3]);
    World::new(vec![moving.with_angular_velocity(spin)]).unwrap()
}

/// Returns equal moments about a center of mass off the origin.
fn off_center_sphere() -> MassProperties {
    MassProperties {
        inertia: Matrix3::identity() * 0.02,
        ..asymmetric()
    }
}

fn center_of_mass(world: &World, state: &State) -> Vector3<f64> {
    let inertia = world.bodies()[0].inertia().unwrap();
    state.bodies[0]
        .pose
        .transformed_point(&inertia.center_of_mass)
}

#[test]
fn a_free_body_turns_about_its_center_of_mass_which_moves_straight() {
    for properties in [asymmetric(), off_center_sphere()] {
        let world = tumbling(properties, vector![3.0, -2.0, 5.0]);
        let start = world.initial_state();
        let [from, velocity] = [center_of_mass(&world, &start), start.bodies[0].twist.linear];
        for integrator in EXPLICIT {
            let mut origin_strayed = 0.0_f64;
            for state in world.rollout(&plan_of(integrator, 1e-3, 5_000)).take(5_000) {
                let state = state.unwrap();
                let straight = from + velocity * state.time;
                let off = center_of_mass(&world, &state) - straight;
                assert!(off.amax() <= ROUND_OFF, "{off}");
                assert_eq!(state.bodies[0].twist.linear, velocity);
                let origin = state.bodies[0].pose.translation() - velocity * state.time;
                let strayed = origin - start.bodies[0].pose.translation();
                origin_strayed = origin_strayed.max(strayed.norm());
            }
            assert!(
                origin_strayed > 0.01,
                "the origin moves on a circle: {origin_strayed}"
            );
        }
    }
}

#[test]
fn a_body_of_equal_moments_turns_as_the_exponential_map_says() {
    let spin = vector![3.0, -2.0, 5.0];
    let world = tumbling(off_center_sphere(), spin);
    let start = *world.initial_state().bodies[0].pose.rotation();
    for integrator in EXPLICIT {
        let last = world.rollout(&plan_of(integrator, 1e-2, 1_000)).nth(999);
        let last = last.unwrap().unwrap();
        let exact = rotation_from_vector(&(spin * 10.0)) * start;
        let off = (last.bodies[0].pose.rotation() - exact).amax();
        assert!(off <= ROUND_OFF, "{off:e}");
        assert_eq!(last.bodies[0].twist.angular, spin);
    }
}

/// Returns the largest relative deviation of the kinetic energy of the asymmetric top in 50 s with `steps` steps.
fn energy_deviation(steps: usize) -> f64 {
    let world = tumbling(asymmetric(), vector![3.0, -2.0, 5.0]);
    let kinetic = |state: &State| world.diagnostics(state).unwrap().kinetic_energy;
    let start = kinetic(&world.initial_state());
    let states = leapfrog(&world, 50.0 / steps as f64).take(steps);
    states
        .map(|state| (kinetic(&state.unwrap()) / start - 1.0).abs())
        .fold(0.0, f64::max)
}

#[test]
fn an_asymmetric_top_keeps_its_energy_to_second_order_without_drift() {
    let (coarse, fine) = (energy_deviation(12_500), energy_deviation(50_000));
    assert!(fine < 1e-5, "{fine:e}");
    assert!(
        (coarse / fine / 16.0 - 1.0).abs() < 0.1,
        "{coarse:e} {fine:e}"
    );
}

#[test]
fn an_asymmetric_top_keeps_its_angular_momentum() {
    let world = tumbling(asymmetric(), vector![3.0, -2.0, 5.0]);
    let start = world
        .diagnostics(&world.initial_state())
        .unwrap()
        .momentum
        .angular;
    for integrator in EXPLICIT {
        for state in world
            .rollout(&plan_of(integrator, 1e-3, 10_000))
            .take(10_000)
        {
            let now = world.diagnostics(&state.unwrap()).unwrap().momentum.angular;
            let off = (now - start).amax() / start.amax();
            assert!(off <= 10.0 * ROUND_OFF, "{off:e}");
        }
    }
}

#[test]
fn the_leapfrog_run_backwards_returns_to_the_start() {
    // A free top, and an elastic bounce with rotation.
    let top = tumbling(asymmetric(), vector![3.0, -2.0, 5.0]);
    let egg = Arc::new(Shape::new(shapes::ellipsoid([0.1, 0.14, 0.12], 1).unwrap()));
    let egg = dynamic("egg", egg, SKIN, 1.0);
    let thrown = egg
        .with_pose(at(0.0, 0.0, 0.2))
        .with_angular_velocity(vector![1.0, 2.0, 0.5]);
    let bounce = falling(vec![thrown, floor(SKIN)]);
    for (world, touches) in [(top, false), (bounce, true)] {
        let plan = Plan::new(1e-3, 400).unwrap();
        let there = world.rollout(&plan).run().unwrap();
        let mut touching = there
            .states()
            .iter()
            .filter(|state| world.topology(state).unwrap().polygon_count() > 0);
        assert_eq!(touching.next().is_some(), touches);
        let turned = world
            .rollout(&plan.recording_every(400))
            .with_state(reversed(there.last()))
            .unwrap();
        let back = reversed(turned.run().unwrap().last());
        let off = distance(&back.bodies[0], &world.initial_state().bodies[0]);
        assert!(off <= REVERSED, "{off:e}");
    }
}

fn reversed(state: &State) -> State {
    let mut state = state.clone();
    for body in &mut state.bodies {
        body.twist.linear.neg_mut();
        body.twist.angular.neg_mut();
    }
    state
}

/// Returns the largest difference between the numbers of two states.
fn distance(a: &BodyState, b: &BodyState) -> f64 {
    let pose = (a.pose.translation() - b.pose.translation()).amax();
    let turn = (a.pose.rotation() - b.pose.rotation()).amax();
    let linear = (a.twist.linear - b.twist.linear).amax();
    let angular = (a.twist.angular - b.twist.angular).amax();
    pose.max(turn).max(linear).max(angular)
}

/// Returns the angular velocity (rad/s) about a principal axis, in the body's frame, over 60 s after a slightly tilted start.
fn spins_about(axis: usize) -> Vec<f64> {
    let properties = MassProperties {
        center_of_mass: Vector3::zeros(),
        inertia: Matrix3::from_diagonal(&vector![0.01, 0.02, 0.025]),
        mass: 1.0,
    };
    let spin = Vector3::ith(axis, 5.0) + vector![0.01, 0.01, 0.01];
    let body = Body::dynamic("wingnut", ball_shape(), SKIN, Mass::Properties(properties)).unwrap();
    let world = World::new(vec![body.with_angular_velocity(spin)]).unwrap();
    let states = leapfrog(&world, 2e-3).take(30_000).map(Result::unwrap);
    let seen_from_body = |state: State| {
        let BodyState { pose, twist } = &state.bodies[0];
        (pose.rotation().transpose() * twist.angular)[axis]
    };
    states.map(seen_from_body).collect()
}

#[test]
fn a_wingnut_flips_about_its_intermediate_axis_and_no_other() {
    for axis in [0, 2] {
        let spins = spins_about(axis);
        assert!(spins.iter().all(|spin| (spin / 5.0 - 1.0).abs() < 0.01));
    }
    let spins = spins_about(1);
    let flips = spins.windows(2).filter(|pair| pair[0] * pair[1] < 0.0);
    let flips = flips.count();
    assert!((8..40).contains(&flips), "{flips}");
    let (low, high) = spins.iter().fold((0.0_f64, 0.0_f64), |(low, high), &spin| {
        (low.min(spin), high.max(spin))
    });
    assert!(
        (low / 5.0 + 1.0).abs() < 0.01 && (high / 5.0 - 1.0).abs() < 0.01,
        "{low} {high}"
    );
}
