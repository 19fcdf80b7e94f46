//! Threads change no bit: of one large contact, of a step with many contacts, of a batch, and of a batch of gradients. Without the feature
//! `parallel`, everything runs on one thread, and the tests hold as well.

use crate::starts::starting_from;
use hydroelastic::contact::{ContactBody, ContactPair, Shape, SurfaceLaw};
use hydroelastic::dynamics::{
    Batch, Body, Force, ForceContext, Integrator, Mass, Material, Plan, Progress, RolloutError,
    State, World, WorldError, WrenchAccumulator,
};
use hydroelastic::gradient::{Experiment, FinalPosition, FinalState, GradientError, Parameter};
use hydroelastic::mesh::{PressureField, shapes};
use hydroelastic::scalar::{Scalar, real_part};
use hydroelastic::spatial::{Pose, Twist};
use nalgebra::{Vector3, vector};
use std::collections::BTreeSet;
use std::ops::ControlFlow;
use std::slice;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

const THREADS: [usize; 4] = [1, 2, 3, 8];
const TIME_STEP: f64 = 5e-4;

/// Returns a body with its own name, of a material with friction.
fn falling(name: &str, shape: &Arc<Shape>, at: Vector3<f64>) -> Body {
    let skin = Material::elastic(1e5)
        .with_dissipation(0.3)
        .with_friction(0.4);
    let body = Body::dynamic(name, Arc::clone(shape), skin, Mass::Total(1.0)).unwrap();
    let pose = Pose::from_rotation_vector(&(at * 3.0), at);
    body.with_pose(pose)
        .with_angular_velocity(vector![2.0, -1.0, 0.5])
}

fn floor() -> Body {
    let floor = Shape::new(shapes::cuboid([2.0, 2.0, 0.2]).unwrap());
    let floor = Body::fixed("floor", floor, Material::elastic(1e6).with_friction(0.5)).unwrap();
    floor.with_pose(Pose::from_translation(vector![0.0, 0.0, -0.1]))
}

fn with_gravity(bodies: Vec<Body>) -> World {
    let world = World::new(bodies).unwrap();
    world.with_gravity(vector![0.0, 0.0, -9.81]).unwrap()
}

/// Returns eggs in three layers of nine, pressed into each other and into the floor.
fn heap() -> World {
    let egg = Arc::new(Shape::new(shapes::ellipsoid([0.1, 0.11, 0.12], 1).unwrap()));
    let position = |index: u32| {
        let cell = [index % 3, index / 3 % 3, index / 9].map(f64::from);
        Vector3::from(cell) * 0.19 + vector![0.0, 0.0, 0.09]
    };
    let eggs = (0..27).map(|index| falling(&format!("egg {index}"), &egg, position(index)));
    with_gravity(eggs.chain([floor()]).collect())
}

/// Returns a ball that falls on the floor.
fn drop() -> World {
    let ball = Arc::new(Shape::new(shapes::icosphere(0.1, 1).unwrap()));
    let ball = falling("ball", &ball, vector![0.0, 0.0, 0.11]);
    with_gravity(vec![ball, floor()])
}

/// Returns every bit of every number of every body.
fn bits(state: &State) -> Vec<u64> {
    let numbers = state.bodies.iter().flat_map(|body| {
        let pose = body.pose.rotation().iter().chain(body.pose.translation());
        let twist = body.twist.angular.iter().chain(&body.twist.linear);
        pose.chain(twist).copied()
    });
    numbers.map(f64::to_bits).collect()
}

/// Asserts that the bits are the same in thread pools of several sizes.
fn assert_same_for_any_number_of_threads(bits: impl Fn() -> Vec<u64> + Sync) {
    let expected = bits();
    assert!(!expected.is_empty());
    for threads in THREADS {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let actual = pool.build().unwrap().install(&bits);
        assert!(actual == expected, "{threads} threads");
    }
}

/// Returns a contact with waves of some hundred polygons, which are distributed over threads.
fn large_pair(ball: &Shape) -> ContactPair<'_> {
    let turned = Pose::from_rotation_vector(&vector![0.3, -0.5, 0.2], vector![0.9, 0.1, 0.2]);
    let pair = ContactPair::new(
        ContactBody::new(ball, turned, 1.0).unwrap(),
        ContactBody::new(ball, Pose::identity(), 2.0).unwrap(),
    );
    assert!(pair.work_count().polygons > 5_000);
    pair
}

