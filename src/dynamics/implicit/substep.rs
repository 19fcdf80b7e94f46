//! Trial of a substep: solves its stages one after another.

use super::errors::ErrorEstimator;
use super::island_solver::{BodyProgress, IslandSolver, velocities_of};
use super::island_step::StepError;
use super::newton::{Root, Unsolved};
use super::report::{EnergyBalance, Work};
use super::solved_stage::{BodyChange, SolvedStage};
use super::stage::{StageEquations, StageRates, Stages, concatenated, six_of};
use crate::dynamics::BodyState;
use crate::geometry::Aabb;
use nalgebra::DVector;

/// Result of a trial of a substep.
pub(super) struct Trial {
    /// Velocities that solve the stages.
    pub roots: Vec<DVector<f64>>,
    pub bodies: Vec<BodyProgress>,
    pub energy: EnergyBalance,
    pub swept: Vec<Aabb>,
    /// Largest relative speed (m/s) of each dynamic body in the step so far.
    pub speeds: Vec<f64>,
    /// Largest relative motion of two bodies that may hit each other, divided by the sum of their
    /// thicknesses. It is 0 if the ratio is at most 1.
    pub tunneling_ratio: f64,
    /// Errors of values and of slopes of each dynamic body, relative to its tolerances. The list is
    /// empty without error control.
    pub errors: Vec<[f64; 2]>,
}

impl Trial {
    /// Largest error of a body, relative to its tolerance.
    pub fn error(&self) -> f64 {
        self.errors.iter().flatten().copied().fold(0.0, f64::max)
    }

    /// Raises the speeds to the relative speeds in these stages.
    fn include_speeds_of(&mut self, stages: &[SolvedStage]) {
        for (index, speed) in self.speeds.iter_mut().enumerate() {
            let speeds = stages.iter().map(|stage| stage.relative_speed(index));
            *speed = speeds.fold(*speed, f64::max);
        }
    }
}

