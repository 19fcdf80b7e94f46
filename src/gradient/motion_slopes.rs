//! Derivatives of an experiment, compared with slopes of the motion.

use super::derivative_check::{CheckedDerivative, Verdict};
use super::widths::{DifferentiableOutcome, OutcomeIn};
use super::{Experiment, GradientError, OutcomeJacobian, Parameter};
use crate::dynamics::{State, Trajectory};
use crate::scalar::Scalar;
use nalgebra::{DVector, DVectorView};
use std::cell::OnceCell;
use std::ops::Range;

/// Largest difference between a derivative and a slope that agree, relative to the larger of the two.
const AGREEMENT: f64 = 0.03;

/// Errors of outcomes at tight tolerances, relative to the largest number of the outcome.
const NOISE: f64 = 1e-6;

/// An outcome, followed by the position of each body in each recorded state but the first.
pub(super) struct WithPositions<'a>(pub &'a dyn DifferentiableOutcome);

impl<'a, T: Scalar> OutcomeIn<T> for WithPositions<'a>
where
    dyn DifferentiableOutcome + 'a: OutcomeIn<T>,
{
    fn of_trajectory(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        let mut numbers = self.0.of_trajectory(trajectory);
        let states = trajectory.states()[1..].iter();
        for body in states.flat_map(|state| &state.bodies) {
            numbers.extend(body.position().iter().copied());
        }
        numbers
    }

    fn share_of(&self, _: &[f64], _: usize, _: &State<T>) -> Option<Vec<T>> {
        None
    }
}

/// The comparison of an experiment's derivatives with the motion.
pub(super) struct MotionCheck<'a> {
    experiment: &'a Experiment,
    /// The same experiment at tight tolerances.
    motion: Experiment,
    parameters: &'a [Parameter],
    watched: &'a WithPositions<'a>,
    found: OutcomeJacobian,
    /// The outcome at tight tolerances.
    middle: DVector<f64>,
    /// The Jacobian at tight tolerances, computed on demand.
    converged: OnceCell<OutcomeJacobian>,
}

/// Slopes of the motion by one number, for each number of the outcome.
struct Slopes {
    /// Over the width, of fourth order.
    both: DVector<f64>,
    /// On either side, of second order.
    sides: [DVector<f64>; 2],
    /// Bound of the error of the slopes.
    noise: f64,
}

impl<'a> MotionCheck<'a> {
    pub fn new(
        experiment: &'a Experiment,
        parameters: &'a [Parameter],
        watched: &'a WithPositions<'a>,
    ) -> Result<Self, GradientError> {
        let motion = experiment.with_plan(experiment.plan().converged());
        Ok(Self {
            experiment,
            middle: DVector::from_vec(motion.value_of(watched)?),
            motion,
            parameters,
            watched,
            found: experiment.jacobian_of(parameters, watched)?,
            converged: OnceCell::new(),
        })
    }

    /// Compares the derivatives by one number with the slopes over a width.
    pub fn checked(
        &self,
        number: String,
        column: usize,
        width: f64,
    ) -> Result<CheckedDerivative, GradientError> {
        let slopes = self.slopes(column, width)?;
        let derivative = self.found.jacobian.column(column);
        let outcome = 0..derivative.len() - self.positions();
        let verdict = self.verdict(column, &slopes, &outcome)?;
        let [own, slope] = [derivative, slopes.both.column(0)].map(|all| rows(&all, &outcome));
        let largest = own.amax().max(slope.amax());
        let error = (own - slope).amax();
        let is_right = verdict == Verdict::Right;
        Ok(CheckedDerivative {
            number,
            verdict,
            error: if error == 0.0 { 0.0 } else { error / largest },
            first_mismatch: if is_right {
                None
            } else {
                self.first_mismatch(&derivative, &slopes, outcome.end)
            },
        })
    }

