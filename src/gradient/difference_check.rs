use super::dual_widths::DifferentiableOutcome;
use super::error::same_length;
use super::{Experiment, GradientError, Outcome, Parameter};
use nalgebra::{DMatrix, DVector, DVectorView};
use std::fmt;

/// Steps of the differences, in typical changes of each parameter.
const STEPS: [f64; 7] = [1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9];

/// A derivative below this fraction of the largest in its row, or of the outcome, counts as zero. Rounding errors of the outcome,
/// divided by the longest step, are 1e-6 of this bound.
const ZERO: f64 = 1e-6;

/// A step lies on the plateau if its error is within this factor of the smallest error.
const PLATEAU: f64 = 10.0;

/// Relative errors of a Jacobian compared with central differences at several step sizes.
///
/// The error of a difference over a long step comes from curvature and from kinks within the step. Over a short step it comes
/// from rounding. The error of a correct derivative has a plateau between the two, where it is small for all steps.
///
/// Errors are relative to the largest entry of a column, that is, of the derivatives with respect to one parameter component. A column that
/// should be zero holds only rounding errors. The scale of errors is therefore at least a millionth of the largest entry of the row, and at
/// least a millionth of the largest outcome component.
///
/// If a derivative or the outcome is not finite, the errors at all steps are infinite. If a difference is not finite, the error at its
/// step is infinite.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(
        try_from = "super::serial::CheckLayout",
        into = "super::serial::CheckLayout"
    )
)]
#[non_exhaustive]
pub struct DifferenceCheck {
    /// Steps, in typical changes of a parameter. The typical change is the value for materials, masses and force parameters, and 1
    /// SI unit otherwise.
    pub steps: Vec<f64>,
    /// Name of the parameter component of each column: the parameter, followed by the component if there are several.
    pub numbers: Vec<String>,
    /// Relative error for each step size (row) and each parameter component (column).
    pub errors: DMatrix<f64>,
}

impl DifferenceCheck {
    /// Smallest error over all step sizes, for each parameter component. Infinite if no error is finite.
    #[must_use]
    pub fn best_by_parameter(&self) -> Vec<f64> {
        self.errors.column_iter().map(smallest).collect()
    }

    /// The largest of [`Self::best_by_parameter`].
    #[must_use]
    pub fn best(&self) -> f64 {
        self.best_by_parameter().into_iter().fold(0.0, f64::max)
    }

    /// Shortest and longest step at which the error of a number is at most ten times its smallest error. `None` if no error is
    /// finite, or if the index is out of range.
    #[must_use]
    pub fn plateau(&self, number: usize) -> Option<(f64, f64)> {
        let column = self.errors.column_iter().nth(number)?;
        let limit = (PLATEAU * smallest(column)).min(f64::MAX);
        let steps = self.steps.iter().zip(column.iter());
        let on_plateau = steps.filter(|(_, error)| **error <= limit);
        on_plateau
            .map(|(&step, _)| (step, step))
            .reduce(|(low, high), (step, _)| (low.min(step), high.max(step)))
    }
}

/// Smallest number of a column, ignoring NaN. Infinite if the column is empty or all NaN.
fn smallest(column: DVectorView<f64>) -> f64 {
    column.iter().copied().fold(f64::INFINITY, f64::min)
}

impl fmt::Display for DifferenceCheck {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (number, best) in self.best_by_parameter().iter().enumerate() {
            write!(formatter, "{}: {best:.1e} ", self.numbers[number])?;
            match self.plateau(number) {
                Some((low, high)) => write!(formatter, "(steps {low:.0e} to {high:.0e})")?,
                None => write!(formatter, "(finite at no step)")?,
            }
            if number + 1 < self.numbers.len() {
                writeln!(formatter)?;
            }
        }
        Ok(())
    }
}

impl Experiment {
    /// Compares the Jacobian with central differences at seven step sizes.
    ///
    /// [`Self::jacobian`] returns an error for a derivative that is not finite. This check reports an infinite error for it instead,
    /// and compares the other derivatives.
    ///
    /// Parameters of materials should be positive, because a central difference at zero evaluates a negative value.
    ///
    /// # Errors
    /// - As [`Self::jacobian`], except for derivatives that are not finite.
    /// - If a rollout at perturbed parameters ends early.
    pub fn difference_check(
        &self,
        parameters: &[Parameter],
        outcome: &impl Outcome,
    ) -> Result<DifferenceCheck, GradientError> {
        self.difference_check_of(parameters, outcome)
    }

    /// [`Self::difference_check`], but not generic, so that it is compiled in this library.
    fn difference_check_of(
        &self,
        parameters: &[Parameter],
        outcome: &dyn DifferentiableOutcome,
    ) -> Result<DifferenceCheck, GradientError> {
        let (expected, _) = self.jacobian_unchecked(parameters, outcome)?;
        let scales = self.scales(parameters)?;
        let has_value = are_finite(&expected.value);
        let mut derivatives = expected.jacobian;
        for (mut column, scale) in derivatives.column_iter_mut().zip(&scales) {
            column *= *scale;
        }
        let largest_value = expected.value.amax();
        let row_scale = |row: usize| ZERO * derivatives.row(row).amax().max(largest_value);
        let smallest_scales = DVector::from_fn(derivatives.nrows(), |row, _| row_scale(row));
        let mut errors = DMatrix::zeros(STEPS.len(), scales.len());
        for (row, step) in STEPS.iter().enumerate() {
            for (column, scale) in scales.iter().enumerate() {
                let mut change = vec![0.0; scales.len()];
                change[column] = step * scale;
                let [ahead, behind] = self.values_on_both_sides(parameters, &change, outcome)?;
                same_length([&expected.value, &ahead, &behind])?;
                let difference = (ahead - behind) / 2.0 / *step;
                errors[(row, column)] = if has_value {
                    let derivative = derivatives.column(column).into_owned();
                    relative_error(&derivative, &difference, &smallest_scales)
                } else {
                    f64::INFINITY
                };
            }
        }
        Ok(DifferenceCheck {
            steps: STEPS.to_vec(),
            numbers: parameters
                .iter()
                .flat_map(Parameter::number_names)
                .collect(),
            errors,
        })
    }

    /// Outcomes after a change and after the opposite change.
    fn values_on_both_sides(
        &self,
        parameters: &[Parameter],
        change: &[f64],
        outcome: &dyn DifferentiableOutcome,
    ) -> Result<[DVector<f64>; 2], GradientError> {
        let opposite: Vec<f64> = change.iter().map(|number| -number).collect();
        let ahead = DVector::from_vec(self.value_perturbed_unchecked(parameters, change, outcome)?);
        let behind =
            DVector::from_vec(self.value_perturbed_unchecked(parameters, &opposite, outcome)?);
        Ok([ahead, behind])
    }
}

/// Largest difference of two columns, relative to the largest number in them, or to the smallest scale of the row if it is larger.
/// Infinite if a number is not finite.
fn relative_error(
    derivative: &DVector<f64>,
    difference: &DVector<f64>,
    smallest_scales: &DVector<f64>,
) -> f64 {
    // `amax` ignores NaN.
    if !are_finite(derivative) || !are_finite(difference) {
        return f64::INFINITY;
    }
    let largest = derivative.amax().max(difference.amax());
    let errors = (difference - derivative).zip_map(smallest_scales, |error, smallest_scale| {
        if error == 0.0 {
            0.0
        } else {
            error.abs() / largest.max(smallest_scale)
        }
    });
    errors.amax()
}

fn are_finite(numbers: &DVector<f64>) -> bool {
    numbers.iter().all(|number| number.is_finite())
}
