//! Comparison of the derivatives of an experiment with the slopes of the motion.

use super::dual_widths::{DifferentiableOutcome, OutcomeIn};
use super::error::check_outcome;
use super::{CheckedDerivative, Experiment, GradientError, OutcomeJacobian, Parameter, Verdict};
use crate::dynamics::{State, Trajectory};
use crate::scalar::Scalar;
use nalgebra::{DVector, DVectorView};
use std::cell::OnceCell;
use std::ops::Range;

/// Largest difference between a derivative and a slope that agree, relative to the larger of the two.
const AGREEMENT: f64 = 0.03;

/// Noise of slopes relative to the noise of outcomes: 3 for the central difference formula, plus a
/// margin.
const NOISE_GAIN: f64 = 4.0;

/// Slopes below this fraction of the outcome per typical change count as zero. Without this bound, parameters without effect would
/// never be right, because the noise exceeds any fraction of a zero slope.
const NEGLIGIBLE_SLOPE: f64 = 1e-4;

/// Round-off of outcomes, relative to their values.
const ROUND_OFF: f64 = 1e-13;

/// An outcome, followed by the position (m) of each body in each recorded state except the first.
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

/// Comparison of the derivatives of an experiment with the motion.
pub(super) struct MotionCheck<'a> {
    experiment: &'a Experiment,
    /// The experiment at tight tolerances.
    motion: Experiment,
    parameters: &'a [Parameter],
    outcome_and_positions: &'a WithPositions<'a>,
    /// The Jacobian of the plan.
    jacobian: OutcomeJacobian,
    /// The outcome at tight tolerances, with unchanged parameters.
    unperturbed: DVector<f64>,
    /// Noise of each outcome component: the change of the error at tight tolerances over the width.
    noise: DVector<f64>,
    /// The Jacobian at tight tolerances, computed on demand.
    converged: OnceCell<OutcomeJacobian>,
}

/// Slopes of the motion with respect to one parameter component, for each outcome component.
struct Slopes {
    /// Central slopes, of fourth order in the width.
    central: DVector<f64>,
    /// Slopes on the positive and the negative side, of second order in the width.
    one_sided: [DVector<f64>; 2],
    /// Bounds of the errors of the slopes.
    noise: DVector<f64>,
}

impl<'a> MotionCheck<'a> {
    pub fn new(
        experiment: &'a Experiment,
        parameters: &'a [Parameter],
        outcome_and_positions: &'a WithPositions<'a>,
        width: f64,
    ) -> Result<Self, GradientError> {
        let jacobian = experiment.jacobian_of(parameters, outcome_and_positions)?;
        let motion = experiment.with_plan(experiment.plan().converged());
        let zeros = DVector::zeros(jacobian.jacobian.nrows());
        let mut check = Self {
            experiment,
            unperturbed: zeros.clone(),
            noise: zeros,
            motion,
            parameters,
            outcome_and_positions,
            jacobian,
            converged: OnceCell::new(),
        };
        let unchanged = vec![0.0; check.jacobian.jacobian.ncols()];
        check.unperturbed = check.value(&check.motion, &unchanged)?;
        check.noise = check.measured_noise(width)?;
        Ok(check)
    }

    /// Estimates the noise of the outcome from one rollout with all parameters changed by the width, and from two rollouts at even
    /// tighter tolerances.
    fn measured_noise(&self, width: f64) -> Result<DVector<f64>, GradientError> {
        let finer = self.motion.with_plan(self.motion.plan().finer());
        let unchanged = vec![0.0; self.jacobian.jacobian.ncols()];
        let scales = self.experiment.scales(self.parameters)?;
        let changed: Vec<_> = scales.iter().map(|scale| width * scale).collect();
        let error_changed = self.value(&self.motion, &changed)? - self.value(&finer, &changed)?;
        let error_unchanged = &self.unperturbed - self.value(&finer, &unchanged)?;
        Ok((error_changed - error_unchanged).abs())
    }

    /// Outcome and positions after a change of the parameters.
    fn value(&self, motion: &Experiment, change: &[f64]) -> Result<DVector<f64>, GradientError> {
        let value = motion.value_perturbed_unchecked(
            self.parameters,
            change,
            self.outcome_and_positions,
        )?;
        check_outcome(&value)?;
        let [found, expected] = [value.len(), self.jacobian.jacobian.nrows()];
        if found != expected {
            let [found, expected] = [found, expected].map(|length| length - self.position_count());
            return Err(GradientError::OutcomeLength { found, expected });
        }
        Ok(DVector::from_vec(value))
    }

