//! Levenberg–Marquardt method for the beginnings of the measurements up to one horizon.

use super::equations::{Equations, QuadraticModel, Step};
use super::error::check_count;
use super::{
    Checkpoint, Evaluated, Evaluator, Identification, IdentificationError, Iteration, Measurement,
};
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
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct FittedMeasurement {
    /// Name of the measurement.
    pub name: String,
    /// Cost of the measurement and of the priors of its nuisances. Zero after an error.
    pub cost: f64,
    /// Reason why the measurement was omitted: its rollout ended early at the initial guess of the horizon.
    pub error: Option<IdentificationError>,
}

/// Reason why a fit ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
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
    evaluator: &'a dyn Evaluator,
    /// Indices of the measurements that can be simulated.
    simulated: Vec<usize>,
    pub point: Checkpoint,
    /// Equations of these measurements, in their order.
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
    pub(super) fn new(name: &str, error: Option<IdentificationError>) -> Self {
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
    /// Evaluates the measurements at a point after a number of iterations.
    ///
    /// # Errors
    /// - If no measurement can be simulated at the point.
    /// - Errors of the evaluator.
    pub fn new(
        problem: &'a Identification,
        measurements: &'a [Measurement],
        evaluator: &'a dyn Evaluator,
        (point, iterations): (Checkpoint, usize),
    ) -> Result<Self, IdentificationError> {
        let all: Vec<usize> = (0..measurements.len()).collect();
        let results = equations_at(problem, evaluator, (&point, &all))?;
        let mut minimizer = Self {
            problem,
            evaluator,
            simulated: Vec::new(),
            point,
            equations: Vec::new(),
            priors: QuadraticModel::zeros(problem.unknowns.len()),
            cost: 0.0,
            iterations,
            measurements: Vec::new(),
            damping: Damping::new(),
        };
        for ((index, measurement), result) in measurements.iter().enumerate().zip(results) {
            let error = match result {
                Ok(equations) => {
                    minimizer.simulated.push(index);
                    minimizer.equations.push(equations);
                    None
                }
                Err(error) => Some(error),
            };
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
            } if self.simulated.is_empty() => Err(IdentificationError::NoRollout {
                measurement: name.clone(),
                source: Box::new(source.clone()),
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
        for (index, equations) in self.simulated.iter().zip(&self.equations) {
            self.measurements[*index].cost = equations.cost;
            self.cost += equations.cost;
        }
    }

    /// Minimizes the cost.
    ///
    /// # Errors
    /// Errors of the evaluator.
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
            horizon: self.problem.duration(&self.point),
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
        let at = (&point, &self.simulated[..]);
        let equations = equations_at(self.problem, self.evaluator, at)?;
        let Ok(equations) = equations.into_iter().collect() else {
            return Ok(false);
        };
        (self.point, self.equations) = (point, equations);
        self.update_cost();
        self.damping.decrease(decrease / step.predicted_decrease);
        Ok(true)
    }

    /// Returns the point after a step, and its cost. `None` if a rollout ends early, or a value is rounded to an end of its range.
    fn moved(&self, step: &Step) -> Result<Option<(Checkpoint, f64)>, IdentificationError> {
        let unknowns = &self.problem.unknowns;
        let mut point = self.point.clone();
        point.unknowns += &step.shared;
        if unknowns
            .of_values(&unknowns.values(&point.unknowns))
            .is_err()
        {
            return Ok(None);
        }
        for (&index, local) in self.simulated.iter().zip(&step.local) {
            point.nuisances[index] += local;
        }
        let Some(mut costs) = self.costs_at(&point, &self.simulated)? else {
            return Ok(None);
        };
        if !self.restore_nuisances(&mut point, &mut costs)? {
            return Ok(None);
        }
        let priors = QuadraticModel::zeros(unknowns.len()).add_priors(unknowns, &point.unknowns);
        let cost = costs.into_iter().fold(priors, |sum, cost| sum + cost);
        Ok(Some((point, cost)))
    }

    /// If a step increases the cost of a measurement, restores its previous nuisances, provided that they decrease this cost. Without this
    /// rule, one chaotic motion would shorten the steps of all measurements. Returns false if a rollout ends early.
    fn restore_nuisances(
        &self,
        point: &mut Checkpoint,
        costs: &mut [f64],
    ) -> Result<bool, IdentificationError> {
        let (mut restored, mut increased) = (point.clone(), Vec::new());
        for ((entry, &index), moved) in self.simulated.iter().enumerate().zip(&*costs) {
            let has_decreased = *moved <= self.measurements[index].cost;
            if !has_decreased && !point.nuisances[index].is_empty() {
                restored.nuisances[index].clone_from(&self.point.nuisances[index]);
                increased.push((entry, index));
            }
        }
        let indices: Vec<usize> = increased.iter().map(|(_, index)| *index).collect();
        if indices.is_empty() {
            return Ok(true);
        }
        let Some(costs_restored) = self.costs_at(&restored, &indices)? else {
            return Ok(false);
        };
        for ((entry, index), cost) in increased.into_iter().zip(costs_restored) {
            if cost < costs[entry] {
                costs[entry] = cost;
                point.nuisances[index].clone_from(&restored.nuisances[index]);
            }
        }
        Ok(true)
    }

    /// Costs of measurements at a point. `None` if a rollout ends early.
    ///
    /// # Errors
    /// Errors of the evaluator.
    fn costs_at(
        &self,
        point: &Checkpoint,
        measurements: &[usize],
    ) -> Result<Option<Vec<f64>>, IdentificationError> {
        let costs = self.evaluator.costs(point, measurements)?;
        check_count("costs", costs.len(), measurements.len())?;
        Ok(costs.into_iter().collect::<Result<_, _>>().ok())
    }
}

/// Evaluates the equations of measurements at a point, and checks their count and sizes.
///
/// # Errors
/// Errors of the evaluator.
fn equations_at(
    problem: &Identification,
    evaluator: &dyn Evaluator,
    (point, measurements): (&Checkpoint, &[usize]),
) -> Evaluated<Equations> {
    let results = evaluator.equations(point, measurements)?;
    check_count("equations", results.len(), measurements.len())?;
    for Equations { shared, local, .. } in results.iter().flatten() {
        let sizes = [shared.gradient.len(), local.gradient.len()];
        check_count("unknowns", sizes[0], problem.unknowns.len())?;
        check_count("nuisances", sizes[1], problem.nuisances.len())?;
    }
    Ok(results)
}
