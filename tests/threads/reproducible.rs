//! A program gives the same bits in every run, with any number of threads: for states, Jacobians, batches and files.
//!
//! Shapes are created anew for each run, because the order of the standard library's hash maps differs each time. The tests print hashes of
//! the bits, to compare builds and machines:
//!
//! ```sh
//! cargo test --test threads reproducible:: -- --nocapture
//! cargo test --release --test threads reproducible:: -- --nocapture
//! CARGO_PROFILE_DEV_OPT_LEVEL=0 CARGO_PROFILE_TEST_OPT_LEVEL=0 cargo test --test threads reproducible:: -- --nocapture
//! ```
//!
//! The hashes of the first and the last build agreed. `every_processor.rs` compares bits with constants.

use crate::starts::starting_from;
use hydroelastic::contact::Shape;
use hydroelastic::dynamics::{Batch, Body, Integrator, Mass, Material, Plan, State, World};
use hydroelastic::gradient::{Experiment, FinalState, Outcome, Parameter};
use hydroelastic::io::{Recording, write_trajectory};
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::Pose;
use nalgebra::{Vector3, vector};
use std::path::Path;
use std::sync::Arc;

const TIME_STEP: f64 = 5e-4;
const STEPS: usize = 60;

/// Numbers of threads. Each is a separate run, and the first two are equal.
const THREADS: [usize; 5] = [1, 1, 2, 3, 8];

/// Returns twelve eggs with friction and dissipation that rotate, pressed into each other and into a floor. They have more pairs than one
/// thread evaluates.
fn heap() -> World {
    let skin = Material::elastic(1e5)
        .with_dissipation(0.3)
        .with_friction(0.4);
    let egg = Arc::new(Shape::new(shapes::ellipsoid([0.1, 0.11, 0.12], 1).unwrap()));
    let falling = |index: u32| {
        let cell = Vector3::from([index % 2, index / 2 % 2, index / 4].map(f64::from));
        let at = cell * 0.19 + vector![0.0, 0.0, 0.09];
        let name = format!("egg {index}");
        let egg = Body::dynamic(&name, Arc::clone(&egg), skin, Mass::Total(1.0)).unwrap();
        egg.with_pose(Pose::from_rotation_vector(&(at * 3.0), at))
            .with_angular_velocity(vector![2.0, -1.0, 0.5])
    };
    let floor = Shape::new(shapes::cylinder(1.0, 0.2, 12).unwrap());
    let floor = Body::fixed("floor", floor, skin).unwrap();
    let floor = floor.with_pose(Pose::from_translation(vector![0.0, 0.0, -0.1]));
    let world = World::new((0..12).map(falling).chain([floor]).collect()).unwrap();
    world.with_gravity(vector![0.0, 0.0, -9.81]).unwrap()
}

/// Returns the number of pairs of bodies that touch in the initial state.
fn touching_pairs(world: &World) -> usize {
    let (topology, count) = (
        world.topology(&world.initial_state()).unwrap(),
        world.bodies().len(),
    );
    let pairs = (0..count).flat_map(|i| (0..i).map(move |j| (i, j)));
    pairs.filter(|&(i, j)| topology.touches(i, j)).count()
}

fn numbers(state: &State) -> impl Iterator<Item = f64> {
    state.bodies.iter().flat_map(|body| {
        let pose = body.pose.rotation().iter().chain(body.pose.translation());
        let twist = body.twist.angular.iter().chain(&body.twist.linear);
        pose.chain(twist).copied().collect::<Vec<_>>()
    })
}

pub fn bytes(numbers: impl IntoIterator<Item = f64>) -> Vec<u8> {
    numbers.into_iter().flat_map(f64::to_le_bytes).collect()
}

/// Returns the bytes of all states of a rollout.
pub fn rollout_bytes(world: &World, plan: &Plan) -> Vec<u8> {
    let states = world.rollout(plan).take(plan.steps());
    bytes(states.flat_map(|state| numbers(&state.unwrap()).collect::<Vec<_>>()))
}

/// Returns the bytes of the final outcome of a rollout and of its derivatives.
pub fn jacobian_bytes(world: &World, plan: &Plan, by: &[Parameter], end: &impl Outcome) -> Vec<u8> {
    let outcome = Experiment::new(world, plan).jacobian(by, end).unwrap();
    assert!(outcome.jacobian.column(0).amax() > 0.0);
    bytes(outcome.value.iter().chain(outcome.jacobian.iter()).copied())
}

/// Returns the 64-bit FNV-1a hash, which never changes, unlike the hash of the standard library.
pub fn hash(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, &byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3)
    })
}

/// Asserts that each run gives the same bytes with any number of threads, and prints their hash.
fn assert_reproducible(label: &str, run: impl Fn() -> Vec<u8> + Sync) {
    let in_pool = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap().install(&run)
    };
    let expected = run();
    println!(
        "{label}: {:016x}, {} bytes",
        hash(&expected),
        expected.len()
    );
    for threads in THREADS {
        assert!(in_pool(threads) == expected, "{label}: {threads} threads");
    }
}

#[test]
fn a_rollout_with_friction_has_the_same_bits_in_every_run() {
    // At least 16 pairs are distributed over threads.
    assert!(touching_pairs(&heap()) > 16, "{}", touching_pairs(&heap()));
    for integrator in [Integrator::Leapfrog, Integrator::SymplecticEuler] {
        assert_reproducible(&format!("rollout, {integrator:?}"), || {
            let plan = Plan::new(TIME_STEP, STEPS).unwrap();
            rollout_bytes(&heap(), &plan.with_integrator(integrator))
        });
    }
}

#[test]
fn the_jacobian_of_a_rollout_with_friction_has_the_same_bits_in_every_run() {
    let by = [
        Parameter::initial_velocity("egg 7"),
        Parameter::friction("egg 0"),
        Parameter::dissipation("egg 0"),
        Parameter::Gravity,
    ];
    assert_reproducible("Jacobian", || {
        let world = heap();
        let end = FinalState::of_body(&world, "egg 4").unwrap();
        jacobian_bytes(&world, &Plan::new(TIME_STEP, STEPS / 4).unwrap(), &by, &end)
    });
}

#[test]
fn a_batch_has_the_same_bits_in_every_run() {
    assert_reproducible("batch", || {
        let world = heap();
        let starts = [0.0, 0.1, 0.2, 0.3, 0.4, 0.5].map(|speed| {
            let mut state = world.initial_state();
            state.bodies[7].twist.linear.x = speed;
            state
        });
        let batch = Batch::new(&Plan::new(TIME_STEP, STEPS).unwrap());
        let trajectories = batch.rollouts(&starting_from(&world, &starts));
        let last = trajectories
            .iter()
            .map(|result| result.as_ref().unwrap().last());
        bytes(last.flat_map(numbers))
    });
}

#[test]
fn recordings_and_tables_have_the_same_bytes_in_every_run() {
    for name in ["reproducible.glb", "reproducible.csv"] {
        assert_reproducible(name, || {
            let world = heap();
            let plan = Plan::new(TIME_STEP, STEPS).unwrap().recording_every(10);
            let trajectory = world.rollout(&plan).run().unwrap();
            let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
            match name {
                "reproducible.glb" => Recording::new(&world, &trajectory)
                    .slowed(10.0)
                    .write(&path),
                _ => write_trajectory(&path, &world, &trajectory),
            }
            .unwrap();
            std::fs::read(path).unwrap()
        });
    }
}
