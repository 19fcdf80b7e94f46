//! Results of failed runs: a panic in a user-defined function, or a blow-up. `broken_writes.rs` tests the resulting files.

use crate::scenes::bits;
use crate::support::starts::starting_from;
use crate::support::worlds::{
    EXPLICIT, cuboid, dynamic, falling, fixed, icosphere, plan_of, sliding_at,
};
use hydroelastic::contact::Shape;
use hydroelastic::dynamics::{
    Batch, Body, BodyState, Force, ForceContext, Material, Plan, Progress, RolloutError, State,
    Trajectory, World, WrenchAccumulator,
};
use hydroelastic::gradient::{Experiment, FinalPosition, GradientError, Outcome, Parameter};
use hydroelastic::scalar::Scalar;
use hydroelastic::spatial::Pose;
use nalgebra::{Vector3, vector};
use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

const TIME_STEP: f64 = 1e-3;

/// Returns a ball that falls on a floor and hits it after about 45 steps.
fn world_on(floor: Body, skin: Material) -> World {
    let ball = icosphere(0.1, 1);
    let ball = dynamic("ball", ball, skin, 1.0);
    let ball = ball.with_pose(Pose::from_translation(vector![0.0, 0.0, 0.11]));
    falling(vec![ball, floor])
}

fn slab() -> Arc<Shape> {
    Arc::new(cuboid([1.0, 1.0, 0.2]))
}

const DOWN: Vector3<f64> = vector![0.0, 0.0, -0.1];

fn world(skin: Material) -> World {
    let floor = fixed("floor", slab(), skin);
    world_on(floor.with_pose(Pose::from_translation(DOWN)), skin)
}

fn soft_world() -> World {
    world(Material::elastic(1e5).with_friction(0.4))
}

fn all_bits(trajectory: &Trajectory) -> Vec<Vec<u64>> {
    trajectory.states().iter().map(bits).collect()
}

// Panics.

/// A force of zero that panics at one of its evaluations.
struct Fragile {
    /// Number of evaluations so far.
    asked: AtomicUsize,
    /// Number of the evaluation that panics, from 1.
    last: usize,
}

impl Fragile {
    fn at(last: usize) -> Self {
        let asked = AtomicUsize::new(0);
        Self { asked, last }
    }
}

impl Force for Fragile {
    fn add_to<T: Scalar>(&self, _: &mut WrenchAccumulator<T>, now: &ForceContext<T>) {
        let asked = self.asked.fetch_add(1, Ordering::Relaxed) + 1;
        assert!(asked != self.last, "no force for {}", now.bodies[0].name());
    }
}

fn panicked(message: &str) -> RolloutError {
    let message = message.to_owned();
    RolloutError::Panicked { message }
}

#[test]
fn a_panic_in_a_force_is_an_error_with_the_trajectory_up_to_there() {
    for integrator in EXPLICIT {
        let plan = plan_of(integrator, TIME_STEP, 80);
        let whole = all_bits(&soft_world().rollout(&plan).run().unwrap());
        for last in [1, 2, 50, 80] {
            // The force is evaluated once per step.
            let world = soft_world().with_forces(Fragile::at(last)).unwrap();
            let interrupted = world.rollout(&plan).run().unwrap_err();
            assert_eq!(interrupted.error, panicked("no force for ball"));
            assert_eq!(all_bits(&interrupted.trajectory), whole[..last]);
        }
    }
}

/// Returns a floor that sinks along a path that ends within the fifty-first step.
fn sinking_world() -> World {
    let path = |time: f64| {
        assert!(time < 50.25 * TIME_STEP, "the path ends at {time:.4} s");
        BodyState {
            pose: Pose::from_translation(DOWN * (1.0 + time)),
            twist: sliding_at(DOWN),
        }
    };
    let skin = Material::elastic(1e5);
    let floor = Body::kinematic("floor", slab(), skin, Arc::new(path)).unwrap();
    world_on(floor, skin)
}