    /// Compares the derivatives with respect to one number with the slopes. The scale is the typical change of the number. The width
    /// is a multiple of the scale.
    pub fn checked(
        &self,
        number: String,
        (column, scale): (usize, f64),
        width: f64,
    ) -> Result<CheckedDerivative, GradientError> {
        let slopes = self.slopes(column, width * scale)?;
        let column_derivative = self.jacobian.jacobian.column(column);
        let outcome = 0..column_derivative.len() - self.position_count();
        let verdict = self.verdict((column, scale), &slopes, &outcome)?;
        let [derivative, slope] =
            [column_derivative, slopes.central.column(0)].map(|all| rows(&all, &outcome));
        let (difference, noise) = ((&derivative - &slope).amax(), slopes.noise_in(&outcome));
        let largest = derivative.amax().max(slope.amax());
        let first_mismatch = match verdict {
            Verdict::Right | Verdict::Noisy => None,
            Verdict::Kink | Verdict::Unresolved | Verdict::Chaotic => {
                self.first_mismatch(&column_derivative, &slopes, outcome.end)
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
        if agrees(&self.jacobian, &slopes.central) {
            let derivative = self.jacobian.jacobian.column(column);
            let (slope, value) = (slopes.central.column(0), self.unperturbed.column(0));
            let [derivative, slope, value] =
                [&derivative, &slope, &value].map(|all| rows(all, outcome).amax());
            let largest = derivative.max(slope);
            let scale = largest.max(NEGLIGIBLE_SLOPE * value / scale);
            let is_known = largest == 0.0 || slopes.noise_in(outcome) <= AGREEMENT * scale;
            return Ok(if is_known {
                Verdict::Right
            } else {
                Verdict::Noisy
            });
        }
        let converged = self.converged()?;
        if agrees(converged, &slopes.central) {
            return Ok(Verdict::Unresolved);
        }
        let mut sides = slopes.one_sided.iter();
        let is_kink = sides.any(|side| agrees(&self.jacobian, side) || agrees(converged, side));
        Ok(if is_kink {
            Verdict::Kink
        } else {
            Verdict::Chaotic
        })
    }

    /// Time (s) and body of the first derivative of a position that does not agree with the slope.
    fn first_mismatch(
        &self,
        derivative: &DVectorView<f64>,
        slopes: &Slopes,
        start: usize,
    ) -> Option<(f64, String)> {
        let model = self.experiment.model();
        let count = 3 * model.bodies.len();
        for (record, step) in self.recorded_steps().enumerate() {
            let all = start + record * count..start + (record + 1) * count;
            let largest = slopes.central.rows_range(all.clone()).amax();
            for (index, body) in model.bodies.iter().enumerate() {
                let of_body = all.start + 3 * index..all.start + 3 * (index + 1);
                let slope = slopes.central.rows_range(of_body.clone());
                let error = (derivative.rows_range(of_body.clone()) - slope).amax();
                if error > AGREEMENT * largest + slopes.noise_in(&of_body) {
                    let time = model.start + step as f64 * self.experiment.plan().time_step();
                    return Some((time, body.name().to_owned()));
                }
            }
        }
        None
    }

    /// Number of coordinates of positions that follow the outcome.
    fn position_count(&self) -> usize {
        3 * self.experiment.model().bodies.len() * self.recorded_steps().count()
    }

    /// Steps whose states are recorded.
    fn recorded_steps(&self) -> impl Iterator<Item = usize> {
        let plan = self.experiment.plan();
        (1..=plan.steps()).filter(|&step| plan.records(step))
    }

    /// Jacobian at tight tolerances, computed by the first call.
    fn converged(&self) -> Result<&OutcomeJacobian, GradientError> {
        if let Some(known) = self.converged.get() {
            return Ok(known);
        }
        let jacobian = self
            .motion
            .jacobian_of(self.parameters, self.outcome_and_positions)?;
        Ok(self.converged.get_or_init(|| jacobian))
    }

    /// Slopes with respect to one parameter component.
    fn slopes(&self, column: usize, width: f64) -> Result<Slopes, GradientError> {
        let value = |factor: f64| {
            let mut change = vec![0.0; self.jacobian.jacobian.ncols()];
            change[column] = factor * width;
            self.value(&self.motion, &change)
        };
        // The whole and half of the width, on each side.
        let [whole_ahead, half_ahead] = [value(1.0)?, value(0.5)?];
        let [whole_behind, half_behind] = [value(-1.0)?, value(-0.5)?];
        let side = |whole: &DVector<f64>, half: &DVector<f64>, width: f64| {
            ((half - &self.unperturbed) * 4.0 - (whole - &self.unperturbed)) / width
        };
        let one_sided = [
            side(&whole_ahead, &half_ahead, width),
            side(&whole_behind, &half_behind, -width),
        ];
        let central =
            ((half_ahead - half_behind) * 8.0 - (whole_ahead - whole_behind)) / (6.0 * width);
        let noise = self.noise.zip_map(&self.unperturbed, |noise, value| {
            NOISE_GAIN * (noise + ROUND_OFF * value.abs()) / width
        });
        Ok(Slopes {
            central,
            one_sided,
            noise,
        })
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
