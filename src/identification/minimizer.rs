//! Levenberg–Marquardt method for the beginnings of the measurements up to one horizon.

use super::equations::{Equations, QuadraticModel, Step};
use super::trial::Trial;
use super::{Checkpoint, Identification, IdentificationError, Iteration, Measurement};
use crate::dynamics::RolloutError;
use crate::gradient::GradientError;
use crate::parallel;
use std::ops::ControlFlow;

/// Damping at the beginning.
const FIRST_DAMPING: f64 = 1e-3;
/// Damping at which the fit ends.
const LARGEST_DAMPING: f64 = 1e10;
/// Largest damping at which a small predicted decrease is convergence.
const CONVERGED_DAMPING: f64 = 0.1;
/// Predicted decrease of the cost at convergence: absolute, in units of ½χ², and relative to the cost.
const CONVERGED: [f64; 2] = [1e-3, 1e-6];

/// Result for one measurement.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct FittedMeasurement {
    /// Name of the measurement.
    pub name: String,
    /// Cost of the measurement and of the priors of its nuisances. Zero after an error.
    pub cost: f64,
    /// Reason why the measurement was omitted: its rollout ended early at the initial guess of the horizon.
    pub error: Option<GradientError>,
}

/// Reason why a fit ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Termination {
    /// The predicted decrease of the cost was below 1e-3 plus a millionth of the cost in the last step. A decrease of 1e-3 is 0.045
    /// standard deviations.
    Converged,
    /// No step of useful size decreases the cost. The motions may be chaotic (use shorter horizons or windows), or the tolerances of
    /// the plan may be too loose.
    Stalled,
    /// The largest number of iterations was reached.
    IterationLimit,
    /// The progress function returned [`ControlFlow::Break`].
    Stopped,
}

/// Minimization over the measurements that can be simulated.
pub(super) struct Minimizer<'a> {
    problem: &'a Identification,
    horizon: f64,
    /// Index of each measurement that can be simulated, with its beginning.
    trials: Vec<(usize, Trial<'a>)>,
    pub point: Checkpoint,
    /// Equations of the trials, in their order.
    pub equations: Vec<Equations>,
    /// Priors of the unknowns.
    pub priors: QuadraticModel,
    pub cost: f64,
    /// Number of iterations, over all horizons.
    pub iterations: usize,
    /// Result for each measurement.
    pub measurements: Vec<FittedMeasurement>,
    damping: Damping,
}

/// Damping of the steps, which follows the ratio of actual and predicted decrease \[Nielsen 1999\].
struct Damping {
    factor: f64,
    growth: f64,
}

impl FittedMeasurement {
    pub(super) fn new(name: &str, error: Option<GradientError>) -> Self {
        let (name, cost) = (name.to_owned(), 0.0);
        Self { name, cost, error }
    }
}

impl Damping {
    fn new() -> Self {
        let (factor, growth) = (FIRST_DAMPING, 2.0);
        Self { factor, growth }
    }

    /// Decreases the damping after a step with this ratio of actual and predicted decrease.
    fn decrease(&mut self, ratio: f64) {
        let change = 1.0 - (2.0 * ratio.min(1.0) - 1.0).powi(3);
        self.factor *= change.max(1.0 / 3.0);
        self.growth = 2.0;
    }

    /// Increases the damping after a rejected step.
    fn increase(&mut self) {
        self.factor *= self.growth;
        self.growth *= 2.0;
    }
}

impl<'a> Minimizer<'a> {
    /// Evaluates the beginnings of the measurements, with a duration (s), at a point after a number of iterations.
    ///
    /// # Errors
    /// - If a measurement does not fit the world or the time steps of the plan.
    /// - If no measurement can be simulated at the point, or the cancel flag is set.
    pub fn new(
        problem: &'a Identification,
        measurements: &'a [Measurement],
        horizon: f64,
        (point, iterations): (Checkpoint, usize),
    ) -> Result<Self, IdentificationError> {
        let trials = measurements.iter();
        let trials = trials.map(|measurement| Trial::new(problem, measurement, horizon));
        let trials: Vec<_> = trials
            .enumerate()
            .map(|(i, trial)| Ok((i, trial?)))
            .collect::<Result<_, IdentificationError>>()?;
        let results = parallel::map(&trials, |(i, trial)| trial.equations(point.of(*i)));
        let mut minimizer = Self {
            problem,
            horizon,
            trials: Vec::new(),
            point,
            equations: Vec::new(),
            priors: QuadraticModel::zeros(problem.unknowns.len()),
            cost: 0.0,
            iterations,
            measurements: Vec::new(),
            damping: Damping::new(),
        };
        for ((trial, result), measurement) in trials.into_iter().zip(results).zip(measurements) {
            let (equations, error) = match result {
                Ok(equations) => (Some(equations), None),
                Err(error) => (None, Some(unless_stopped(error)?)),
            };
            minimizer
                .trials
                .extend(equations.is_some().then_some(trial));
            minimizer.equations.extend(equations);
            minimizer
                .measurements
                .push(FittedMeasurement::new(measurement.name(), error));
        }
        minimizer.check_rollouts()?;
        minimizer.update_cost();
        Ok(minimizer)
    }

