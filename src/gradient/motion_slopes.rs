//! Comparison of the derivatives of an experiment with the slopes of the motion.

use super::dual_widths::{DifferentiableOutcome, OutcomeIn};
use super::error::check_outcome;
use super::{CheckedDerivative, Experiment, GradientError, OutcomeJacobian, Parameter, Verdict};
use crate::dynamics::{RolloutError, State, Trajectory};
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

/// Largest change of a parameter component over which slopes are computed, in typical changes.
const LARGEST_WIDTH: f64 = 1e-2;

/// Number of times that the largest change is halved. The smallest change of a rollout is 8e-5 typical changes. Structure of the outcome
/// below this change is not detected.
const HALVINGS: usize = 7;

/// Change of all parameters over which the noise of outcomes is measured, in typical changes.
const NOISE_WIDTH: f64 = 1e-3;

/// Returns the width with this index, in typical changes.
fn width(level: usize) -> f64 {
    LARGEST_WIDTH / (1_u64 << level) as f64
}

/// Comparison of the derivatives of an experiment with the motion.
pub(super) struct MotionCheck<'a> {
    experiment: &'a Experiment,
    /// The experiment at tight tolerances.
    motion: Experiment,
    parameters: &'a [Parameter],
    /// Typical change of each parameter component.
    scales: Vec<f64>,
    outcome_and_positions: &'a WithPositions<'a>,
    /// The Jacobian of the plan.
    jacobian: OutcomeJacobian,
    /// The outcome at tight tolerances, with unchanged parameters.
    unperturbed: DVector<f64>,
    /// Noise of each outcome component: the difference of the errors at tight tolerances between changed and unchanged parameters.
    noise: DVector<f64>,
    /// The Jacobian at tight tolerances, computed on demand.
    converged: OnceCell<OutcomeJacobian>,
}

