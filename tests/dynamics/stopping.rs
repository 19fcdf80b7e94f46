//! Flags that end rollouts, experiments and batches.

use crate::scenes::{SKIN, ball, ball_shape, still_at};
use crate::support::starts::starting_from;
use crate::support::worlds::{IMPLICIT, plan_of};
use hydroelastic::dynamics::{
    Batch, Body, Force, ForceContext, Integrator, Plan, RolloutError, RolloutResult, StateGradient,
    World, WrenchAccumulator,
};
use hydroelastic::gradient::{Experiment, FinalPosition, GradientError, Parameter};
use hydroelastic::scalar::{Scalar, lift, real_part};
use nalgebra::Vector3;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

#[test]
fn a_flag_stops_rollouts_experiments_and_batches_before_their_next_step() {
    let world = World::new(vec![ball("ball")]).unwrap();
    let plan = Plan::new(1e-3, 10).unwrap();
    let flag = Arc::new(AtomicBool::new(false));
    let stopped = |recorded: RolloutResult| {
        let interrupted = recorded.unwrap_err();
        assert_eq!(interrupted.error, RolloutError::Stopped);
        interrupted.trajectory.states().len()
    };
    let rollout = || world.rollout(&plan).with_cancel_flag(Arc::clone(&flag));
    let mut begun = rollout();
    begun.advance().unwrap();
    flag.store(true, Ordering::Relaxed);
    let state = begun.state().clone();
    assert_eq!(begun.advance().unwrap_err(), RolloutError::Stopped);
    assert_eq!(format!("{:?}", begun.state()), format!("{state:?}"));
    let restarted = rollout().with_state(state).unwrap();
    assert_eq!(stopped(restarted.run()), 1);
    assert_eq!(stopped(begun.run()), 1);
    let experiment = Experiment::new(&world, &plan).with_cancel_flag(Arc::clone(&flag));
    assert_eq!(stopped(experiment.trajectory()), 1);
    let by = [Parameter::initial_velocity("ball")];
    let end = FinalPosition::of_body(&world, "ball").unwrap();
    assert_eq!(
        experiment.jacobian(&by, &end),
        Err(GradientError::Rollout(RolloutError::Stopped))
    );
    let batch = Batch::new(&plan).with_cancel_flag(Arc::clone(&flag));
    let states = vec![world.initial_state(); 3];
    for recorded in batch.rollouts(&starting_from(&world, &states)) {
        assert_eq!(stopped(recorded), 1);
    }
    flag.store(false, Ordering::Relaxed);
    assert_eq!(rollout().run().unwrap().states().len(), 11);
    assert!(batch.rollouts(&[world])[0].is_ok());
}

#[test]
fn a_flag_that_is_set_after_the_rollout_stops_the_sweep_back() {
    let world = World::new(vec![ball("ball")]).unwrap();
    let flag = Arc::new(AtomicBool::new(false));
    let experiment = Experiment::new(&world, &Plan::new(1e-3, 10).unwrap());
    let experiment = experiment.with_cancel_flag(Arc::clone(&flag));
    let vjp = experiment.vjp(&[Parameter::Gravity]).unwrap();
    flag.store(true, Ordering::Relaxed);
    let states = vjp.trajectory().states().iter();
    let by_states: Vec<_> = states.map(StateGradient::zero).collect();
    let result = vjp.clone().pull_back(&by_states);
    assert_eq!(result, Err(GradientError::Rollout(RolloutError::Stopped)));
    let with_own_flag = vjp.with_cancel_flag(Arc::default());
    assert!(with_own_flag.pull_back(&by_states).is_ok());
}

#[test]
fn a_flag_stops_a_batch_within_its_rollouts() {
    let world = World::new(vec![ball("ball")]).unwrap();
    let flag = Arc::new(AtomicBool::new(false));
    let setter = Arc::clone(&flag);
    // The path sets the flag in the middle of the first rollout.
    let path = move |time: f64| {
        if time > 4.5e-3 {
            setter.store(true, Ordering::Relaxed);
        }
        still_at(5.0)
    };
    let driven = Body::kinematic("driven", ball_shape(), SKIN, Arc::new(path)).unwrap();
    let bodies = [world.bodies()[0].clone(), driven];
    let worlds = vec![World::new(bodies.to_vec()).unwrap(); 4];
    let batch = Batch::new(&Plan::new(1e-3, 10).unwrap()).with_cancel_flag(flag);
    let lengths = batch.rollouts(&worlds).into_iter().map(|recorded| {
        let interrupted = recorded.unwrap_err();
        assert_eq!(interrupted.error, RolloutError::Stopped);
        interrupted.trajectory.states().len()
    });
    assert!(lengths.max().unwrap() < 11);
}

