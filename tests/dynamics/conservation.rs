//! Conserved quantities of a rollout: energy, momentum, angular momentum, orthonormality.

use crate::scenes::at;
use crate::support::worlds::{cuboid, dynamic, falling, fixed, icosphere, plan_of};
use hydroelastic::contact::Shape;
use hydroelastic::dynamics::{Body, Integrator, Mass, Material, Plan, State, World};
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::{MassProperties, Pose};
use nalgebra::{Matrix3, Vector3, vector};
use std::sync::Arc;

/// Momentum error of a step, relative to the exchanged momentum.
const MOMENTUM: f64 = 1e-11;

/// Error of the angular momentum. Each step converts angular momentum to angular velocity and back, and the rounding errors of 10⁶ steps
/// all have the same sign: 20 units in the last place per step.
const MILLION_ROUNDINGS: f64 = 1e-8;

/// Returns a ball that bounces on a box forever, without friction and dissipation.
fn bouncing_ball() -> World {
    let ball = Arc::new(icosphere(0.1, 1));
    let slab = Arc::new(cuboid([1.0, 1.0, 0.4]));
    let skin = Material::elastic(2e4);
    let ball = dynamic("ball", ball, skin, 1.0);
    let slab = fixed("slab", slab, skin);
    falling(vec![
        ball.with_pose(at(0.0, 0.0, 0.15)),
        slab.with_pose(at(0.0, 0.0, -0.2)),
    ])
}

fn total_energy(world: &World, state: &State) -> f64 {
    world.diagnostics(state).unwrap().total_energy()
}

/// Returns the largest deviation of the total energy from its initial value, relative to the energy of the fall, sampled at intervals of
/// the steps.
fn energy_drift(time_step: f64, steps: usize, integrator: Integrator) -> f64 {
    let world = bouncing_ball();
    let start = total_energy(&world, &world.initial_state());
    // The ball falls 5 cm.
    let scale = 9.81 * 0.05;
    let rollout = world
        .rollout(&plan_of(integrator, time_step, steps))
        .take(steps);
    let seen = rollout.map(Result::unwrap).step_by(97);
    seen.map(|state| (total_energy(&world, &state) - start).abs() / scale)
        .fold(0.0, f64::max)
}

#[test]
fn the_energy_of_a_bouncing_ball_stays_within_the_order_of_the_scheme() {
    // 20 s, about sixty bounces, at two time steps.
    let drifts = |integrator| {
        [20_000, 80_000].map(|steps| energy_drift(20.0 / steps as f64, steps, integrator))
    };
    let [coarse, fine] = drifts(Integrator::Leapfrog);
    assert!(
        coarse < 1e-2 && coarse / fine > 8.0,
        "second order: {coarse:e} {fine:e}"
    );
    let [coarse, fine] = drifts(Integrator::SymplecticEuler);
    assert!(
        coarse < 1e-1 && coarse / fine > 2.5,
        "first order: {coarse:e} {fine:e}"
    );
}

#[test]
#[ignore = "a million steps, three times: half a minute"]
fn the_energy_of_a_million_steps_is_bounded() {
    for dt in [1e-3, 5e-4, 2.5e-4] {
        let drift = energy_drift(dt, 1_000_000, Integrator::Leapfrog);
        println!("time step {dt:e} s: relative energy drift {drift:.2e} over 10⁶ steps");
        assert!(drift < 1e-2 * (dt / 1e-3).powi(2) * 2.0);
    }
}

#[test]
fn two_colliding_bodies_conserve_momentum_and_angular_momentum_in_every_step() {
    let block = Arc::new(cuboid([0.2, 0.3, 0.15]));
    let egg = Arc::new(Shape::new(shapes::ellipsoid([0.1, 0.14, 0.12], 1).unwrap()));
    // Momentum is conserved with friction and dissipation too, because all forces occur in opposite pairs.
    for (dissipation, friction) in [(0.0, 0.0), (0.5, 0.4)] {
        let skin = Material {
            dissipation,
            friction: Some(friction),
            ..Material::elastic(1e5)
        };
        let block = Body::dynamic("block", Arc::clone(&block), skin, Mass::Density(100.0)).unwrap();
        let egg = dynamic("egg", Arc::clone(&egg), skin, 0.8);
        let world = World::new(vec![
            block
                .with_velocity(vector![0.3, 0.0, 0.1])
                .with_angular_velocity(vector![0.5, -1.0, 2.0]),
            egg.with_pose(at(0.35, 0.05, 0.08))
                .with_velocity(vector![-1.0, 0.1, 0.0]),
        ])
        .unwrap();
        for integrator in [Integrator::SymplecticEuler, Integrator::Leapfrog] {
            assert_momentum_stays(&world, integrator);
        }
    }
}

fn assert_momentum_stays(world: &World, integrator: Integrator) {
    let mut before = world.diagnostics(&world.initial_state()).unwrap().momentum;
    let exchanged = before.linear.norm() + before.angular.norm();
    let mut touching = 0;
    for state in world.rollout(&plan_of(integrator, 1e-3, 400)).take(400) {
        let state = state.unwrap();
        let after = world.diagnostics(&state).unwrap().momentum;
        let linear = (after.linear - before.linear).amax();
        let angular = (after.angular - before.angular).amax();
        assert!(
            linear.max(angular) <= MOMENTUM * exchanged,
            "{linear:e} {angular:e}"
        );
        touching += usize::from(world.topology(&state).unwrap().polygon_count() > 0);
        before = after;
    }
    assert!(touching > 20, "bodies touch in {touching} of 400 steps");
}