    /// Checks that at least one measurement can be simulated.
    fn check_rollouts(&self) -> Result<(), IdentificationError> {
        match &self.measurements[0] {
            FittedMeasurement {
                name,
                error: Some(source),
                ..
            } if self.trials.is_empty() => Err(IdentificationError::NoRollout {
                measurement: name.clone(),
                source: source.clone(),
            }),
            _ => Ok(()),
        }
    }

    /// Updates priors, costs and total cost after a change of the point.
    fn update_cost(&mut self) {
        self.priors = QuadraticModel::zeros(self.problem.unknowns.len());
        self.cost = self
            .priors
            .add_priors(&self.problem.unknowns, &self.point.unknowns);
        for ((index, _), equations) in self.trials.iter().zip(&self.equations) {
            self.measurements[*index].cost = equations.cost;
            self.cost += equations.cost;
        }
    }

    /// Minimizes the cost.
    ///
    /// # Errors
    /// If the cancel flag is set.
    pub fn run(&mut self) -> Result<Termination, IdentificationError> {
        let end = self.iterations + self.problem.iterations;
        loop {
            if self.problem.report_progress(|| self.progress()) == ControlFlow::Break(()) {
                return Ok(Termination::Stopped);
            }
            if self.iterations == end {
                return Ok(Termination::IterationLimit);
            }
            if let Some(termination) = self.improve()? {
                return Ok(termination);
            }
            self.iterations += 1;
        }
    }

    fn progress(&self) -> Iteration {
        Iteration {
            index: self.iterations,
            horizon: self.horizon,
            cost: self.cost,
            values: self.problem.unknowns.values(&self.point.unknowns),
            checkpoint: self.point.clone(),
        }
    }

    /// Takes the first damped step that decreases the cost. Returns the reason of the end if there is none, or if the predicted decrease
    /// is small.
    fn improve(&mut self) -> Result<Option<Termination>, IdentificationError> {
        while self.damping.factor < LARGEST_DAMPING {
            let damping = self.damping.factor;
            if let Some(step) = Step::new(&self.equations, &self.priors, damping) {
                let is_small = step.predicted_decrease <= CONVERGED[0] + CONVERGED[1] * self.cost;
                let is_accepted = self.take(&step)?;
                if is_small && damping <= CONVERGED_DAMPING {
                    return Ok(Some(Termination::Converged));
                }
                if is_small {
                    return Ok(Some(Termination::Stalled));
                }
                if is_accepted {
                    return Ok(None);
                }
            }
            self.damping.increase();
        }
        Ok(Some(Termination::Stalled))
    }

    /// Takes a step if all rollouts reach their end and the cost decreases. Returns whether the step was taken.
    fn take(&mut self, step: &Step) -> Result<bool, IdentificationError> {
        let Some((point, cost)) = self.moved(step)? else {
            return Ok(false);
        };
        let decrease = self.cost - cost;
        if decrease <= 0.0 {
            return Ok(false);
        }
        let Some(equations) = self.at_all(|index, trial| trial.equations(point.of(index)))? else {
            return Ok(false);
        };
        (self.point, self.equations) = (point, equations);
        self.update_cost();
        self.damping.decrease(decrease / step.predicted_decrease);
        Ok(true)
    }

    /// Returns the point after a step, and its cost. `None` if a rollout ends early.
    ///
    /// If a step increases the cost of a measurement, its old nuisances are kept if they have a lower cost. One chaotic motion then does
    /// not shorten the steps of all measurements.
    fn moved(&self, step: &Step) -> Result<Option<(Checkpoint, f64)>, IdentificationError> {
        let mut point = self.point.clone();
        point.unknowns += &step.shared;
        for ((index, _), local) in self.trials.iter().zip(&step.local) {
            point.nuisances[*index] += local;
        }
        let least = |index: usize, trial: &Trial| {
            let moved = trial.cost(point.of(index))?;
            if moved <= self.measurements[index].cost {
                return Ok((moved, true));
            }
            let kept = trial.cost([&point.unknowns, &self.point.nuisances[index]])?;
            Ok((moved.min(kept), moved <= kept))
        };
        let Some(costs) = self.at_all(least)? else {
            return Ok(None);
        };
        let unknowns = &self.problem.unknowns;
        let mut cost = QuadraticModel::zeros(unknowns.len()).add_priors(unknowns, &point.unknowns);
        for ((index, _), (least, is_moved)) in self.trials.iter().zip(costs) {
            cost += least;
            if !is_moved {
                point.nuisances[*index].clone_from(&self.point.nuisances[*index]);
            }
        }
        Ok(Some((point, cost)))
    }

    /// Values of a function of the index of a measurement and its trial, for all trials. `None` if a rollout ends early.
    ///
    /// # Errors
    /// If the cancel flag is set.
    fn at_all<O: Send>(
        &self,
        function: impl Fn(usize, &Trial<'a>) -> Result<O, GradientError> + Sync,
    ) -> Result<Option<Vec<O>>, IdentificationError> {
        let results = parallel::map(&self.trials, |(index, trial)| function(*index, trial));
        match results.into_iter().collect::<Result<_, _>>() {
            Ok(values) => Ok(Some(values)),
            Err(error) => unless_stopped(error).map(|_| None),
        }
    }
}

/// Returns an error of a rollout, unless the rollout was stopped.
///
/// # Errors
/// The error of a stopped rollout.
fn unless_stopped(error: GradientError) -> Result<GradientError, IdentificationError> {
    match error {
        GradientError::Rollout(RolloutError::Stopped) => Err(error.into()),
        _ => Ok(error),
    }
}
