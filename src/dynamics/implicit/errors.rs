//! The errors that decide whether a substep is short enough.
//!
//! The *local error* is the difference from an embedded formula of lower order, taken through the last stage. The *error of
//! derivatives* is that of the derivative along the motion: the time derivative of the state obeys the same linearized equations
//! as every other sensitivity, and it is known at both ends of a substep as velocities and accelerations. The stages carry the
//! rates at the start to the end, and the difference from the rates there estimates the error of all derivatives.

use super::advance::IslandSolver;
use super::scheme::{ErrorEstimate, Stage};
use super::solved_stage::{BodyChange, Change, ChangedBodies, RatesInTime, SolvedStage};
use super::stage::{StageStart, Stages};
use crate::dynamics::{BodyState, Inertia};
use crate::spatial::Twist;
use nalgebra::Vector6;

/// An error up to this many times the tolerance of the solver is always allowed.
const UNKNOWN: f64 = 100.0;

/// The errors of a substep, as its stages are added.
pub(super) struct SubstepErrors<'a> {
    solver: &'a IslandSolver<'a>,
    estimate: &'a ErrorEstimate,
    inertias: &'a [&'a Inertia<Change>],
    given: &'a [Vector6<Change>],
    /// The rates of the motion at the start, carried through the stages.
    carried: Stages<'a, Change>,
    /// The states with the carried rates at the end; none if a stage is singular.
    ends: Option<Vec<BodyState<Change>>>,
}

impl<'a> SubstepErrors<'a> {
    /// The errors of a substep that begins at an offset (s); none for a method without an estimate.
    pub fn new(
        solver: &'a IslandSolver<'a>,
        (changed, inertias): (&'a ChangedBodies, &'a [&'a Inertia<Change>]),
        offset: f64,
    ) -> Option<Self> {
        let step = solver.step;
        let estimate = step.scheme.estimate.as_ref()?;
        let bodies = solver.solved.bodies.iter().enumerate();
        let from = bodies.map(|(place, body)| {
            let given = step.scene.given[step.island.dynamic[place]];
            let wrench = body.acting.unwrap_or_default() + given;
            let rates = BodyChange::rates(step.inertias[place], &body.state, &wrench);
            rates.of_state(inertias[place], &body.state)
        });
        let from: Vec<_> = from.collect();
        Some(Self {
            solver,
            estimate,
            inertias,
            given: &changed.given,
            carried: Stages::new(step, inertias, offset, from.clone()),
            ends: Some(from),
        })
    }

    /// Carries the rates through a stage, and raises the speeds of bodies to those of its end.
    pub fn push(&mut self, stage: &Stage, solved: &SolvedStage, speeds: &mut [f64]) {
        if self.ends.is_none() {
            return;
        }
        let start = self.carried.start(stage);
        let in_time = solved.rates_in_time();
        self.ends = solved.response((self.inertias, self.given), &start, &in_time);
        if let Some(ends) = &self.ends {
            self.carried.push(&start, ends);
        }
        for (place, speed) in speeds.iter_mut().enumerate() {
            *speed = speed.max(solved.relative_speed(place));
        }
    }

    /// The largest error of a body at the end of the last stage, relative to its tolerance. The speeds (m/s) of bodies are those
    /// of the step so far; `least` is the speed to which velocities are solved.
    pub fn relative(
        &self,
        last: &SolvedStage,
        stages: &Stages,
        duration: f64,
        (speeds, least): (&[f64], f64),
    ) -> f64 {
        let local = self.local_changes(last, stages, duration);
        let (Some(ends), Some(local)) = (&self.ends, local) else {
            return f64::INFINITY;
        };
        let control = &self.solver.control;
        let wrenches = &stages.rates()[stages.rates().len() - 1].wrenches;
        let mut largest = 0.0_f64;
        for (place, &speed) in speeds.iter().enumerate() {
            let (inertia, changed) = (self.solver.step.inertias[place], self.inertias[place]);
            let of_local = BodyChange::in_state(changed, &local[place]);
            let shift = inertia.speed(&of_local.displacement) / duration;
            let local = inertia.speed(&of_local.velocities).max(shift);
            let carried = BodyChange::in_state(changed, &ends[place]);
            let rates = BodyChange::rates(inertia, &last.states[place], &wrenches[place]);
            let slope = inertia.speed(&(carried.displacement - rates.displacement))
                + control.flight(speed) * inertia.speed(&(carried.velocities - rates.velocities));
            let unknown = UNKNOWN * least;
            largest = largest
                .max(local / (control.velocity(place, speed) + unknown))
                .max(slope / (control.slope(place, speed) + unknown));
        }
        // `max` ignores NaN.
        if largest.is_finite() {
            largest
        } else {
            f64::INFINITY
        }
    }

    /// The states at the end with the local error: the response of the last stage to the difference from the embedded formula.
    fn local_changes(
        &self,
        last: &SolvedStage,
        stages: &Stages,
        duration: f64,
    ) -> Option<Vec<BodyState<Change>>> {
        let start = &last.equations.start;
        let change = |value: f64, change: f64| Change::new(value, [change]);
        let count = self.inertias.len();
        let off = |place: usize| {
            let rates = stages.rates().iter();
            let displacement = self
                .estimate
                .of(rates.clone().map(|rates| rates.velocities[place]), duration);
            let momentum = self
                .estimate
                .of(rates.map(|rates| rates.wrenches[place]), duration);
            (displacement, momentum)
        };
        let (displacements, impulses): (Vec<_>, Vec<_>) = (0..count).map(off).unzip();
        let poses = (0..count).map(|place| {
            let state = BodyState {
                pose: start.poses[place],
                twist: Twist::zero(),
            };
            let own = BodyChange {
                displacement: displacements[place],
                velocities: Vector6::zeros(),
            };
            own.of_state(self.inertias[place], &state).pose
        });
        let momenta = start.momenta.iter().zip(&impulses);
        let start = StageStart {
            displacements: Vec::new(),
            poses: poses.collect(),
            momenta: momenta
                .map(|(momentum, off)| momentum.zip_map(off, change))
                .collect(),
            duration: start.duration,
            time: start.time,
        };
        let still = RatesInTime::none(last.states.len() - count, count);
        last.response((self.inertias, self.given), &start, &still)
    }
}
