//! The real pass of a step: an island in as many substeps as its errors require.

use super::error_control::ErrorControl;
use super::island_step::{IslandStep, StepError, Substep};
use super::report::{EnergyBalance, Work};
use super::stage::{StageStart, concatenated};
use super::substep::Trial;
use crate::dynamics::BodyState;
use crate::geometry::Aabb;
use nalgebra::{DVector, Vector6};

/// Shortest substep, as a fraction of the time step. Contact that begins with a jump of stiffness, such as a flat face on a
/// half-space, would divide without end.
const SHORTEST: f64 = 1.0 / 65536.0;

/// Safety factor of the next duration.
const SAFETY: f64 = 0.9;

/// Growth of the duration after a substep, and after one that was rejected before.
const MOST_GROWTH: [f64; 2] = [5.0, 1.0];

/// Reduction of the duration after a rejected substep.
const REDUCTIONS: [f64; 2] = [0.02, 0.6];

/// Lowest power with which errors are taken to decrease. Contact that begins or ends lowers it.
const LOWEST_ORDER: f64 = 0.7;

/// Reduction of the duration after a stage that was not solved.
const RETRY: f64 = 0.25;

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
    /// Duration (s) that the errors of the last substep allow for the next.
    pub allowed: f64,
}

/// The real pass over an island's step.
pub(super) struct IslandSolver<'a> {
    pub step: &'a IslandStep<'a>,
    /// Tolerance of velocities in a stage, relative to the velocities.
    pub tolerance: f64,
    pub control: ErrorControl,
    pub solved: SolvedStep,
}

impl<'a> IslandSolver<'a> {
    pub fn new(
        step: &'a IslandStep<'a>,
        tolerance: f64,
        control: ErrorControl,
        bodies: Vec<BodyProgress>,
    ) -> Self {
        Self {
            step,
            tolerance,
            control,
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
        if self.step.scheme.estimate.is_some() {
            self.evaluate_start()?;
        }
        self.advance(duration)?;
        Ok(self.solved)
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

    /// Takes substeps until the end of the step.
    fn advance(&mut self, duration: f64) -> Result<(), StepError> {
        let shortest = SHORTEST * duration;
        let bodies = self.solved.bodies.iter();
        let mut allowed = bodies
            .map(|body| body.allowed)
            .fold(f64::INFINITY, f64::min);
        let mut rejected: Option<(f64, f64)> = None;
        let mut offset = 0.0;
        while offset < duration {
            let left = duration - offset;
            let wanted = allowed.min(self.longest_unseen()).max(shortest);
            // Two halves instead of a long substep and a short one.
            let substep = if wanted >= left * (1.0 - 1e-9) {
                left
            } else {
                wanted.min(left / 2.0)
            };
            let is_shortest = substep <= shortest * (1.0 + 1e-9);
            let (trial, work) = self.try_substep(offset, substep);
            self.solved.work += work;
            match trial {
                Ok(trial) if trial.error <= 1.0 || is_shortest => {
                    let growth = self.growth(trial.error, self.order());
                    let most = MOST_GROWTH[usize::from(rejected.is_some())];
                    let next = substep * growth.min(most);
                    // The end of the step cuts substeps short, which says nothing about the next.
                    allowed = if growth >= 1.0 {
                        allowed.max(next).min(most * allowed)
                    } else {
                        next
                    };
                    allowed = if allowed.is_finite() { allowed } else { next };
                    rejected = None;
                    self.accept(trial, offset, substep);
                    offset = if substep >= left {
                        duration
                    } else {
                        offset + substep
                    };
                }
                Ok(trial) => {
                    self.solved.work.rejections += 1;
                    let order = rejected.map_or(self.order(), |(longer, error)| {
                        let seen = (error / trial.error).ln() / (longer / substep).ln();
                        if seen.is_finite() {
                            seen.clamp(LOWEST_ORDER, self.order())
                        } else {
                            self.order()
                        }
                    });
                    rejected = Some((substep, trial.error));
                    let [least, most] = REDUCTIONS;
                    allowed = substep * self.growth(trial.error, order).clamp(least, most);
                }
                Err(StepError::Unsolved { .. }) if !is_shortest => {
                    self.solved.work.failures += 1;
                    rejected = Some((substep, f64::INFINITY));
                    allowed = substep * RETRY;
                }
                Err(error) => return Err(error),
            }
        }
        for body in &mut self.solved.bodies {
            body.allowed = allowed;
        }
        Ok(())
    }

    /// The power with which errors decrease.
    fn order(&self) -> f64 {
        self.step
            .scheme
            .estimate
            .as_ref()
            .map_or(1.0, |estimate| estimate.order)
    }

    /// The factor of the duration at which an error would be just allowed.
    fn growth(&self, error: f64, order: f64) -> f64 {
        SAFETY * error.powf(-order.recip())
    }

    /// The time (s) in which a body on which nothing acts yet may pass through another: the sum of their thicknesses over their
    /// relative speed.
    fn longest_unseen(&self) -> f64 {
        if self.step.scheme.estimate.is_none() {
            return f64::INFINITY;
        }
        let (scene, island) = (self.step.scene, self.step.island);
        let bodies = &self.solved.bodies;
        let thickness = |participant: usize| scene.thickness(island.body(participant));
        let velocity = |participant: usize| match bodies.get(participant) {
            Some(body) => body.state.twist.linear,
            None => scene.start[island.body(participant)].twist.linear,
        };
        let mut longest = f64::INFINITY;
        for (place, body) in bodies.iter().enumerate() {
            if body.acting.is_some_and(|acting| acting.norm() > 0.0) {
                continue;
            }
            for other in (0..island.bodies().count()).filter(|&other| other != place) {
                let speed = (velocity(place) - velocity(other)).norm();
                longest = longest.min((thickness(place) + thickness(other)) / speed);
            }
        }
        longest
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
        self.solved.work.substeps += 1;
        let is_missed = trial.error > 1.0;
        self.solved.work.missed += usize::from(is_missed);
        self.solved.substeps.push(Substep {
            offset,
            duration,
            roots: trial.roots,
            is_missed,
        });
        self.control.speeds = trial.speeds;
        self.solved.bodies = trial.bodies;
        self.solved.energy += trial.energy;
    }
}

/// The velocities of bodies.
pub(super) fn velocities_of(bodies: &[BodyProgress]) -> DVector<f64> {
    concatenated(bodies.iter().map(|body| body.state.twist.to_vector()))
}
