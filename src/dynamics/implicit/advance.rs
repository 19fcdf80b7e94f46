//! Real pass of a step: advances an island in as many substeps as its errors require.

use super::evaluation::Evaluation;
use super::island_solver::{IslandSolver, Progress, SolvedStep};
use super::island_step::{StepError, Substep};

use super::stage::StageStart;
use super::step_size::StepSize;
use super::substep::Trial;
use crate::dynamics::Accuracy;
use crate::dynamics::multibody::Coordinates;
use crate::scalar::portable::power;
use nalgebra::{DVector, Vector6};

/// Shortest substep, as a fraction of the time step. If contact begins with a jump of stiffness, such as a flat face on a half-space,
/// substeps become very short. One of them then ends at the first contact.
const SHORTEST: f64 = 1.0 / (1 << 30) as f64;

/// Maximum number of substeps of a time step that are rejected because a stage is not solved.
const MOST_FAILURES: usize = 100;

/// Number of trials of a single free body in a time step, at the default tolerance. An island with n times the degrees of freedom has 1/n²
/// of this number. Few bodies can then resolve several impacts in a step, and the time of a step of a heap stays bounded.
const BUDGET: f64 = 2500.0;

/// Degrees of freedom of a free body.
const FREE_WIDTH: f64 = 6.0;

/// Lower bound of the budget. Four substeps without a rejection grow from 1/156 of the step to 4/5 of it.
const LEAST_BUDGET: f64 = 4.0;

/// Safety factor of the duration after a substep in which bodies might have passed through each other.
const TUNNELING_SAFETY: f64 = 0.9;

/// Factor of the duration after a stage that was not solved.
const RETRY: f64 = 0.25;

impl IslandSolver<'_> {
    /// Solves the step.
    pub fn solve(mut self, duration: f64) -> Result<SolvedStep, StepError> {
        if self.step.scheme.estimate.is_some() {
            self.evaluate_start()?;
        }
        self.advance(duration)?;
        Ok(self.solved)
    }

    /// Evaluates the forces at the start, unless the last step has provided them.
    fn evaluate_start(&mut self) -> Result<(), StepError> {
        if self.solved.progress.forces.is_some() {
            return Ok(());
        }
        let evaluation = self.evaluation_at(0.0)?;
        let multibody = &self.step.multibody;
        let SolvedStep { progress, work, .. } = &mut self.solved;
        work.evaluations += usize::from(!evaluation.contacts.is_empty());
        let Progress { kinematics, forces } = progress;
        *forces = Some(multibody.generalized_forces(kinematics, &evaluation.wrenches));
        Ok(())
    }

    /// Contacts and forces at the current positions, at a time (s) after the start of the step.
    fn evaluation_at(&self, offset: f64) -> Result<Evaluation, StepError> {
        let Coordinates {
            positions,
            velocities,
            multipliers,
        } = &self.solved.progress.kinematics.coordinates;
        let start = StageStart {
            displacement: DVector::zeros(velocities.len()),
            positions: positions.clone(),
            momenta: DVector::zeros(velocities.len()),
            closing_rates: DVector::zeros(multipliers.len()),
            duration: 0.0,
            time: self.step.start + offset,
        };
        let equations = self.step.equations(start)?;
        let unknowns = self.solved.progress.kinematics.coordinates.unknowns();
        Ok(equations.evaluation(unknowns, false))
    }

    /// Finds the reason why a substep was not solved. Evaluates the forces at the initial poses of the substep, at its initial and its
    /// final time. Returns [`StepError::Force`] if a force is not finite, and the original error otherwise.
    fn diagnosed(&self, error: StepError, offset: f64, duration: f64) -> StepError {
        if !matches!(error, StepError::Unsolved { .. }) {
            return error;
        }
        let is_not_finite = |wrench: &Vector6<f64>| !wrench.iter().all(|number| number.is_finite());
        for offset in [offset, offset + duration] {
            let wrenches = match self.evaluation_at(offset) {
                Ok(evaluation) => evaluation.wrenches,
                Err(error) => return error,
            };
            if let Some(index) = wrenches.iter().position(is_not_finite) {
                return StepError::Force {
                    body: self.step.island.dynamic[index],
                    time: self.step.start + offset,
                };
            }
        }
        error
    }

    /// Takes substeps until the end of the step.
    fn advance(&mut self, duration: f64) -> Result<(), StepError> {
        let estimate = self.step.scheme.estimate.as_ref();
        let order = estimate.map_or(1.0, |estimate| estimate.order);
        let mut size = StepSize::new(
            self.solved.allowed,
            order,
            SHORTEST * duration,
            self.budget(),
        );
        let mut offset = 0.0;
        while offset < duration {
            let remaining = duration - offset;
            let substep = size.next(remaining);
            let is_shortest = size.is_shortest(substep);
            let is_last_trial = is_shortest || size.is_last_trial(substep, remaining);
            let (trial, work) = self.try_substep(offset, substep);
            self.solved.work += work;
            match trial {
                Ok(trial) if trial.error() > 1.0 && !is_last_trial => {
                    self.solved.work.rejections += 1;
                    size.reject(substep, trial.error());
                }
                Ok(trial) if trial.tunneling_ratio > 1.0 && !is_shortest => {
                    self.solved.work.rejections += 1;
                    size.shorten(substep, TUNNELING_SAFETY / trial.tunneling_ratio);
                }
                Ok(trial) => {
                    size.accept(substep, trial.error());
                    self.accept(trial, offset, substep);
                    offset = if substep >= remaining {
                        duration
                    } else {
                        offset + substep
                    };
                }
                Err(StepError::Unsolved { .. })
                    if !is_shortest && self.solved.work.failures < MOST_FAILURES =>
                {
                    self.solved.work.failures += 1;
                    size.shorten(substep, RETRY);
                }
                Err(error) => return Err(self.diagnosed(error, offset, substep)),
            }
        }
        self.solved.allowed = size.allowed();
        Ok(())
    }

    /// Number of trials in a step. The number is proportional to the cube root of the tightness,
    /// because the duration at which an error of third order meets its tolerance is inversely
    /// proportional to this root.
    fn budget(&self) -> f64 {
        let count = (self.step.multibody.width() as f64 / FREE_WIDTH).max(1.0);
        let tightness = Accuracy::default().values() / self.control.accuracy.values();
        let trials = BUDGET / (count * count) * power(tightness, 1.0 / 3.0);
        trials.max(LEAST_BUDGET).floor()
    }

    fn accept(&mut self, trial: Trial, offset: f64, duration: f64) {
        let SolvedStep { swept, .. } = &mut self.solved;
        if swept.is_empty() {
            *swept = trial.swept;
        } else {
            for (all, bounds) in swept.iter_mut().zip(&trial.swept) {
                *all = all.union(bounds);
            }
        }
        let mut missed = Vec::new();
        let errors = self.solved.errors.iter_mut().zip(&trial.errors);
        for (index, (sum, errors)) in errors.enumerate() {
            if sum.add(errors, &self.control.accuracy) {
                missed.push(index);
            }
        }
        self.solved.work.substeps += 1;
        self.solved.work.missed += usize::from(!missed.is_empty());
        self.solved.substeps.push(Substep {
            offset,
            duration,
            roots: trial.roots,
            missed,
        });
        self.control.speeds = trial.speeds;
        self.solved.progress = trial.progress;
        self.solved.energy += trial.energy;
    }
}
