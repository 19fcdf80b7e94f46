//! Derivatives of an experiment, compared with slopes of the motion.

use super::derivative_check::{CheckedDerivative, Verdict};
use super::error::check_outcome;
use super::widths::{DifferentiableOutcome, OutcomeIn};
use super::{Experiment, GradientError, OutcomeJacobian, Parameter};
use crate::dynamics::{State, Trajectory};
use crate::scalar::Scalar;
use nalgebra::{DVector, DVectorView};
use std::cell::OnceCell;
use std::ops::Range;

/// Largest difference between a derivative and a slope that agree, relative to the larger of the two.
const AGREEMENT: f64 = 0.03;

/// Amplification of the noise of outcomes by the difference formula over both sides, 3, and a margin.
const NOISE_GAIN: f64 = 4.0;

/// Slopes below this part of the outcome per typical change count as zero. Without such a bound, parameters without effect would never
/// be right, because the noise exceeds every part of a zero slope.
const NEGLIGIBLE_SLOPE: f64 = 1e-4;

/// Round-off of outcomes, relative to their largest number.
const ROUND_OFF: f64 = 1e-13;

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
    /// Noise of each of its numbers: by how much the error at tight tolerances changes over the width.
    noise: DVector<f64>,
    /// The Jacobian at tight tolerances, computed on demand.
    converged: OnceCell<OutcomeJacobian>,
}

/// Slopes of the motion by one number, for each number of the outcome.
struct Slopes {
    /// Over the width, of fourth order.
    both: DVector<f64>,
    /// On either side, of second order.
    sides: [DVector<f64>; 2],
    /// Bounds of their errors.
    noise: DVector<f64>,
}

impl<'a> MotionCheck<'a> {
    pub fn new(
        experiment: &'a Experiment,
        parameters: &'a [Parameter],
        watched: &'a WithPositions<'a>,
        width: f64,
    ) -> Result<Self, GradientError> {
        let found = experiment.jacobian_of(parameters, watched)?;
        let motion = experiment.with_plan(experiment.plan().converged());
        let zeros = DVector::zeros(found.jacobian.nrows());
        let mut check = Self {
            experiment,
            middle: zeros.clone(),
            noise: zeros,
            motion,
            parameters,
            watched,
            found,
            converged: OnceCell::new(),
        };
        let unchanged = vec![0.0; check.found.jacobian.ncols()];
        check.middle = check.value(&check.motion, &unchanged)?;
        check.noise = check.measured_noise(width)?;
        Ok(check)
    }

    /// Estimates the noise of the outcome, by one rollout with all parameters changed by the width, and two finer ones.
    fn measured_noise(&self, width: f64) -> Result<DVector<f64>, GradientError> {
        let finer = self.motion.with_plan(self.motion.plan().finer());
        let unchanged = vec![0.0; self.found.jacobian.ncols()];
        let scales = self.experiment.scales(self.parameters)?;
        let changed: Vec<_> = scales.iter().map(|scale| width * scale).collect();
        let error_changed = self.value(&self.motion, &changed)? - self.value(&finer, &changed)?;
        let error_unchanged = &self.middle - self.value(&finer, &unchanged)?;
        Ok((error_changed - error_unchanged).abs())
    }

    /// The outcome after a change of the parameters.
    fn value(&self, motion: &Experiment, change: &[f64]) -> Result<DVector<f64>, GradientError> {
        let value = motion.value_beside(self.parameters, change, self.watched)?;
        check_outcome(&value)?;
        let [found, expected] = [value.len(), self.found.jacobian.nrows()];
        if found != expected {
            let [found, expected] = [found, expected].map(|length| length - self.positions());
            return Err(GradientError::OutcomeLength { found, expected });
        }
        Ok(DVector::from_vec(value))
    }

    /// Compares the derivatives by one number with the slopes. The scale is the typical change of the number, and the width counts in
    /// such changes.
    pub fn checked(
        &self,
        number: String,
        (column, scale): (usize, f64),
        width: f64,
    ) -> Result<CheckedDerivative, GradientError> {
        let slopes = self.slopes(column, width * scale)?;
        let derivative = self.found.jacobian.column(column);
        let outcome = 0..derivative.len() - self.positions();
        let verdict = self.verdict((column, scale), &slopes, &outcome)?;
        let [own, slope] = [derivative, slopes.both.column(0)].map(|all| rows(&all, &outcome));
        let (difference, noise) = ((&own - &slope).amax(), slopes.noise_in(&outcome));
        let largest = own.amax().max(slope.amax());
        let first_mismatch = match verdict {
            Verdict::Right | Verdict::Noisy => None,
            Verdict::Kink | Verdict::Unresolved | Verdict::Chaotic => {
                self.first_mismatch(&derivative, &slopes, outcome.end)
            }
        };
        Ok(CheckedDerivative {
            number,
            verdict,
            error: match verdict {
                Verdict::Noisy => noise / largest,
                _ if difference <= noise => 0.0,
                _ => difference / largest,
            },
            first_mismatch,
        })
    }

    fn verdict(
        &self,
        (column, scale): (usize, f64),
        slopes: &Slopes,
        outcome: &Range<usize>,
    ) -> Result<Verdict, GradientError> {
        let agrees = |jacobian: &OutcomeJacobian, slope: &DVector<f64>| {
            let derivative = jacobian.jacobian.column(column);
            slopes.agree(&derivative, slope, outcome)
        };
        if agrees(&self.found, &slopes.both) {
            let derivative = self.found.jacobian.column(column);
            let [own, slope, value] = [&derivative, &slopes.both.column(0), &self.middle.column(0)]
                .map(|all| rows(all, outcome).amax());
            let largest = own.max(slope).max(NEGLIGIBLE_SLOPE * value / scale);
            let is_known = own.max(slope) == 0.0 || slopes.noise_in(outcome) <= AGREEMENT * largest;
            return Ok(if is_known {
                Verdict::Right
            } else {
                Verdict::Noisy
            });
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
                let error = (derivative.rows_range(own.clone()) - slope).amax();
                if error > AGREEMENT * largest + slopes.noise_in(&own) {
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
            self.value(&self.motion, &change)
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
        let noise = self.noise.zip_map(&self.middle, |noise, value| {
            NOISE_GAIN * (noise + ROUND_OFF * value.abs()) / width
        });
        Ok(Slopes { both, sides, noise })
    }
}

impl Slopes {
    /// Whether a derivative agrees with a slope in a range of rows.
    fn agree(
        &self,
        derivative: &DVectorView<f64>,
        slope: &DVector<f64>,
        range: &Range<usize>,
    ) -> bool {
        let (derivative, slope) = (
            derivative.rows_range(range.clone()),
            slope.rows_range(range.clone()),
        );
        let largest = derivative.amax().max(slope.amax());
        (derivative - slope).amax() <= AGREEMENT * largest + self.noise_in(range)
    }

    /// Bound of the errors in a range of rows.
    fn noise_in(&self, range: &Range<usize>) -> f64 {
        self.noise.rows_range(range.clone()).amax()
    }
}

fn rows(all: &DVectorView<f64>, range: &Range<usize>) -> DVector<f64> {
    all.rows_range(range.clone()).into_owned()
}
