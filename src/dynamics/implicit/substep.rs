//! Trial of a substep: solves its stages one after another.

use super::errors::ErrorEstimator;
use super::island_solver::{IslandSolver, Progress};
use super::island_step::StepError;
use super::newton::{Root, Unsolved};
use super::rates::{ChangedBodies, StartRates};
use super::report::{EnergyBalance, Work};
use super::solved_stage::SolvedStage;
use super::stage::{StageEquations, StageRates, Stages};
use crate::dynamics::multibody::Kinematics;
use crate::geometry::Aabb;
use nalgebra::DVector;

/// Result of a trial of a substep.
pub(super) struct Trial {
    /// Velocities and multipliers of loops that solve the stages.
    pub roots: Vec<DVector<f64>>,
    pub progress: Progress,
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
    /// Trial without stages.
    fn new(progress: Progress, speeds: Vec<f64>) -> Self {
        Self {
            roots: Vec::new(),
            progress,
            energy: EnergyBalance::default(),
            swept: Vec::new(),
            speeds,
            tunneling_ratio: 0.0,
            errors: Vec::new(),
        }
    }

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
        let (step, before) = (self.step, &self.solved.progress);
        let mut trial = Trial::new(before.clone(), self.control.speeds.clone());
        let mut stages = Stages::new(step, &step.multibody, offset, &before.kinematics);
        let estimate = step.scheme.estimate.as_ref();
        let start_rates = estimate.map(|_| self.start_rates(offset, duration));
        let mut solved = Vec::new();
        let weights = step.scheme.weights(duration);
        for (stage, weight) in step.scheme.stages(duration).zip(weights) {
            let equations = step.equations(stages.start(&stage))?;
            let last = solved
                .last()
                .map(|stage: &SolvedStage| stage.root.unknowns.clone());
            let guesses = [
                self.guess(offset, &equations, (&solved, start_rates.as_ref())),
                last.unwrap_or_else(|| before.kinematics.coordinates.unknowns()),
            ];
            let root = self.root(&equations, &guesses, duration, work)?;
            let end = equations.end(root.unknowns.clone());
            step.context
                .sweep(step.island, &end.states, &mut trial.swept);
            let rates = stages.push(&equations.start, &end);
            Self::add_stage(&equations, (rates, weight), &end, &mut trial);
            solved.push(SolvedStage {
                equations,
                end,
                root,
            });
        }
        if let Some(last) = solved.last() {
            trial.progress.kinematics.clone_from(&last.end);
        }
        trial.energy.kinetic = self.kinetic(&trial.progress) - self.kinetic(before);
        if let (Some(estimate), Some(start_rates)) = (estimate, &start_rates) {
            trial.include_speeds_of(&solved);
            let mut estimator = ErrorEstimator {
                solver: self,
                estimate,
                stages: &stages,
                solved,
                start_rates,
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
        trial.roots = solved.map(|stage| stage.root.unknowns).collect();
        Ok(trial)
    }

    /// Rates at the start of a substep of a duration (s).
    fn start_rates(&self, offset: f64, duration: f64) -> StartRates {
        let (step, Progress { kinematics, forces }) = (self.step, &self.solved.progress);
        let neighbors = step.neighbor_rates(step.start + offset, duration);
        let applied = step
            .island
            .dynamic
            .iter()
            .map(|&body| step.context.applied[body]);
        let mut rates = step.multibody.generalized_forces(kinematics, applied)
            + kinematics.momentum_transport();
        let coordinates = &kinematics.coordinates;
        step.multibody
            .add_joint_forces(coordinates, step.start + offset, &mut rates);
        if let Some(forces) = forces {
            rates += forces;
        }
        let bodies = ChangedBodies::new(step);
        StartRates {
            accelerations: bodies.accelerations(step, kinematics, &rates, &neighbors),
            neighbors,
            bodies,
        }
    }

    /// First guess of the unknowns of a stage. It is extrapolated linearly from the unknowns of the last two stages, or of the start
    /// and the first stage. The first stage uses the accelerations at the start, if error control has evaluated them.
    fn guess(
        &self,
        offset: f64,
        equations: &StageEquations,
        (solved, start_rates): (&[SolvedStage], Option<&StartRates>),
    ) -> DVector<f64> {
        let mut start = self.solved.progress.kinematics.coordinates.unknowns();
        let Some((last, before)) = solved.split_last() else {
            let ahead = equations.start.time - (self.step.start + offset);
            if let Some(StartRates { accelerations, .. }) = start_rates {
                let mut velocities = start.rows_mut(0, accelerations.len());
                velocities += accelerations * ahead;
            }
            return start;
        };
        let time = |stage: &SolvedStage| stage.equations.start.time;
        let (early, first) = before
            .last()
            .map_or((self.step.start + offset, &start), |before| {
                (time(before), &before.root.unknowns)
            });
        let (late, second) = (time(last), &last.root.unknowns);
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

    /// Adds the energy of a stage with a weight (s), and stores the forces at the end of the stage.
    fn add_stage(
        equations: &StageEquations,
        (rates, weight): (&StageRates, f64),
        end: &Kinematics,
        trial: &mut Trial,
    ) {
        let multibody = equations.multibody;
        let applied = (0..multibody.links.len()).map(|index| equations.applied_wrench(index));
        let applied = multibody.generalized_forces(end, applied);
        let forces = &rates.momenta - end.momentum_transport() - &applied;
        trial.energy.given += weight * applied.dot(&rates.velocities);
        trial.energy.acting += weight * forces.dot(&rates.velocities);
        let time = equations.start.time;
        trial.progress.forces = Some(forces - multibody.joint_forces(&end.coordinates, time));
    }

    /// Kinetic energy (J).
    fn kinetic(&self, progress: &Progress) -> f64 {
        let (multibody, kinematics) = (&self.step.multibody, &progress.kinematics);
        let links = multibody.links.iter().zip(&kinematics.states);
        let of_links = links.map(|(link, state)| {
            let armature = link.columns.clone().map(|column| {
                let velocity = kinematics.velocities()[column];
                link.law.armature * velocity * velocity
            });
            let twist = state.twist.to_vector();
            0.5 * (link.inertia.momentum(state).dot(&twist) + armature.sum::<f64>())
        });
        of_links.sum()
    }
}
