//! An iterative linear-quadratic regulator over the intervals of a control.

use hydroelastic::dynamics::{Control, Plan, State, World};
use hydroelastic::gradient::{Experiment, Parameter};
use hydroelastic::spatial::Wrench;
use nalgebra::{DMatrix, DVector, Vector3, Vector6};
use std::error::Error;

/// The numbers of a wrench that may be pushed with: torque about the vertical, force along x and y.
const PUSHES: [usize; 3] = [2, 3, 4];
/// The local coordinates that matter in the end, and how much: turn about the vertical (1/rad²), place (1/m²), spin about
/// the vertical (s²/rad²) and velocity (s²/m²).
const AIMS: [(usize, f64); 6] = [(2, 2e3), (3, 2e4), (4, 2e4), (8, 50.0), (9, 2e3), (10, 2e3)];
/// What pushes cost: a torque (1/(N m)²), forces (1/N²).
const EFFORTS: [f64; 3] = [1e-2, 1e-4, 1e-4];
/// Shares of an improvement that are tried, and costs of changes of pushes, as multiples of their efforts.
const SHARES: [f64; 4] = [1.0, 0.5, 0.2, 0.05];
const DAMPINGS: [f64; 4] = [0.0, 10.0, 100.0, 1000.0];
/// An improvement by less than this part of the cost is none.
const ENOUGH: f64 = 1e-6;

/// What the state at the end of the last interval is to be, and the plan of an interval.
pub struct Regulator {
    pub goal: State,
    pub plan: Plan,
}

/// Pushes and what they lead to.
pub struct Iteration {
    /// The world with its control.
    pub world: World,
    /// The states at the beginning of each interval, and at the end.
    pub states: Vec<State>,
    pub cost: f64,
}

/// How the pushes of an interval follow from how far the state is from the one expected.
struct Feedback {
    change: Vector3<f64>,
    gain: DMatrix<f64>,
}

/// A state by the one before and by pushes: A and B.
type Motion = [DMatrix<f64>; 2];

type Found<T> = Result<T, Box<dyn Error>>;

impl Regulator {
    /// The pushes that a world has.
    pub fn begun(&self, world: &World) -> Found<Iteration> {
        let pushes = pushes(world);
        let nothing = |_: usize, _: &State| Ok(Vector3::zeros());
        self.applied(world, &pushes, nothing)
    }

    /// Better ones, unless there are none.
    pub fn improved(&self, last: &Iteration) -> Found<Option<Iteration>> {
        let (motions, old) = (self.linearised(last)?, pushes(&last.world));
        for damping in DAMPINGS {
            let feedback = self.feedback(last, &motions, damping)?;
            for share in SHARES {
                let change = |interval: usize, state: &State| {
                    let expected = &last.states[interval];
                    let away = last.world.displacement(expected, state)?;
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

    /// Interval by interval, with changes that depend on the state there.
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
            let rollout = world
                .rollout(&self.last_only())
                .starting_from(state.clone())?;
            states.push(rollout.recorded()?.last().clone());
        }
        let effort: f64 = pushes.iter().map(|push| effort(push).dot(push) / 2.0).sum();
        let away = world.displacement(&self.goal, &states[old.len()])?;
        let cost = effort + (aim(&away).dot(&away)) / 2.0;
        Ok(Iteration {
            world,
            states,
            cost,
        })
    }

    /// The optimal feedback for the motion linearised about an iteration: the Riccati recursion, from the end.
    fn feedback(&self, last: &Iteration, motions: &[Motion], damping: f64) -> Found<Vec<Feedback>> {
        let count = last.states.len() - 1;
        let away = last.world.displacement(&self.goal, &last.states[count])?;
        let (mut slope, mut curvature) = (aim(&away), aims(away.len()));
        let efforts = DMatrix::from_diagonal(&DVector::from_row_slice(&EFFORTS));
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

    /// The state after each interval by that before it and by its pushes.
    fn linearised(&self, last: &Iteration) -> Found<Vec<Motion>> {
        let mut motions = Vec::new();
        for interval in 0..last.states.len() - 1 {
            let world = last.world.clone().starting_from(&last.states[interval])?;
            let control = Parameter::Control(last.world.controls()[0].body().into(), interval);
            let found = Experiment::new(&world, &self.last_only()).linearised(&[control])?;
            let by_pushes = found.by_parameters.select_columns(&PUSHES);
            motions.push([found.by_state, by_pushes]);
        }
        Ok(motions)
    }

    fn last_only(&self) -> Plan {
        self.plan.recording_every(self.plan.steps())
    }
}

/// The pushes of each interval.
fn pushes(world: &World) -> Vec<Vector3<f64>> {
    let wrenches = world.controls()[0].wrenches().iter();
    let push = |wrench: &Wrench| Vector3::from(PUSHES.map(|number| wrench.to_vector()[number]));
    wrenches.map(push).collect()
}

fn with_pushes(world: World, pushes: &[Vector3<f64>]) -> Found<World> {
    let wrench = |push: &Vector3<f64>| {
        let mut numbers = Vector6::zeros();
        PUSHES
            .into_iter()
            .zip(push)
            .for_each(|(place, number)| numbers[place] = *number);
        Wrench::from_vector(&numbers)
    };
    let control = &world.controls()[0];
    let wrenches = pushes.iter().map(wrench).collect();
    let control = Control::new(control.body(), control.interval(), wrenches)?;
    Ok(world.with_control(control)?)
}

/// The slope of what pushes cost.
fn effort(push: &Vector3<f64>) -> DVector<f64> {
    DVector::from_iterator(3, push.iter().zip(EFFORTS).map(|(push, cost)| push * cost))
}

/// The slope of what it costs to be away from the goal.
fn aim(away: &DVector<f64>) -> DVector<f64> {
    aims(away.len()) * away
}

fn aims(size: usize) -> DMatrix<f64> {
    let mut aims = DMatrix::zeros(size, size);
    for (place, weight) in AIMS {
        aims[(place, place)] = weight;
    }
    aims
}