/// Slopes of the motion with respect to one parameter component, for each outcome component.
struct Slopes {
    /// Change of the parameter component on either side (unit of the component).
    width: f64,
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
    ) -> Result<Self, GradientError> {
        let jacobian = experiment.jacobian_of(parameters, outcome_and_positions)?;
        let motion = experiment.with_plan(experiment.plan().converged());
        let zeros = DVector::zeros(jacobian.jacobian.nrows());
        let mut check = Self {
            experiment,
            motion,
            parameters,
            scales: experiment.scales(parameters)?,
            outcome_and_positions,
            jacobian,
            unperturbed: zeros.clone(),
            noise: zeros,
            converged: OnceCell::new(),
        };
        let unchanged = vec![0.0; check.scales.len()];
        check.unperturbed = check.value(&check.motion, &unchanged)?;
        check.noise = check.measured_noise()?;
        Ok(check)
    }

    /// Estimates the noise of the outcome from one rollout with all parameters changed, and from two rollouts at even tighter tolerances.
    fn measured_noise(&self) -> Result<DVector<f64>, GradientError> {
        let finer = self.motion.with_plan(self.motion.plan().finer());
        let unchanged = vec![0.0; self.scales.len()];
        let changed = self.scales.iter().map(|scale| NOISE_WIDTH * scale);
        let changed: Vec<_> = changed.collect();
        let error = &self.unperturbed - self.value(&finer, &unchanged)?;
        let outcomes = [&self.motion, &finer].map(|motion| self.value(motion, &changed));
        // If a rollout at changed parameters fails, the error at unchanged parameters is used. It usually overestimates the noise.
        Ok(match outcomes {
            [Ok(tight), Ok(finer)] => (tight - finer - error).abs(),
            _ => error.abs(),
        })
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

    /// Compares the derivatives with respect to one parameter component with the slopes.
    pub fn checked(
        &self,
        number: String,
        column: usize,
    ) -> Result<CheckedDerivative, GradientError> {
        let levels = self.slopes(column)?;
        let (verdict, slopes) = self.verdict(column, &levels)?;
        let column_derivative = self.jacobian.jacobian.column(column);
        let outcome = self.outcome();
        let [derivative, slope] =
            [column_derivative, slopes.central.column(0)].map(|all| rows(&all, &outcome));
        let (difference, noise) = ((&derivative - &slope).amax(), slopes.noise_in(&outcome));
        let largest = derivative.amax().max(slope.amax());
        let first_mismatch = match verdict {
            Verdict::Right | Verdict::Noisy => None,
            Verdict::Kink | Verdict::Unresolved | Verdict::Chaotic => {
                self.first_mismatch(&column_derivative, slopes, outcome.end)
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
            width: slopes.width,
            first_mismatch,
        })
    }

    /// Returns the verdict, and the widest slopes that support it.
    fn verdict<'s>(
        &self,
        column: usize,
        levels: &'s [Slopes],
    ) -> Result<(Verdict, &'s Slopes), GradientError> {
        if let Some(slopes) = self.widest_agreeing(&self.jacobian, column, levels, Slopes::central)
        {
            let is_known = self.is_known(column, slopes);
            let verdict = if is_known {
                Verdict::Right
            } else {
                Verdict::Noisy
            };
            return Ok((verdict, slopes));
        }
        let converged = self.converged()?;
        if let Some(slopes) = self.widest_agreeing(converged, column, levels, Slopes::central) {
            return Ok((Verdict::Unresolved, slopes));
        }
        for jacobian in [&self.jacobian, converged] {
            for side in [Slopes::forward, Slopes::backward] {
                if let Some(slopes) = self.widest_agreeing(jacobian, column, levels, side) {
                    return Ok((Verdict::Kink, slopes));
                }
            }
        }
        Ok((Verdict::Chaotic, &levels[levels.len() - 1]))
    }

    /// Returns the slopes over the largest width such that the derivative agrees with these slopes and with the slopes over the next width.
    fn widest_agreeing<'s>(
        &self,
        jacobian: &OutcomeJacobian,
        column: usize,
        levels: &'s [Slopes],
        slope: impl Fn(&Slopes) -> &DVector<f64>,
    ) -> Option<&'s Slopes> {
        let derivative = jacobian.jacobian.column(column);
        let agrees = |slopes: &Slopes| slopes.agree(&derivative, slope(slopes), &self.outcome());
        if let [single] = levels {
            return agrees(single).then_some(single);
        }
        let mut pairs = levels.windows(2);
        pairs
            .find(|pair| pair.iter().all(agrees))
            .map(|pair| &pair[0])
    }

    /// Whether the noise of slopes is at most 3 % of the slope or of the derivative of the plan.
    fn is_known(&self, column: usize, slopes: &Slopes) -> bool {
        let outcome = self.outcome();
        let derivative = self.jacobian.jacobian.column(column);
        let (slope, value) = (slopes.central.column(0), self.unperturbed.column(0));
        let [derivative, slope, value] =
            [&derivative, &slope, &value].map(|all| rows(all, &outcome).amax());
        let largest = derivative.max(slope);
        let scale = largest.max(NEGLIGIBLE_SLOPE * value / self.scales[column]);
        largest == 0.0 || slopes.noise_in(&outcome) <= AGREEMENT * scale
    }

    /// Row range of the outcome. The rows of the positions come after it.
    fn outcome(&self) -> Range<usize> {
        0..self.jacobian.jacobian.nrows() - self.position_count()
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

    /// Returns the slopes with respect to one parameter component over decreasing widths, at least one. The widths end when the derivative
    /// of the plan agrees with two successive slopes, or when the noise is too large.
    fn slopes(&self, column: usize) -> Result<Vec<Slopes>, GradientError> {
        let mut levels: Vec<Slopes> = Vec::new();
        let mut last_error = None;
        let mut full_outcomes = self.both_sides(column, 0);
        for level in 0..HALVINGS {
            let half_outcomes = self.both_sides(column, level + 1);
            let slopes = match (&full_outcomes, &half_outcomes) {
                (Ok(full), Ok(half)) => self.slopes_over((column, level), full, half),
                (Err(error), _) | (_, Err(error)) => {
                    if !is_avoidable(error) {
                        return Err(error.clone());
                    }
                    last_error = Some(error.clone());
                    full_outcomes = half_outcomes;
                    continue;
                }
            };
            full_outcomes = half_outcomes;
            let is_known = self.is_known(column, &slopes);
            if is_known || levels.is_empty() {
                levels.push(slopes);
            }
            let last_two = &levels[levels.len().saturating_sub(2)..];
            let is_right = last_two.len() == 2
                && self
                    .widest_agreeing(&self.jacobian, column, last_two, Slopes::central)
                    .is_some();
            if is_right || !is_known {
                break;
            }
        }
        match last_error {
            Some(error) if levels.is_empty() => Err(error),
            _ => Ok(levels),
        }
    }

    /// Outcomes after a change of one parameter component by the width with this index, and after the opposite change.
    fn both_sides(&self, column: usize, level: usize) -> Result<[DVector<f64>; 2], GradientError> {
        let value = |sign: f64| {
            let mut change = vec![0.0; self.scales.len()];
            change[column] = sign * width(level) * self.scales[column];
            self.value(&self.motion, &change)
        };
        Ok([value(1.0)?, value(-1.0)?])
    }

    /// Returns the slopes over the width with this index, from the outcomes on both sides after the whole and half of the change.
    fn slopes_over(
        &self,
        (column, level): (usize, usize),
        [whole_ahead, whole_behind]: &[DVector<f64>; 2],
        [half_ahead, half_behind]: &[DVector<f64>; 2],
    ) -> Slopes {
        let width = width(level) * self.scales[column];
        let side = |whole: &DVector<f64>, half: &DVector<f64>, width: f64| {
            ((half - &self.unperturbed) * 4.0 - (whole - &self.unperturbed)) / width
        };
        let one_sided = [
            side(whole_ahead, half_ahead, width),
            side(whole_behind, half_behind, -width),
        ];
        let central =
            ((half_ahead - half_behind) * 8.0 - (whole_ahead - whole_behind)) / (6.0 * width);
        let noise = self.noise.zip_map(&self.unperturbed, |noise, value| {
            NOISE_GAIN * (noise + ROUND_OFF * value.abs()) / width
        });
        Slopes {
            width,
            central,
            one_sided,
            noise,
        }
    }
}

/// Whether smaller changes of the parameters can avoid this error.
fn is_avoidable(error: &GradientError) -> bool {
    match error {
        GradientError::Rollout(error) => !matches!(error, RolloutError::Stopped),
        GradientError::World(_) | GradientError::OutcomeNotFinite { .. } => true,
        _ => false,
    }
}

impl Slopes {
    fn central(&self) -> &DVector<f64> {
        &self.central
    }

    fn forward(&self) -> &DVector<f64> {
        &self.one_sided[0]
    }

    fn backward(&self) -> &DVector<f64> {
        &self.one_sided[1]
    }

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