/// Returns a body without neighbors that has the inertia of a box.
fn free_box(lengths: [f64; 3], spin: Vector3<f64>) -> World {
    let shape = cuboid(lengths);
    let body = dynamic("box", shape, Material::elastic(1e5), 1.0);
    let tilted = Pose::from_rotation_vector(&vector![0.5, 0.1, -0.4], Vector3::zeros());
    World::new(vec![body.with_pose(tilted).with_angular_velocity(spin)]).unwrap()
}

#[test]
fn free_boxes_of_any_shape_keep_energy_and_momentum() {
    let (rod, needle, plate) = ([0.01, 0.01, 0.3], [0.002, 0.002, 0.3], [0.3, 0.3, 0.01]);
    let (fast, tumbling) = (vector![10.0, 0.0, 30.0], vector![0.1, 20.0, 0.1]);
    for (lengths, spin, bound) in [
        (rod, fast, MILLION_ROUNDINGS),
        (needle, fast, MILLION_ROUNDINGS),
        (plate, fast, MILLION_ROUNDINGS),
        // The error is of second order in the step.
        ([0.2, 0.1, 0.05], tumbling, 1e-5),
        ([0.3, 0.2, 0.01], fast, 1e-4),
    ] {
        let world = free_box(lengths, spin);
        let start = world.diagnostics(&world.initial_state()).unwrap();
        for integrator in [Integrator::SymplecticEuler, Integrator::Leapfrog] {
            let (mut energy, mut momentum) = (0.0_f64, 0.0_f64);
            for state in world
                .rollout(&plan_of(integrator, 1e-3, 30_000))
                .take(30_000)
            {
                let now = world.diagnostics(&state.unwrap()).unwrap();
                energy = energy.max((now.total_energy() / start.total_energy() - 1.0).abs());
                let off = (now.momentum.angular - start.momentum.angular).amax();
                momentum = momentum.max(off / start.momentum.angular.amax());
            }
            println!("{lengths:?}, {integrator:?}: energy {energy:.1e}, momentum {momentum:.1e}");
            assert!(energy < bound, "{lengths:?}: {energy:e}");
            assert!(momentum < MILLION_ROUNDINGS, "{lengths:?}: {momentum:e}");
        }
    }
}

/// Returns the orientation of a free body with these moments (kg m²) after one second in `steps` steps.
fn orientation_of(moments: [f64; 3], steps: usize) -> Matrix3<f64> {
    let properties = MassProperties {
        mass: 1.0,
        center_of_mass: Vector3::zeros(),
        inertia: Matrix3::from_diagonal(&Vector3::from(moments)),
    };
    let shape = icosphere(0.1, 0);
    let mass = Mass::Properties(properties);
    let body = Body::dynamic("body", shape, Material::elastic(1e5), mass).unwrap();
    let world = World::new(vec![body.with_angular_velocity(vector![3.0, -5.0, 2.0])]).unwrap();
    let mut rollout = world.rollout(&Plan::new(1.0 / steps as f64, steps).unwrap());
    let last = rollout.nth(steps - 1).unwrap().unwrap();
    *last.bodies[0].pose.rotation()
}

#[test]
fn free_spheres_and_symmetric_tops_turn_exactly() {
    /// Rounding error of thousands of steps.
    const ROUND_OFF: f64 = 1e-11;
    for moments in [
        [0.02; 3],
        [0.01, 0.02, 0.02],
        [0.02, 0.015, 0.02],
        [0.02, 0.02, 0.03],
    ] {
        let off = orientation_of(moments, 2) - orientation_of(moments, 2_000);
        assert!(off.amax() < ROUND_OFF, "{moments:?}: {:e}", off.amax());
    }
}

#[test]
fn free_rotation_is_continuous_in_the_moments() {
    /// Rounding error of a thousand steps.
    const ROUND_OFF: f64 = 1e-12;
    for steps in [10, 100, 1_000] {
        let sphere = orientation_of([0.02; 3], steps);
        for change in [1e-13, 1e-11, 1e-9, 1e-6, -1e-11, -1e-6] {
            let moments = [0.02, 0.02 * (1.0 + change), 0.02 * (1.0 + 2.0 * change)];
            let off = (orientation_of(moments, steps) - sphere).amax();
            // After one second, with an angular velocity of 6 rad/s.
            assert!(
                off < 12.0 * change.abs() + ROUND_OFF,
                "{steps}, {change:e}: {off:e}"
            );
        }
    }
}

#[test]
fn rotations_stay_orthonormal_over_a_million_steps() {
    let brick = Arc::new(cuboid([0.1, 0.2, 0.3]));
    let skin = Material::elastic(1e5);
    let brick = dynamic("brick", brick, skin, 1.0);
    let world = World::new(vec![brick.with_angular_velocity(vector![1.0, 5.0, -3.0])]).unwrap();
    for integrator in [Integrator::SymplecticEuler, Integrator::Leapfrog] {
        let plan = plan_of(integrator, 1e-3, 1_000_000);
        let mut rollout = world.rollout(&plan);
        let last = rollout.nth(999_999).unwrap().unwrap();
        let rotation = last.bodies[0].pose.rotation();
        let deviation = (rotation.transpose() * rotation - Matrix3::identity()).amax();
        assert!(deviation < 1e-14, "{deviation:e}");
        assert!((rotation.determinant() - 1.0).abs() < 1e-14);
        let start: Vector3<f64> = world
            .diagnostics(&world.initial_state())
            .unwrap()
            .momentum
            .angular;
        let drift =
            (world.diagnostics(&last).unwrap().momentum.angular - start).amax() / start.amax();
        assert!(drift < MILLION_ROUNDINGS, "{drift:e}");
    }
}