impl IslandSolver<'_> {
    /// Tries a substep, and returns the trial and the work of its stages. A substep without a finite error counts as not solved.
    pub fn try_substep(&self, offset: f64, duration: f64) -> (Result<Trial, StepError>, Work) {
        let mut work = Work::default();
        let is_infinite = |errors: &[f64; 2]| !errors.iter().all(|error| error.is_finite());
        let trial = self.trial(offset, duration, &mut work).and_then(|trial| {
            match trial.errors.iter().position(is_infinite) {
                Some(index) => Err(StepError::Unsolved {
                    body: self.step.island.dynamic[index],
                    duration,
                }),
                None => Ok(trial),
            }
        });
        (trial, work)
    }

    fn trial(&self, offset: f64, duration: f64, work: &mut Work) -> Result<Trial, StepError> {
        let (step, before) = (self.step, &self.solved.bodies);
        let mut trial = Trial {
            roots: Vec::new(),
            bodies: before.clone(),
            energy: EnergyBalance::default(),
            swept: Vec::new(),
            speeds: self.control.speeds.clone(),
            tunneling_ratio: 0.0,
            errors: Vec::new(),
        };
        let from = before.iter().map(|body| body.state).collect();
        let mut stages = Stages::new(step, &step.inertias, offset, from);
        let mut solved = Vec::new();
        let weights = step.scheme.weights(duration);
        for (stage, weight) in step.scheme.stages(duration).zip(weights) {
            let equations = step.equations(stages.start(&stage))?;
            let last = solved
                .last()
                .map(|stage: &SolvedStage| stage.root.velocities.clone());
            let guesses = [
                self.guess(offset, &equations, &solved),
                last.unwrap_or_else(|| velocities_of(before)),
            ];
            let root = self.root(&equations, &guesses, duration, work)?;
            let states = equations.states_with(|index| six_of(&root.velocities, index));
            step.context.sweep(step.island, &states, &mut trial.swept);
            let rates = stages.push(&equations.start, &states);
            Self::add_stage(&equations, (rates, weight), &states, &mut trial);
            solved.push(SolvedStage {
                equations,
                states,
                root,
            });
        }
        trial.energy.kinetic = self.kinetic(&trial.bodies) - self.kinetic(before);
        if let Some(estimate) = &step.scheme.estimate {
            trial.include_speeds_of(&solved);
            let mut estimator = ErrorEstimator {
                solver: self,
                estimate,
                stages: &stages,
                solved,
                speeds: &trial.speeds,
                offset,
                duration,
            };
            trial.errors = estimator.errors(work);
            if step.context.is_stopped() {
                return Err(StepError::Stopped);
            }
            solved = estimator.solved;
            let follows_contacts = trial.error() <= 1.0;
            let span = (offset, duration);
            trial.tunneling_ratio =
                self.tunneling_ratio(span, &solved, &trial.swept, follows_contacts);
        }
        let solved = solved.into_iter();
        trial.roots = solved.map(|stage| stage.root.velocities).collect();
        Ok(trial)
    }

    /// Rates of the dynamic bodies at the start of a substep.
    pub fn rates(&self) -> impl Iterator<Item = BodyChange> {
        let step = self.step;
        let bodies = self.solved.bodies.iter().enumerate();
        bodies.map(move |(index, body)| {
            let applied = step.context.applied[step.island.dynamic[index]];
            let wrench = body.wrench.unwrap_or_default() + applied;
            BodyChange::rates(step.inertias[index], &body.state, &wrench)
        })
    }

    /// First guess of the velocities of a stage. It is extrapolated linearly from the velocities of the last two stages, or of the start
    /// and the first stage. The first stage uses the accelerations at the start, if error control has evaluated them.
    fn guess(
        &self,
        offset: f64,
        equations: &StageEquations,
        solved: &[SolvedStage],
    ) -> DVector<f64> {
        let start = velocities_of(&self.solved.bodies);
        let Some((last, before)) = solved.split_last() else {
            if self.step.scheme.estimate.is_none() {
                return start;
            }
            let ahead = equations.start.time - (self.step.start + offset);
            return start + concatenated(self.rates().map(|rates| rates.velocities * ahead));
        };
        let time = |stage: &SolvedStage| stage.equations.start.time;
        let (early, first) = before
            .last()
            .map_or((self.step.start + offset, &start), |before| {
                (time(before), &before.root.velocities)
            });
        let (late, second) = (time(last), &last.root.velocities);
        let ahead = (equations.start.time - late) / (late - early);
        if ahead.is_finite() {
            second + (second - first) * ahead
        } else {
            second.clone()
        }
    }

    /// Solves a stage from the first guess, or from the second guess if the first one fails.
    fn root(
        &self,
        equations: &StageEquations,
        guesses: &[DVector<f64>; 2],
        duration: f64,
        work: &mut Work,
    ) -> Result<Root, StepError> {
        let [first, second] = guesses;
        let solved = |guess, work: &mut Work| equations.solve(guess, self.tolerance, work);
        let root = match solved(first, work) {
            Err(_) if first != second => solved(second, work),
            root => root,
        };
        if self.step.context.is_stopped() {
            return Err(StepError::Stopped);
        }
        root.map_err(|Unsolved(correction)| StepError::Unsolved {
            body: equations.fastest(&correction),
            duration,
        })
    }

    /// Adds the energy of a stage with a weight (s), and moves the bodies to its end.
    fn add_stage(
        equations: &StageEquations,
        (rates, weight): (&StageRates, f64),
        states: &[BodyState],
        trial: &mut Trial,
    ) {
        for (index, body) in trial.bodies.iter_mut().enumerate() {
            let (velocity, applied) = (&rates.velocities[index], equations.applied_wrench(index));
            let wrench = rates.wrenches[index] - applied;
            trial.energy.given += weight * applied.dot(velocity);
            trial.energy.acting += weight * wrench.dot(velocity);
            body.state = states[index];
            body.wrench = Some(wrench);
        }
    }

    /// Kinetic energy (J).
    fn kinetic(&self, bodies: &[BodyProgress]) -> f64 {
        let bodies = self.step.inertias.iter().zip(bodies);
        let energies = bodies.map(|(inertia, body)| {
            let twist = body.state.twist.to_vector();
            inertia.momentum(&body.state).dot(&twist) / 2.0
        });
        energies.sum()
    }
}