/// At the center of rotation, the slip direction varies quickly. Parts of the surface separate too fast for pressure. These polygons are
/// integrated one by one, and the other polygons in SIMD lanes.
#[test]
fn a_large_contact_in_motion_has_the_same_bits_whatever_the_number_of_threads() {
    let ball = Shape::new(shapes::icosphere(1.0, 4).unwrap());
    let pair = large_pair(&ball);
    let law = SurfaceLaw::new(5.0, 0.4, 1e-3).unwrap();
    let turning = Twist {
        angular: vector![0.1, -0.2, 3.0],
        linear: vector![0.01, 0.02, -0.1],
    };
    let twists = [turning, Twist::zero()];
    let contact = || {
        let linearized = pair.moving(law, twists).linearized();
        let wrenches = [pair.moving(law, twists).wrench(), linearized.wrench];
        let jacobian = linearized.jacobian();
        let numbers = wrenches.map(|wrench| wrench.on_a.to_vector());
        let all = numbers.iter().flatten().chain(jacobian.iter());
        all.map(|number| number.to_bits()).collect()
    };
    assert_same_for_any_number_of_threads(contact);
}

#[test]
fn the_contact_of_a_large_pair_has_the_same_bits_whatever_the_number_of_threads() {
    let ball = Shape::new(shapes::icosphere(1.0, 4).unwrap());
    let pair = large_pair(&ball);
    let contact = || {
        let contact = pair.linearized();
        let areas = pair
            .surface()
            .polygons
            .into_iter()
            .map(|polygon| polygon.area);
        let entries = contact.jacobian();
        let numbers = contact.wrench.on_a.to_vector();
        let all = numbers.iter().chain(entries.iter()).copied().chain(areas);
        all.map(f64::to_bits).collect()
    };
    assert_same_for_any_number_of_threads(contact);
}

