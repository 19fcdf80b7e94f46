use super::error::same_length;
use super::widths::DifferentiableOutcome;
use super::{Experiment, GradientError, Outcome, Parameter};
use nalgebra::{DMatrix, DVector, DVectorView};
use std::fmt;

/// Steps that differences are taken with, in typical changes of each parameter.
const STEPS: [f64; 7] = [1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9];

/// A derivative below this fraction of the largest in its row, or of the outcome, counts as zero. Rounding errors of the outcome,
/// divided by the longest step, are 1e-6 of this bound.
const ZERO: f64 = 1e-6;

/// A step lies on the plateau if its error is within this factor of the best.
const PLATEAU: f64 = 10.0;

/// How well a Jacobian agrees with central differences.
///
/// A difference over too long a step is off by the curvature (and by kinks it straddles), over too
/// short a one by rounding; a correct derivative shows as a plateau between the two, where the error
/// is small whatever the step. Errors are relative to the largest entry of a column, that is, of
/// the derivatives by one parameter. A column that should be zero holds only rounding errors.
/// Errors are therefore relative to at least a millionth of the largest entry of the row and of the largest number of the outcome.
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
    /// Steps, in typical changes of a parameter: its value for materials and masses, else 1 SI unit.
    pub steps: Vec<f64>,
    /// What each column is by: a parameter, and which of its numbers.
    pub numbers: Vec<String>,
    /// For each step (row) and number of the parameters (column) the relative error.
    pub errors: DMatrix<f64>,
}

impl DifferenceCheck {
    /// For each number of the parameters the error at the step that agrees best; infinite if none is
    /// finite.
    #[must_use]
    pub fn best_by_parameter(&self) -> Vec<f64> {
        self.errors.column_iter().map(least).collect()
    }

    /// The largest of [`Self::best_by_parameter`].
    #[must_use]
    pub fn best(&self) -> f64 {
        self.best_by_parameter().into_iter().fold(0.0, f64::max)
    }

    /// Shortest and longest step at which one number of the parameters agrees within ten times its
    /// best; `None` if its error is finite at no step, or if there is no such number.
    #[must_use]
    pub fn plateau(&self, number: usize) -> Option<(f64, f64)> {
        let column = self.errors.column_iter().nth(number)?;
        let limit = (PLATEAU * least(column)).min(f64::MAX);
        let steps = self.steps.iter().zip(column.iter());
        let on_plateau = steps.filter(|(_, error)| **error <= limit);
        on_plateau
            .map(|(&step, _)| (step, step))
            .reduce(|(low, high), (step, _)| (low.min(step), high.max(step)))
    }
}

/// The smallest number of a column, infinite if there is none: `min` passes over those that are not
/// numbers.
fn least(column: DVectorView<f64>) -> f64 {
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
    /// Derivatives that are not finite, which [`Self::jacobian`] refuses, are infinite errors here, so
    /// that the others can be compared.
    ///
    /// A material's number should be positive: at zero a difference reaches below it, where no
    /// material is.
    ///
    /// # Errors
    /// As [`Self::jacobian`], except that derivatives that are not finite are no error; also if a rollout beside the
    /// parameters ends early.
    pub fn difference_check(
        &self,
        parameters: &[Parameter],
        outcome: &impl Outcome,
    ) -> Result<DifferenceCheck, GradientError> {
        self.difference_check_of(parameters, outcome)
    }

    /// Not generic, so that it is compiled in this library.
    fn difference_check_of(
        &self,
        parameters: &[Parameter],
        outcome: &dyn DifferentiableOutcome,
    ) -> Result<DifferenceCheck, GradientError> {
        let (expected, _) = self.differentiated(parameters, outcome)?;
        let scales = self.scales(parameters)?;
        let has_value = are_finite(&expected.value);
        let mut derivatives = expected.jacobian;
        for (mut column, scale) in derivatives.column_iter_mut().zip(&scales) {
            column *= *scale;
        }
        let largest_value = expected.value.amax();
        let of_row = |row: usize| ZERO * derivatives.row(row).amax().max(largest_value);
        let least = DVector::from_fn(derivatives.nrows(), |row, _| of_row(row));
        let mut errors = DMatrix::zeros(STEPS.len(), scales.len());
        for (row, step) in STEPS.iter().enumerate() {
            for (column, scale) in scales.iter().enumerate() {
                let mut change = vec![0.0; scales.len()];
                change[column] = step * scale;
                let [ahead, behind] = self.values_beside(parameters, &change, outcome)?;
                same_length([&expected.value, &ahead, &behind])?;
                let difference = (ahead - behind) / 2.0 / *step;
                errors[(row, column)] = if has_value {
                    let derivative = derivatives.column(column).into_owned();
                    relative_error(&derivative, &difference, &least)
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

    /// The outcomes after a change and after its opposite.
    fn values_beside(
        &self,
        parameters: &[Parameter],
        change: &[f64],
        outcome: &dyn DifferentiableOutcome,
    ) -> Result<[DVector<f64>; 2], GradientError> {
        let opposite: Vec<f64> = change.iter().map(|number| -number).collect();
        let ahead = DVector::from_vec(self.value_beside(parameters, change, outcome)?);
        let behind = DVector::from_vec(self.value_beside(parameters, &opposite, outcome)?);
        Ok([ahead, behind])
    }
}

/// The largest difference of two columns, relative to the largest number in them, or to the scale of the row in `least` if that is
/// larger. Infinite if a number is not finite.
fn relative_error(
    derivative: &DVector<f64>,
    difference: &DVector<f64>,
    least: &DVector<f64>,
) -> f64 {
    // `amax` passes over what is not a number.
    if !are_finite(derivative) || !are_finite(difference) {
        return f64::INFINITY;
    }
    let largest = derivative.amax().max(difference.amax());
    let errors = (difference - derivative).zip_map(least, |error, least| {
        if error == 0.0 {
            0.0
        } else {
            error.abs() / largest.max(least)
        }
    });
    errors.amax()
}

fn are_finite(numbers: &DVector<f64>) -> bool {
    numbers.iter().all(|number| number.is_finite())
}