    fn verdict(
        &self,
        column: usize,
        slopes: &Slopes,
        outcome: &Range<usize>,
    ) -> Result<Verdict, GradientError> {
        let agrees = |jacobian: &OutcomeJacobian, slope: &DVector<f64>| {
            let derivative = jacobian.jacobian.column(column);
            slopes.agree(
                &rows(&derivative, outcome),
                &slope.rows_range(outcome.clone()),
            )
        };
        if agrees(&self.found, &slopes.both) {
            return Ok(Verdict::Right);
        }
        let converged = self.converged()?;
        if agrees(converged, &slopes.both) {
            return Ok(Verdict::Unresolved);
        }
        let mut sides = slopes.sides.iter();
        let is_kink = sides.any(|side| agrees(&self.found, side) || agrees(converged, side));
        Ok(if is_kink {
            Verdict::Kink
        } else {
            Verdict::Chaotic
        })
    }

    /// The time and the body where a derivative of a position first is not the slope.
    fn first_mismatch(
        &self,
        derivative: &DVectorView<f64>,
        slopes: &Slopes,
        start: usize,
    ) -> Option<(f64, String)> {
        let system = self.experiment.system();
        let count = 3 * system.bodies.len();
        for (record, step) in self.recorded().enumerate() {
            let all = start + record * count..start + (record + 1) * count;
            let largest = slopes.both.rows_range(all.clone()).amax();
            for (place, body) in system.bodies.iter().enumerate() {
                let own = all.start + 3 * place..all.start + 3 * (place + 1);
                let slope = slopes.both.rows_range(own.clone());
                let error = (derivative.rows_range(own) - slope).amax();
                if error > AGREEMENT * largest + slopes.noise {
                    let time = system.start + step as f64 * self.experiment.plan().time_step();
                    return Some((time, body.name().to_owned()));
                }
            }
        }
        None
    }

    /// How many of the watched numbers are positions.
    fn positions(&self) -> usize {
        3 * self.experiment.system().bodies.len() * self.recorded().count()
    }

    /// The steps whose states are recorded.
    fn recorded(&self) -> impl Iterator<Item = usize> {
        let plan = self.experiment.plan();
        (1..=plan.steps()).filter(|&step| plan.records(step))
    }

    fn converged(&self) -> Result<&OutcomeJacobian, GradientError> {
        if let Some(known) = self.converged.get() {
            return Ok(known);
        }
        let found = self.motion.jacobian_of(self.parameters, self.watched)?;
        Ok(self.converged.get_or_init(|| found))
    }

    /// The slopes by one number.
    fn slopes(&self, column: usize, width: f64) -> Result<Slopes, GradientError> {
        let value = |times: f64| {
            let mut change = vec![0.0; self.found.jacobian.ncols()];
            change[column] = times * width;
            let value = self
                .motion
                .value_beside(self.parameters, &change, self.watched)?;
            Ok::<_, GradientError>(DVector::from_vec(value))
        };
        // Whole and half the width, for each side.
        let [whole_ahead, half_ahead] = [value(1.0)?, value(0.5)?];
        let [whole_behind, half_behind] = [value(-1.0)?, value(-0.5)?];
        let side = |whole: &DVector<f64>, half: &DVector<f64>, width: f64| {
            ((half - &self.middle) * 4.0 - (whole - &self.middle)) / width
        };
        let sides = [
            side(&whole_ahead, &half_ahead, width),
            side(&whole_behind, &half_behind, -width),
        ];
        let both =
            ((half_ahead - half_behind) * 8.0 - (whole_ahead - whole_behind)) / (6.0 * width);
        Ok(Slopes {
            noise: NOISE * self.middle.amax() / width,
            both,
            sides,
        })
    }
}

impl Slopes {
    /// Returns whether a derivative agrees with a slope.
    fn agree(&self, derivative: &DVector<f64>, slope: &DVectorView<f64>) -> bool {
        let largest = derivative.amax().max(slope.amax());
        (derivative - slope).amax() <= AGREEMENT * largest + self.noise
    }
}

fn rows(all: &DVectorView<f64>, range: &Range<usize>) -> DVector<f64> {
    all.rows_range(range.clone()).into_owned()
}