#[test]
fn a_panic_in_a_path_is_an_error_with_the_trajectory_up_to_there() {
    let world = sinking_world();
    let plan = Plan::new(TIME_STEP, 80).unwrap();
    let interrupted = world.rollout(&plan).run().unwrap_err();
    assert_eq!(interrupted.error, panicked("the path ends at 0.0505 s"));
    assert_eq!(interrupted.trajectory.states().len(), 1 + 50);
    let batch = Batch::new(&plan.recording_every(10));
    let results = batch.rollouts(&[sinking_world(), soft_world()]);
    let interrupted = results[0].as_ref().unwrap_err();
    assert_eq!(interrupted.trajectory.states().len(), 1 + 5);
    assert_eq!(results[1].as_ref().unwrap().states().len(), 1 + 8);
}

#[test]
fn after_a_panic_a_rollout_has_its_last_state_and_can_take_the_step_again() {
    let plan = Plan::new(TIME_STEP, 80).unwrap();
    let expected = soft_world().rollout(&plan);
    let expected: Vec<State> = expected.take(80).map(Result::unwrap).collect();
    for last in [2, 50] {
        let world = soft_world().with_forces(Fragile::at(last)).unwrap();
        let mut rollout = world.rollout(&plan);
        for state in &expected[..last - 1] {
            assert_eq!(bits(rollout.advance().unwrap()), bits(state));
        }
        let step = AssertUnwindSafe(|| rollout.next());
        assert!(catch_unwind(step).is_err());
        assert_eq!(bits(rollout.state()), bits(&expected[last - 2]));
        for state in &expected[last - 1..] {
            assert_eq!(bits(&rollout.next().unwrap().unwrap()), bits(state));
        }
    }
}

/// An outcome that panics.
struct Flawed;

impl Outcome for Flawed {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        vec![trajectory.states()[1_000].bodies[0].position().z]
    }
}

fn by() -> [Parameter; 1] {
    [Parameter::initial_position("ball")]
}

#[test]
fn a_panic_in_an_experiment_is_its_error_and_the_states_before_are_to_be_had() {
    let world = || soft_world().with_forces(Fragile::at(50)).unwrap();
    let expected = GradientError::Rollout(panicked("no force for ball"));
    let (first, second, third, fourth) = (world(), world(), world(), world());
    let outcome = FinalPosition::of_body(&first, "ball").unwrap();
    let experiment = |world| Experiment::new(world, &Plan::new(TIME_STEP, 80).unwrap());
    assert_eq!(experiment(&first).value(&outcome), Err(expected.clone()));
    let jacobian = experiment(&second).jacobian(&by(), &outcome);
    assert_eq!(jacobian.unwrap_err(), expected);
    let value = experiment(&third).value_perturbed(&by(), &[0.0; 3], &outcome);
    assert_eq!(value, Err(expected));
    let interrupted = experiment(&fourth).trajectory().unwrap_err();
    assert_eq!(interrupted.trajectory.states().len(), 50);
    let plain = soft_world();
    let experiment = Experiment::new(&plain, &Plan::new(TIME_STEP, 80).unwrap());
    let of_value = experiment.value(&Flawed).unwrap_err().to_string();
    let of_jacobian = experiment.jacobian(&by(), &Flawed).unwrap_err().to_string();
    for message in [of_value, of_jacobian] {
        assert!(message.contains("index out of bounds"), "{message}");
    }
}

#[test]
fn a_panic_in_progress_leaves_all_results() {
    let world = soft_world();
    let starts = vec![world.initial_state(); 20];
    let told = Arc::new(AtomicUsize::new(0));
    let count = |batch: Batch| {
        let results = batch.rollouts(&starting_from(&world, &starts));
        let whole = results.iter().filter(|result| result.is_ok());
        whole.count()
    };
    let batch = || Batch::new(&Plan::new(TIME_STEP, 10).unwrap());
    let telling = Arc::clone(&told);
    let panicking = batch().with_progress(move |progress: Progress| {
        telling.fetch_add(1, Ordering::Relaxed);
        assert!(progress.finished < 5, "enough");
        ControlFlow::Continue(())
    });
    assert_eq!(count(panicking), starts.len());
    // With several threads, several rollouts may report progress at the same time.
    let told = told.load(Ordering::Relaxed);
    assert!((1..20).contains(&told), "{told}");
    // The same holds for samples of a gradient.
    let outcome = FinalPosition::of_body(&world, "ball").unwrap();
    let panicking = batch().with_progress(|_| panic!("at once"));
    let values = panicking.map(&[[0.0; 3]; 5], |job, sample| {
        job.experiment(world.perturbed(&by(), sample)?)
            .value(&outcome)
    });
    assert_eq!(values.iter().filter(|value| value.is_ok()).count(), 5);
}

