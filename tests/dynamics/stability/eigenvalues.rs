//! The largest stable time step against the eigenvalues of one step.

use super::scenes::{bisected, limit, slab};
use crate::support::scenes::Random;
use crate::support::worlds::{EXPLICIT, dynamic, rubbing, starts};
use hydroelastic::contact::Shape;
use hydroelastic::dynamics::{Integrator, Material, Plan, World};
use hydroelastic::gradient::{Experiment, FinalState};
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::Pose;
use nalgebra::{DMatrix, Matrix3, vector};

/// Relative difference between the limit and the step at which an eigenvalue of one step leaves the unit circle at −1. The cause is the
/// stiffness due to sliding friction, which is not part of the limit.
const EIGENVALUES: f64 = 2e-2;

/// Relative difference without friction and at rest, for bodies that are not in equilibrium. Their torque rotates with them, which is not a
/// stiffness.
const EIGENVALUES_AT_REST: f64 = 2e-3;

/// Returns the derivative of a body's state after one step with respect to the state before: position, rotation vector, velocity, angular
/// velocity.
fn step_matrix(world: &World, body: &str, time_step: f64, integrator: Integrator) -> DMatrix<f64> {
    let by = starts(body);
    let plan = Plan::new(time_step, 1).unwrap().without_stability_check();
    let experiment = Experiment::new(world, &plan.with_integrator(integrator));
    let outcome = FinalState::of_body(world, body).unwrap();
    let outcome_jacobian = experiment.jacobian(&by, &outcome).unwrap();
    let rotation = Matrix3::from_column_slice(&outcome_jacobian.value.as_slice()[3..12]);
    DMatrix::from_fn(12, 12, |row, column| {
        let slopes = outcome_jacobian.jacobian.column(column);
        match row {
            0..3 => slopes[row],
            3..6 => {
                let turn = Matrix3::from_iterator(slopes.iter().skip(3).take(9).copied());
                let turn = turn * rotation.transpose();
                let (i, j) = ((row - 3 + 1) % 3, (row - 3 + 2) % 3);
                (turn[(j, i)] - turn[(i, j)]) / 2.0
            }
            _ => slopes[row + 6],
        }
    })
}

/// Returns the time step at which the first mode of one step begins to alternate and grow. When an eigenvalue μ of the step's matrix passes
/// −1, the product of all 1 + μ changes sign.
fn flipping_step(world: &World, body: &str, guess: f64, integrator: Integrator) -> f64 {
    let has_flipped = |step: f64| {
        let matrix = step_matrix(world, body, step, integrator);
        (matrix + DMatrix::identity(12, 12)).determinant() < 0.0
    };
    let steps = (1..=100).map(|index| guess * (0.8 + 0.005 * f64::from(index)));
    assert!(!has_flipped(0.8 * guess));
    let beyond = steps.into_iter().find(|&step| has_flipped(step)).unwrap();
    bisected([beyond - 0.005 * guess, beyond], 1e-6, has_flipped)
}

/// Returns an ellipsoid or a brick pressed into a slab at an angle. No two of its modes are equal, because the sign of the product would
/// then change twice at once.
fn askew(random: &mut Random, skin: Material) -> World {
    let fields = [
        shapes::ellipsoid([0.1, 0.15, 0.2], 2),
        shapes::cuboid([0.2, 0.25, 0.3]),
    ];
    let shape = Shape::new(fields[random.below(2)].clone().unwrap());
    let height = random.between(0.09, 0.13);
    let pose = Pose::from_rotation_vector(&random.rotation_vector(), vector![0.03, 0.05, height]);
    let body = dynamic("body", shape, skin, 1.0);
    World::new(vec![body.with_pose(pose), slab(skin)]).unwrap()
}

/// Returns the largest relative differences between limits and eigenvalue crossings, over worlds with contact.
fn worst_of_eigenvalues(skin: Material, speed: f64, integrator: Integrator) -> [f64; 2] {
    let mut random = Random::new(7);
    let mut range = [f64::INFINITY, f64::NEG_INFINITY];
    let mut compared = 0;
    while compared < 30 {
        let mut world = askew(&mut random, skin);
        let state = world.initial_state();
        let mut bodies = world.bodies().to_vec();
        bodies[0] = bodies[0]
            .clone()
            .with_velocity(random.vector() * speed)
            .with_angular_velocity(random.vector() * (speed / 0.15));
        if world.largest_stable_step(&state).unwrap().is_none() {
            continue;
        }
        world = World::new(bodies).unwrap();
        let step_limit = limit(&world);
        let ratio = step_limit / flipping_step(&world, "body", step_limit, integrator) - 1.0;
        range = [range[0].min(ratio), range[1].max(ratio)];
        compared += 1;
    }
    println!("{skin:?} at {speed} m/s, {integrator:?}: {range:?}");
    range
}

#[test]
fn eigenvalues_of_an_elastic_step_cross_at_the_limit() {
    let skin = Material::elastic(1e6);
    for integrator in EXPLICIT {
        let [low, high] = worst_of_eigenvalues(skin, 0.0, integrator);
        assert!(low >= -EIGENVALUES_AT_REST && high <= EIGENVALUES_AT_REST);
    }
}

#[test]
fn eigenvalues_of_a_step_that_rubs_cross_near_the_limit() {
    for (dissipation, friction) in [(0.3, 0.0), (0.0, 0.5), (0.3, 0.5)] {
        let skin = rubbing(1e6, dissipation, friction);
        // Speeds within and far above the slip tolerance.
        for speed in [0.0, 1e-4, 0.3] {
            let [low, high] = worst_of_eigenvalues(skin, speed, Integrator::SymplecticEuler);
            assert!(low >= -EIGENVALUES && high <= EIGENVALUES, "{low} {high}");
        }
    }
}