/// Number of calls of a path or a force. One of the calls may set a flag.
#[derive(Default)]
struct Calls {
    /// Whether calls are counted.
    is_armed: AtomicBool,
    count: AtomicUsize,
    flag: Arc<AtomicBool>,
    /// Count at which the flag is set; 0 means never.
    last: usize,
}

impl Calls {
    fn add(&self) {
        if self.is_armed.load(Ordering::Relaxed) {
            let count = self.count.fetch_add(1, Ordering::Relaxed) + 1;
            if count == self.last {
                self.flag.store(true, Ordering::Relaxed);
            }
        }
    }

    fn count(&self) -> usize {
        self.count.load(Ordering::Relaxed)
    }
}

/// Largest number of calls of a force after the flag was set, by the evaluation in progress.
const REST_OF_EVALUATION: usize = 2;

/// A force against the velocity that jumps at zero velocity. No velocity solves the step, no matter how short the substep is.
struct Reversing(Arc<Calls>);

impl Force for Reversing {
    fn add_to<T: Scalar>(&self, wrenches: &mut WrenchAccumulator<T>, now: &ForceContext<T>) {
        self.0.add();
        let sign = -real_part(now.states[0].twist.linear.x).signum();
        wrenches.apply_force_at_com(0, &Vector3::new(sign, 0.0, 0.0).map(lift));
    }
}

#[test]
fn a_flag_stops_an_implicit_step_in_progress() {
    let run = |last: usize, integrator: Integrator| {
        let calls = Arc::new(Calls {
            is_armed: AtomicBool::new(true),
            last,
            ..Calls::default()
        });
        let ball = ball("ball").with_velocity(Vector3::x() * 1e-4);
        let world = World::new(vec![ball]).unwrap();
        let world = world.with_forces(Reversing(Arc::clone(&calls))).unwrap();
        let plan = plan_of(integrator, 5e-3, 10);
        let rollout = world
            .rollout(&plan)
            .with_cancel_flag(Arc::clone(&calls.flag));
        (rollout.run().unwrap_err(), calls)
    };
    for integrator in IMPLICIT {
        let (interrupted, calls) = run(0, integrator);
        assert!(matches!(interrupted.error, RolloutError::NotSolved { .. }));
        let all = calls.count();
        for last in [1, 2, 5, all / 4, all / 2] {
            let (interrupted, calls) = run(last, integrator);
            assert_eq!(interrupted.error, RolloutError::Stopped);
            assert_eq!(interrupted.trajectory.states().len(), 1);
            let rest = calls.count() - last;
            assert!(rest <= REST_OF_EVALUATION && rest < all / 4, "{rest}");
        }
    }
}

/// Number of evaluations of a path in one step.
const CALLS_OF_A_STEP: usize = 4;

/// The tape stores 16 of 2,000 steps, so more than 100 steps are repeated before the first step is reversed.
#[test]
fn a_flag_stops_steps_that_the_sweep_back_repeats() {
    let calls = Arc::new(Calls {
        last: 1,
        ..Calls::default()
    });
    let counted = Arc::clone(&calls);
    let path = move |_: f64| {
        counted.add();
        still_at(5.0)
    };
    let driven = Body::kinematic("driven", ball_shape(), SKIN, Arc::new(path)).unwrap();
    let world = World::new(vec![ball("ball"), driven]).unwrap();
    let experiment = Experiment::new(&world, &Plan::new(1e-3, 2_000).unwrap());
    let experiment = experiment
        .with_memory(0)
        .with_cancel_flag(calls.flag.clone());
    let vjp = experiment.vjp(&[Parameter::Gravity]).unwrap();
    calls.is_armed.store(true, Ordering::Relaxed);
    let states = vjp.trajectory().states().iter();
    let by_states: Vec<_> = states.map(StateGradient::zero).collect();
    let result = vjp.pull_back(&by_states);
    assert_eq!(result, Err(GradientError::Rollout(RolloutError::Stopped)));
    assert!(calls.count() <= CALLS_OF_A_STEP, "{}", calls.count());
}
