//! The real pass of a step: an island in as many substeps as its forces require.

use super::island_step::{IslandStep, StepError, Substep};
use super::report::{EnergyBalance, Work};
use super::stage::{StageStart, concatenated};
use super::substep::Trial;
use crate::dynamics::{BodyState, Inertia};
use crate::geometry::Aabb;
use nalgebra::{DVector, Vector6};

/// A substep is halved if the wrench on a body changes between two stages so much that over the substep the change could give
/// the body more energy than this fraction of its kinetic energy, and twice the energy of a fall for the time step.
const LARGEST_GAIN: f64 = 0.04;

/// Halvings of a step whose forces change much: to 1/128.
const MOST_HALVINGS: u32 = 7;

/// Halvings of a step with a stage that was not solved: to 1/4096.
const MOST_RETRIES: u32 = 12;

/// The motion of an island through a time step.
#[derive(Debug)]
pub(super) struct SolvedStep {
    pub substeps: Vec<Substep>,
    pub bodies: Vec<BodyProgress>,
    pub work: Work,
    pub energy: EnergyBalance,
    /// Box around each participant in all substeps.
    pub swept: Vec<Aabb>,
}

/// A dynamic body between two substeps.
#[derive(Debug, Clone, Copy)]
pub(super) struct BodyProgress {
    pub state: BodyState,
    /// Wrench of contacts and forces in the last stage; none before the first.
    pub acting: Option<Vector6<f64>>,
}

/// The real pass over an island's step.
pub(super) struct IslandSolver<'a> {
    pub step: &'a IslandStep<'a>,
    /// Tolerance of velocities in a stage, relative to the velocities.
    pub tolerance: f64,
    /// The change of speed (m/s) of each body that forces may cause between two stages.
    pub largest_changes: Vec<f64>,
    pub solved: SolvedStep,
}

impl<'a> IslandSolver<'a> {
    pub fn new(step: &'a IslandStep<'a>, tolerance: f64, bodies: Vec<BodyProgress>) -> Self {
        Self {
            step,
            tolerance,
            largest_changes: Vec::new(),
            solved: SolvedStep {
                substeps: Vec::new(),
                bodies,
                work: Work::default(),
                energy: EnergyBalance::default(),
                swept: Vec::new(),
            },
        }
    }

    /// Takes the step.
    pub fn solve(mut self, duration: f64) -> Result<SolvedStep, StepError> {
        self.limit_changes(duration);
        if self.step.scheme.is_adaptive {
            self.evaluate_start()?;
        }
        self.advance(0.0, duration, 0)?;
        Ok(self.solved)
    }

    /// Sets the speed δ that gives a body of speed v the energy vδ + δ²/2 (m²/s², per mass) at which substeps are halved. It is
    /// the same in all substeps, because a change that is harmless for the step is not worth more substeps.
    fn limit_changes(&mut self, duration: f64) {
        let fall = self.step.scene.system.gravity.norm() * duration;
        let of_body = |(inertia, body): (&&Inertia, &BodyProgress)| {
            let speed = inertia.speed(&body.state.twist.to_vector());
            let doubled_energy = LARGEST_GAIN * speed * speed + 2.0 * fall * fall;
            (speed * speed + doubled_energy).sqrt() - speed
        };
        let bodies = self.step.inertias.iter().zip(&self.solved.bodies);
        self.largest_changes = bodies.map(of_body).collect();
    }

    /// Evaluates the wrenches at the start, unless the last step left them.
    fn evaluate_start(&mut self) -> Result<(), StepError> {
        let SolvedStep { bodies, work, .. } = &mut self.solved;
        if bodies.iter().all(|body| body.acting.is_some()) {
            return Ok(());
        }
        let none = vec![Vector6::zeros(); bodies.len()];
        let start = StageStart {
            displacements: none.clone(),
            poses: bodies.iter().map(|body| body.state.pose).collect(),
            momenta: none,
            duration: 0.0,
            time: self.step.start,
        };
        let equations = self.step.equations(start)?;
        let evaluation = equations.evaluation(velocities_of(bodies), false);
        work.evaluations += usize::from(!evaluation.contacts.is_empty());
        for (body, acting) in bodies.iter_mut().zip(evaluation.acting) {
            body.acting.get_or_insert(acting);
        }
        Ok(())
    }

    /// Takes a part of the step, in halves if necessary.
    fn advance(&mut self, offset: f64, duration: f64, depth: u32) -> Result<(), StepError> {
        let (trial, work) = self.try_substep(offset, duration);
        self.solved.work += work;
        match trial {
            Ok(trial) if trial.change > 1.0 && depth < MOST_HALVINGS => {
                self.solved.work.halvings += 1;
            }
            Ok(trial) => {
                self.accept(trial, offset, duration);
                return Ok(());
            }
            Err(StepError::Unsolved { .. }) if depth < MOST_RETRIES => {
                self.solved.work.failures += 1;
            }
            Err(error) => return Err(error),
        }
        let half = duration / 2.0;
        self.advance(offset, half, depth + 1)?;
        self.advance(offset + half, half, depth + 1)
    }

    fn accept(&mut self, trial: Trial, offset: f64, duration: f64) {
        let SolvedStep { swept, .. } = &mut self.solved;
        if swept.is_empty() {
            *swept = trial.swept;
        } else {
            for (all, own) in swept.iter_mut().zip(&trial.swept) {
                *all = all.union(own);
            }
        }
        self.solved.substeps.push(Substep {
            offset,
            duration,
            roots: trial.roots,
        });
        self.solved.bodies = trial.bodies;
        self.solved.energy += trial.energy;
    }
}

/// The velocities of bodies.
pub(super) fn velocities_of(bodies: &[BodyProgress]) -> DVector<f64> {
    concatenated(bodies.iter().map(|body| body.state.twist.to_vector()))
}
