//! An iterative linear-quadratic regulator over the intervals of a control. Each iteration linearizes the block's motion over every
//! interval, and improves the pushes by the optimal feedback of the linearized motion.

use crate::scene::{
    BY_ANGLE, BY_PLACE, BY_SPIN, BY_VELOCITY, Found, NEAR, PUSHES, Pushed, STEPS, Scene, TIME_STEP,
    efforts, wrench_numbers,
};
use hydroelastic::dynamics::{Control, Plan, State, World};
use hydroelastic::gradient::{Experiment, Parameter};
use hydroelastic::spatial::Wrench;
use indicatif::ProgressBar;
use nalgebra::{DMatrix, DVector, Vector3};

/// Number of intervals of the control.
const INTERVALS: usize = 20;
const STEPS_AN_INTERVAL: usize = STEPS / INTERVALS;
/// Largest number of iterations.
const ITERATIONS: usize = 40;
/// The final tangent-space coordinates with a cost, and their costs: rotation about the vertical, position, angular velocity about the vertical and
/// velocity.
const AIMS: [(usize, f64); 6] = [
    (2, BY_ANGLE),
    (3, BY_PLACE),
    (4, BY_PLACE),
    (8, BY_SPIN),
    (9, BY_VELOCITY),
    (10, BY_VELOCITY),
];
/// Fractions of an improvement, in the order of trial.
const SHARES: [f64; 4] = [1.0, 0.5, 0.2, 0.05];
/// Additional costs of changes of pushes, as multiples of the efforts, in the order of trial.
const DAMPINGS: [f64; 4] = [0.0, 10.0, 100.0, 1000.0];
/// Smallest relative decrease of the cost that counts as an improvement.
const ENOUGH: f64 = 1e-6;

/// Goal state at the end of the last interval, and the plan of an interval.
struct Regulator {
    goal: State,
    plan: Plan,
}

/// Pushes and the resulting states.
struct Iteration {
    /// The world with its control.
    world: World,
    /// States at the beginning of each interval, and the final state.
    states: Vec<State>,
    cost: f64,
}

/// Change of the pushes of an interval, with a gain on the difference between the actual and the expected state.
struct Feedback {
    change: Vector3<f64>,
    gain: DMatrix<f64>,
}

/// Derivatives of the state after an interval with respect to the state before the interval and to the pushes: A and B.
type Motion = [DMatrix<f64>; 2];