// Blow-ups.

#[test]
fn an_experiment_that_blows_up_gives_the_states_before() {
    let stiff = world(Material::elastic(1e150).with_dissipation(1e150));
    let plan = Plan::new(TIME_STEP, 1_000).unwrap();
    let experiment = Experiment::new(&stiff, &plan.without_stability_check());
    let interrupted = experiment.trajectory().unwrap_err();
    let states = interrupted.trajectory.states();
    let finite = |state: &State| state.bodies.iter().all(BodyState::is_finite);
    assert!(states.len() > 40 && states.iter().all(finite));
    let RolloutError::NotFinite { step, body, .. } = &interrupted.error else {
        panic!("{}", interrupted.error)
    };
    assert_eq!((*step, body.as_str()), (states.len(), "ball"));
    let outcome = FinalPosition::of_body(&stiff, "ball").unwrap();
    let expected = GradientError::Rollout(interrupted.error);
    assert_eq!(experiment.value(&outcome), Err(expected));
}

#[test]
fn a_batch_that_is_ended_keeps_what_was_finished_and_begins_no_more() {
    const COUNT: usize = 64;
    const ENOUGH: usize = 5;
    let world = world(Material::elastic(1e5));
    let states = vec![world.initial_state(); COUNT];
    let batch = Batch::new(&Plan::new(TIME_STEP, 100).unwrap()).with_progress(|progress| {
        if progress.finished < ENOUGH {
            return ControlFlow::Continue(());
        }
        ControlFlow::Break(())
    });
    let is_stopped = |error: &RolloutError| matches!(error, RolloutError::Stopped);
    let results = batch.rollouts(&starting_from(&world, &states));
    let (ended, stopped): (Vec<_>, Vec<_>) = results.into_iter().partition(Result::is_ok);
    // Rollouts that ran in parallel with the fifth continue to their end.
    let threads = std::thread::available_parallelism().unwrap().get();
    assert!((ENOUGH..ENOUGH + threads).contains(&ended.len()));
    assert!(
        ended
            .into_iter()
            .all(|result| result.unwrap().states().len() == 101)
    );
    for interrupted in stopped.into_iter().map(Result::unwrap_err) {
        assert!(is_stopped(&interrupted.error));
        assert_eq!(interrupted.trajectory.states().len(), 1);
    }
    let end = FinalPosition::of_body(&world, "ball").unwrap();
    let by = [Parameter::initial_velocity("ball")];
    let values = batch.map(&[[0.0; 3]; COUNT], |job, sample| {
        job.experiment(world.perturbed(&by, sample)?).value(&end)
    });
    let errors = values.into_iter().filter_map(Result::err);
    let count =
        errors.filter(|error| matches!(error, GradientError::Rollout(error) if is_stopped(error)));
    assert!(count.count() > COUNT - ENOUGH - threads);
}

#[test]
fn a_single_step_names_step_time_and_body_of_what_went_wrong() {
    let world = world(Material::elastic(1e5));
    let plan = Plan::new(TIME_STEP, 1).unwrap();
    let mut state = world.initial_state();
    state.bodies.pop();
    assert!(matches!(
        world.step(&state, &plan),
        Err(RolloutError::State(_))
    ));
    let mut state = world.initial_state();
    state.bodies[0].twist.linear.x = f64::MAX;
    let fast = world
        .step(&state, &Plan::new(10.0, 1).unwrap())
        .unwrap_err();
    assert!(matches!(fast, RolloutError::NotFinite { step: 1, body, .. } if body == "ball"));
}