#[test]
fn a_mesh_has_the_same_field_and_search_trees_whatever_the_number_of_threads() {
    let ball = shapes::icosphere(1.0, 4).unwrap();
    let layered = PressureField::from_distance_up_to(ball.mesh(), 0.3).unwrap();
    // The mesh has enough vertices, half of them inside, to use several threads.
    assert!(layered.mesh().vertex_count() > 5_000);
    let contact = || {
        let field = PressureField::from_distance(layered.mesh()).unwrap();
        let numbers = (field.extents().iter().copied())
            .chain(field.tets().iter().map(|tet| tet.steepness))
            .collect::<Vec<f64>>();
        let shape = Shape::new(field);
        let turned = Pose::from_rotation_vector(&vector![0.3, -0.5, 0.2], vector![0.9, 0.1, 0.2]);
        let pair = ContactPair::new(
            ContactBody::new(&shape, turned, 1.0).unwrap(),
            ContactBody::new(&shape, Pose::identity(), 2.0).unwrap(),
        );
        let wrench = pair.wrench().on_a.to_vector();
        let all = numbers.iter().chain(&wrench).copied();
        all.map(f64::to_bits).collect()
    };
    assert_same_for_any_number_of_threads(contact);
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

#[test]
fn a_step_of_many_contacts_has_the_same_bits_whatever_the_number_of_threads() {
    let world = heap();
    // The number suffices to use several threads.
    assert!(touching_pairs(&world) > 40, "{}", touching_pairs(&world));
    let plan = Plan::new(TIME_STEP, 40).unwrap();
    let last = || {
        let mut rollout = world.rollout(&plan);
        bits(&rollout.nth(39).unwrap().unwrap())
    };
    assert_same_for_any_number_of_threads(last);
    // Within a batch, a rollout uses one thread.
    let batch = Batch::new(&plan);
    let alone = batch.rollouts(slice::from_ref(&world));
    assert!(bits(alone[0].as_ref().unwrap().last()) == last());
}

/// Returns initial states of the ball at `count` heights (m).
fn heights(world: &World, count: usize) -> Vec<State> {
    let start = |index: usize| {
        let mut state = world.initial_state();
        let height = vector![0.0, 0.0, 0.1 + 1e-3 * index as f64];
        state.bodies[0].pose = state.bodies[0].pose.with_translation(height);
        state
    };
    (0..count).map(start).collect()
}

#[test]
fn a_batch_has_the_trajectories_of_its_rollouts_one_by_one_in_their_order() {
    let world = drop();
    let starts = heights(&world, 20);
    let plan = Plan::new(TIME_STEP, 100).unwrap();
    let plan = plan
        .with_integrator(Integrator::SymplecticEuler)
        .recording_every(50);
    let one_by_one: Vec<u64> = (starts.iter())
        .flat_map(|start| {
            let rollout = world.rollout(&plan);
            let rollout = rollout.with_state(start.clone()).unwrap();
            let recorded = rollout.run().unwrap();
            recorded.states().iter().flat_map(bits).collect::<Vec<_>>()
        })
        .collect();
    let batch = Batch::new(&plan);
    let together = || {
        let trajectories = batch.rollouts(&starting_from(&world, &starts));
        let states = trajectories
            .iter()
            .flat_map(|t| t.as_ref().unwrap().states());
        states.flat_map(bits).collect()
    };
    assert!(together() == one_by_one);
    assert_same_for_any_number_of_threads(together);
}

#[test]
fn a_batch_of_worlds_has_the_trajectories_of_the_worlds() {
    let moduli = [0.0, 1e5, 2e5, 3e5];
    let worlds = moduli.map(|change| {
        let parameters = [Parameter::modulus("ball")];
        drop().perturbed(&parameters, &[change]).unwrap()
    });
    let plan = Plan::new(TIME_STEP, 60).unwrap();
    let trajectories = Batch::new(&plan).rollouts(&worlds);
    assert_eq!(trajectories.len(), worlds.len());
    for (world, trajectory) in worlds.iter().zip(trajectories) {
        let expected = world.rollout(&plan).run().unwrap();
        assert!(bits(trajectory.unwrap().last()) == bits(expected.last()));
    }
}

fn by() -> [Parameter; 2] {
    [
        Parameter::initial_velocity("ball"),
        Parameter::friction("ball"),
    ]
}

/// Returns changes of velocity and friction.
fn samples() -> Vec<[f64; 4]> {
    let sample = |i: u32| [0.1, -0.2, 0.05, 0.01].map(|x| x * f64::from(i));
    (0..12).map(sample).collect()
}

#[test]
fn values_and_jacobians_after_changes_have_the_same_bits_whatever_the_number_of_threads() {
    let (world, samples) = (drop(), samples());
    let outcome = FinalState::of_body(&world, "ball").unwrap();
    let batch = Batch::new(&Plan::new(TIME_STEP, 80).unwrap().recording_every(80));
    let read = || {
        let values = batch.map(&samples, |job, sample| {
            job.experiment(world.perturbed(&by(), sample)?)
                .value(&outcome)
        });
        let jacobians = batch.map(&samples, |job, sample| {
            job.experiment(world.perturbed(&by(), sample)?)
                .jacobian(&by(), &outcome)
        });
        let mut numbers = Vec::new();
        for (value, jacobian) in values.into_iter().zip(jacobians) {
            let (value, jacobian) = (value.unwrap(), jacobian.unwrap());
            assert_eq!(value, jacobian.value.as_slice());
            numbers.extend(value);
            numbers.extend(jacobian.jacobian.iter());
        }
        numbers.into_iter().map(f64::to_bits).collect()
    };
    assert_same_for_any_number_of_threads(read);
}

#[test]
fn jacobians_of_worlds_are_those_of_each_experiment() {
    let plan = Plan::new(TIME_STEP, 80).unwrap();
    let outcome = FinalState::of_body(&drop(), "ball").unwrap();
    let samples = samples();
    let changed = samples.iter().map(|sample| drop().perturbed(&by(), sample));
    let worlds: Vec<_> = changed.map(Result::unwrap).collect();
    let gradients = Batch::new(&plan).map(&worlds, |job, world| {
        job.experiment(world).jacobian(&by(), &outcome)
    });
    let steps = Arc::new(AtomicUsize::new(0));
    for (world, actual) in worlds.iter().zip(gradients) {
        let experiment =
            Experiment::new(world.clone(), &plan).with_step_counter(Arc::clone(&steps));
        let expected = experiment.jacobian(&by(), &outcome);
        assert_eq!(actual.unwrap(), expected.unwrap());
    }
    assert_eq!(steps.load(Ordering::Relaxed), 80 * worlds.len());
}

#[test]
fn a_sample_that_makes_no_world_is_an_error_among_the_others() {
    let world = drop();
    let outcome = FinalPosition::of_body(&world, "ball").unwrap();
    let batch = Batch::new(&Plan::new(TIME_STEP, 10).unwrap());
    let samples = [vec![0.0], vec![-1.0], vec![0.0, 0.0], vec![0.1]];
    let values = batch.map(&samples, |job, sample| {
        job.experiment(world.perturbed(&[Parameter::friction("ball")], sample)?)
            .value(&outcome)
    });
    assert!(values[0].is_ok() && values[3].is_ok());
    let range = values[1].as_ref().unwrap_err();
    assert!(matches!(
        range,
        GradientError::World(WorldError::Material { .. })
    ));
    let (found, expected) = (2, 1);
    let count = GradientError::NumberCount { found, expected };
    assert_eq!(values[2].as_ref().unwrap_err(), &count);
    let losses = batch.map(&[[0.0]], |job, sample| {
        job.experiment(world.perturbed(&by()[1..], sample)?)
            .gradient(&by()[1..], &outcome)
    });
    let count = 3;
    assert_eq!(losses[0], Err(GradientError::NotALoss { count }));
}

#[test]
fn progress_counts_every_rollout_once_and_ends_at_the_total() {
    let world = drop();
    let counts = Arc::new(Mutex::new(BTreeSet::new()));
    let noted = Arc::clone(&counts);
    let note = move |progress: Progress| {
        assert_eq!(progress.total, 20);
        assert!(noted.lock().unwrap().insert(progress.finished));
        ControlFlow::Continue(())
    };
    let batch = Batch::new(&Plan::new(TIME_STEP, 10).unwrap()).with_progress(note);
    batch.rollouts(&starting_from(&world, &heights(&world, 20)));
    assert!(counts.lock().unwrap().iter().copied().eq(1..=20));
}

/// A force of zero that panics if the ball enters the floor.
struct Touchy;

/// Height (m) of the ball's center below which [`Touchy`] panics.
const LOWEST: f64 = 0.1045;

impl Force for Touchy {
    fn add_to<T: Scalar>(&self, _: &mut WrenchAccumulator<T>, now: &ForceContext<T>) {
        let ball = now.index_of("ball").unwrap();
        let height = real_part(now.states[ball].position().z);
        assert!(height > LOWEST, "ball is at {height:.2} m");
    }
}

#[test]
fn a_panic_in_one_rollout_is_its_error_and_the_others_go_on() {
    let world = drop().with_forces(Touchy).unwrap();
    let starts = heights(&drop(), 12);
    let batch = Batch::new(&Plan::new(TIME_STEP, 50).unwrap());
    let results = batch.rollouts(&starting_from(&world, &starts));
    for (index, result) in results.into_iter().enumerate() {
        // In 25 ms the ball falls 3.1 mm. Its initial height is 100 mm and increases by a millimeter each time.
        if index > 7 {
            assert_eq!(result.unwrap().states().len(), 51);
            continue;
        }
        let interrupted = result.unwrap_err();
        let message = "ball is at 0.10 m".to_owned();
        assert_eq!(interrupted.error, RolloutError::Panicked { message });
        let reached = interrupted.trajectory.states().len();
        assert!((1..=50).contains(&reached), "{reached}");
        assert_eq!(reached == 1, index < 5);
    }
    let outcome = FinalPosition::of_body(&world, "ball").unwrap();
    let by = [Parameter::initial_position("ball")];
    let samples = [[0.0, 0.0, 0.1], [0.0, 0.0, -0.01]];
    let values = batch.map(&samples, |job, sample| {
        job.experiment(world.perturbed(&by, sample)?)
            .value(&outcome)
    });
    assert!(values[0].is_ok());
    let error = values[1].as_ref().unwrap_err();
    assert!(matches!(
        error,
        GradientError::Rollout(RolloutError::Panicked { .. })
    ));
    let failed: Vec<Result<(), RolloutError>> = batch.map(&[()], |_, ()| panic!("no job"));
    let message = failed[0].as_ref().unwrap_err().to_string();
    assert!(message.contains("function of a batch"), "{message}");
    assert!(message.ends_with("panicked: no job"), "{message}");
}

#[test]
fn a_start_of_another_world_is_refused() {
    let error = Plan::new(0.0, 10).unwrap_err();
    assert!(matches!(error, WorldError::Setting { .. }));
    let (world, mut short_state) = (drop(), heap().initial_state());
    short_state.bodies.truncate(5);
    let error = world.with_initial_state(&short_state);
    let (found, expected) = (5, 2);
    assert_eq!(
        error.unwrap_err(),
        WorldError::StateSize { found, expected }
    );
}