/// Returns the pushes found by the regulator. Iterates from zero pushes until the block is at the goal.
pub fn pushed(scene: &Scene) -> Found<Pushed> {
    let regulator = Regulator {
        goal: scene.goal.clone(),
        plan: Plan::new(TIME_STEP, STEPS_AN_INTERVAL)?,
    };
    let bar = ProgressBar::new(ITERATIONS as u64);
    let mut last = regulator.begun(&scene.with_intervals(INTERVALS)?)?;
    let mut costs = vec![last.cost];
    loop {
        let missed = scene.missed(&last.states[INTERVALS])?;
        if missed.iter().zip(NEAR).all(|(missed, near)| *missed < near) {
            break;
        }
        assert!(costs.len() <= ITERATIONS, "{missed:?} from the goal");
        let better = regulator.improved(&last)?;
        last = better.ok_or("no pushes are better")?;
        costs.push(last.cost);
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(Pushed {
        world: last.world.with_initial_state(&last.states[0])?,
        costs,
    })
}

impl Regulator {
    /// Returns the iteration with the pushes of a world.
    fn begun(&self, world: &World) -> Found<Iteration> {
        let pushes = pushes(world);
        let nothing = |_: usize, _: &State| Ok(Vector3::zeros());
        self.applied(world, &pushes, nothing)
    }

    /// Returns an iteration with a lower cost, or `None` if no trial has one.
    fn improved(&self, last: &Iteration) -> Found<Option<Iteration>> {
        let (motions, old) = (self.linearized(last)?, pushes(&last.world));
        for damping in DAMPINGS {
            let feedback = self.feedback(last, &motions, damping)?;
            for share in SHARES {
                let change = |interval: usize, state: &State| {
                    let expected = &last.states[interval];
                    let away = last.world.difference(expected, state)?;
                    let Feedback { change, gain } = &feedback[interval];
                    Ok(change * share + gain * away)
                };
                let next = self.applied(&last.world, &old, change)?;
                if next.cost < last.cost * (1.0 - ENOUGH) {
                    return Ok(Some(next));
                }
            }
        }
        Ok(None)
    }

    /// Returns the iteration with the old pushes plus changes that depend on the state at each interval.
    fn applied(
        &self,
        world: &World,
        old: &[Vector3<f64>],
        change: impl Fn(usize, &State) -> Found<Vector3<f64>>,
    ) -> Found<Iteration> {
        let (mut pushes, mut states) = (old.to_vec(), vec![world.initial_state()]);
        let mut world = world.clone();
        for interval in 0..old.len() {
            let state = &states[interval];
            pushes[interval] += change(interval, state)?;
            world = with_pushes(world, &pushes)?;
            let rollout = world.rollout(&self.last_only()).with_state(state.clone())?;
            states.push(rollout.run()?.last().clone());
        }
        let effort: f64 = pushes.iter().map(|push| effort(push).dot(push) / 2.0).sum();
        let away = world.difference(&self.goal, &states[old.len()])?;
        let cost = effort + (aim(&away).dot(&away)) / 2.0;
        Ok(Iteration {
            world,
            states,
            cost,
        })
    }

    /// Returns the optimal feedback for the motion linearized about an iteration, by the backward Riccati recursion.
    fn feedback(&self, last: &Iteration, motions: &[Motion], damping: f64) -> Found<Vec<Feedback>> {
        let count = last.states.len() - 1;
        let away = last.world.difference(&self.goal, &last.states[count])?;
        let (mut slope, mut curvature) = (aim(&away), aims(away.len()));
        let efforts = DMatrix::from_diagonal(&efforts_of_interval());
        let mut feedback = Vec::new();
        for (push, [a, b]) in pushes(&last.world).iter().zip(motions).rev() {
            let by_push = effort(push) + b.tr_mul(&slope);
            let by_pushes = &efforts * (1.0 + damping) + b.tr_mul(&(&curvature * b));
            let mixed = b.tr_mul(&(&curvature * a));
            let solver = by_pushes
                .cholesky()
                .ok_or("the cost of pushes has no minimum")?;
            let (change, gain) = (-solver.solve(&by_push), -solver.solve(&mixed));
            slope = a.tr_mul(&slope) + mixed.tr_mul(&change);
            curvature = a.tr_mul(&(&curvature * a)) + mixed.tr_mul(&gain);
            let change = Vector3::from_column_slice(change.as_slice());
            feedback.push(Feedback { change, gain });
        }
        feedback.reverse();
        Ok(feedback)
    }

    /// Returns the derivatives of the state after each interval with respect to the state before it and to its pushes.
    fn linearized(&self, last: &Iteration) -> Found<Vec<Motion>> {
        let mut motions = Vec::new();
        for interval in 0..last.states.len() - 1 {
            let world = last
                .world
                .clone()
                .with_initial_state(&last.states[interval])?;
            let control = Parameter::Control(last.world.controls()[0].body().into(), interval);
            let found = Experiment::new(&world, &self.last_only()).linearize(&[control])?;
            let by_pushes = found.by_parameters.select_columns(&PUSHES);
            motions.push([found.by_state, by_pushes]);
        }
        Ok(motions)
    }

    /// Returns the plan of an interval that records only the last state.
    fn last_only(&self) -> Plan {
        self.plan.recording_every(self.plan.steps())
    }
}

/// Returns the pushes of each interval.
fn pushes(world: &World) -> Vec<Vector3<f64>> {
    let wrenches = world.controls()[0].wrenches().iter();
    let push = |wrench: &Wrench| Vector3::from(PUSHES.map(|number| wrench.to_vector()[number]));
    wrenches.map(push).collect()
}

/// Returns the world with these pushes, one for each interval of its control.
fn with_pushes(world: World, pushes: &[Vector3<f64>]) -> Found<World> {
    let wrench = |push: &Vector3<f64>| Wrench::from_vector(&wrench_numbers(push));
    let control = &world.controls()[0];
    let wrenches = pushes.iter().map(wrench).collect();
    let control = Control::new(control.body(), control.interval(), wrenches)?;
    Ok(world.with_control(control)?)
}

/// Returns the derivative of the cost of pushes.
fn effort(push: &Vector3<f64>) -> DVector<f64> {
    efforts_of_interval().component_mul(&DVector::from_column_slice(push.as_slice()))
}

/// Returns the costs of pushes in an interval, as multiples of half their squares.
fn efforts_of_interval() -> DVector<f64> {
    let efforts = efforts(TIME_STEP * STEPS_AN_INTERVAL as f64);
    DVector::from_column_slice(efforts.as_slice())
}

/// Returns the derivative of the cost of the distance from the goal.
fn aim(away: &DVector<f64>) -> DVector<f64> {
    aims(away.len()) * away
}

/// Returns the diagonal matrix of the quadratic cost of the distance from the goal.
fn aims(size: usize) -> DMatrix<f64> {
    let mut aims = DMatrix::zeros(size, size);
    for (place, weight) in AIMS {
        aims[(place, place)] = weight;
    }
    aims
}
