//! A reverse-mode gradient stays within its memory limit, and has the same bits with any limit.

use hydroelastic::contact::{HalfSpace, Shape};
use hydroelastic::dynamics::{Body, Integrator, Mass, Material, Plan, Trajectory, World};
use hydroelastic::gradient::{Experiment, Mode, Outcome, Parameter};
use hydroelastic::mesh::shapes;
use hydroelastic::scalar::{Scalar, lift};
use hydroelastic::spatial::Pose;
use nalgebra::{DVector, vector};
use std::sync::Arc;

const BODIES: usize = 10;

/// Memory (bytes) that a gradient uses besides its stored steps, and for the smallest number of stored steps. Steps are divided as impacts
/// require. The ten bodies are ten islands, and a step keeps the links and the stages of all islands: 0.80 MB with `Sdirk3`.
const BESIDE: usize = 13 << 16;

/// Returns bricks that slide and rotate on a half-space, slightly lifted or pressed in, far from each other.
fn world() -> World {
    let skin = Material::elastic(1e5).with_friction(0.3);
    let skin = skin.with_dissipation(0.3);
    let shape = Arc::new(Shape::new(shapes::cuboid([0.2, 0.15, 0.1]).unwrap()));
    let brick = |number: usize| {
        let count = number as f64;
        let position = vector![0.5 * count, 0.0, 0.05 + 1e-4 * (count - 5.0)];
        let start = Pose::from_rotation_vector(&vector![0.0, 0.0, 0.3 * count], position);
        let mass = Mass::Total(1.0);
        let body = Body::dynamic(&format!("brick {number}"), Arc::clone(&shape), skin, mass);
        let body = body.unwrap().with_pose(start);
        body.with_velocity(vector![0.0, 0.1 * count, 0.0])
            .with_angular_velocity(vector![0.0, 0.0, 1.0])
    };
    let floor = Body::fixed("floor", HalfSpace::rigid(), Material::rigid()).unwrap();
    let bodies = (0..BODIES).map(brick).chain([floor]).collect();
    let world = World::new(bodies).unwrap();
    world.with_gravity(vector![0.0, 0.0, -9.81]).unwrap()
}

/// Sum of all final heights (m) and rotations.
struct Heights;

impl Outcome for Heights {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        let bodies = trajectory.last().bodies.iter();
        let number = |pose: &Pose<T>| pose.translation().z + pose.rotation()[(0, 1)];
        vec![bodies.fold(lift(0.0), |sum, body| sum + number(&body.pose))]
    }
}

/// Returns the gradient of an experiment with a memory limit (bytes), and the largest memory use.
fn swept(experiment: &Experiment, memory: usize) -> (DVector<f64>, usize) {
    let _profiler = dhat::Profiler::builder().testing().build();
    let starts = |number: usize| {
        let name: Arc<str> = format!("brick {number}").into();
        let velocity = Parameter::InitialVelocity(Arc::clone(&name));
        [velocity, Parameter::Friction(name)]
    };
    let parameters: Vec<_> = (0..BODIES).flat_map(starts).collect();
    let experiment = experiment.clone().with_memory(memory);
    let swept = experiment.gradient_with_mode(Mode::Reverse, &parameters, &Heights);
    let (_, gradient) = swept.unwrap();
    (gradient, dhat::HeapStats::get().max_bytes)
}

/// Checks that gradients with these memory limits (bytes) have the same bits, and use no more than the limit and [`BESIDE`].
fn compare(integrator: Integrator, (time_step, steps): (f64, usize), memories: &[usize]) {
    let _alone = crate::alone();
    let plan = Plan::new(time_step, steps).unwrap();
    let plan = plan.with_integrator(integrator).recording_every(steps);
    let experiment = Experiment::new(world(), &plan);
    let mut gradients = Vec::new();
    for &memory in memories {
        let (gradient, most) = swept(&experiment, memory);
        println!("{steps} steps, {integrator:?}: {most} bytes of {memory}");
        assert!(most <= memory + BESIDE, "{most} bytes of {memory}");
        assert!(gradient.amax() > 0.0);
        gradients.push(gradient);
    }
    assert!(gradients.windows(2).all(|pair| pair[0] == pair[1]));
}

/// All steps take 3.2 MB.
#[test]
fn explicit_sweeps_take_the_memory_they_are_given() {
    let memories = [0, 200_000, 2_000_000, 4_000_000];
    compare(Integrator::Leapfrog, (5e-4, 2_000), &memories);
}

#[test]
fn implicit_sweeps_take_the_memory_they_are_given() {
    for integrator in [Integrator::ImplicitEuler, Integrator::Sdirk3] {
        compare(integrator, (5e-3, 100), &[0, 70_000, 1_000_000]);
    }
}

/// The longest rollouts take tens of minutes.
#[test]
#[ignore = "tens of minutes"]
fn a_million_steps_of_ten_bodies() {
    let memories = [10_000_000 - BESIDE, 1_100_000_000 - BESIDE];
    compare(Integrator::Leapfrog, (2e-4, 1_000_000), &memories);
}
