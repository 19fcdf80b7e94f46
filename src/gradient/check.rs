use super::{Experiment, GradientError, Outcome, Parameter};
use crate::dynamics::ExternalForces;
use nalgebra::{DMatrix, DVector};
use std::fmt;

/// Steps that differences are taken with, in typical changes of each parameter.
const STEPS: [f64; 7] = [1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9];

/// A step lies on the plateau if its error is within this factor of the best.
const PLATEAU: f64 = 10.0;

/// How well a Jacobian agrees with central differences.
///
/// A difference over too long a step is off by the curvature (and by kinks it straddles), over too
/// short a one by rounding; a right derivative shows as a plateau between the two, where the error
/// is small whatever the step. Errors are relative to the largest entry of a column, that is, of
/// the derivatives by one parameter.
#[derive(Debug, Clone)]
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
    /// For each number of the parameters the error at the step that agrees best.
    #[must_use]
    pub fn best_by_parameter(&self) -> Vec<f64> {
        let best = |column: nalgebra::DVectorView<f64>| column.min();
        self.errors
            .column_iter()
            .map(|column| best(column.as_view()))
            .collect()
    }

    /// The largest of [`Self::best_by_parameter`].
    #[must_use]
    pub fn best(&self) -> f64 {
        self.best_by_parameter().into_iter().fold(0.0, f64::max)
    }

    /// Shortest and longest step at which one number of the parameters agrees within ten times its
    /// best.
    #[must_use]
    pub fn plateau(&self, number: usize) -> (f64, f64) {
        let column = self.errors.column(number);
        let limit = PLATEAU * column.min();
        let on_plateau = self
            .steps
            .iter()
            .zip(column.iter())
            .filter(|(_, error)| **error <= limit);
        on_plateau.fold((f64::INFINITY, 0.0), |(low, high), (&step, _)| {
            (low.min(step), high.max(step))
        })
    }
}

impl fmt::Display for DifferenceCheck {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (number, best) in self.best_by_parameter().iter().enumerate() {
            let (low, high) = self.plateau(number);
            let name = &self.numbers[number];
            write!(
                formatter,
                "{name}: {best:.1e} (steps {low:.0e} to {high:.0e})"
            )?;
            if number + 1 < self.numbers.len() {
                writeln!(formatter)?;
            }
        }
        Ok(())
    }
}

impl<F: ExternalForces> Experiment<'_, F> {
    /// Compares the Jacobian with central differences at seven step sizes.
    ///
    /// A material's number should be positive: at zero a difference reaches below it, where no
    /// material is.
    ///
    /// # Errors
    /// As [`Self::jacobian`].
    pub fn difference_check(
        &self,
        parameters: &[Parameter],
        outcome: &impl Outcome,
    ) -> Result<DifferenceCheck, GradientError> {
        let expected = self.jacobian(parameters, outcome)?.jacobian;
        let scales = self.scales(parameters);
        let mut errors = DMatrix::zeros(STEPS.len(), scales.len());
        for (row, step) in STEPS.iter().enumerate() {
            for (column, scale) in scales.iter().enumerate() {
                let mut change = vec![0.0; scales.len()];
                change[column] = step * scale;
                let difference = self.central_difference(parameters, &change, outcome)?;
                let derivative = expected.column(column) * *scale;
                let largest = derivative.amax().max(difference.amax() / step);
                let error = (difference / *step - derivative).amax();
                // A parameter without influence has no derivative, and none is right.
                errors[(row, column)] = if largest == 0.0 { 0.0 } else { error / largest };
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

    /// Half the difference of the outcomes after a change and after its opposite.
    fn central_difference(
        &self,
        parameters: &[Parameter],
        change: &[f64],
        outcome: &impl Outcome,
    ) -> Result<DVector<f64>, GradientError> {
        let opposite: Vec<f64> = change.iter().map(|number| -number).collect();
        let ahead = DVector::from_vec(self.value_beside(parameters, change, outcome)?);
        let behind = DVector::from_vec(self.value_beside(parameters, &opposite, outcome)?);
        Ok((ahead - behind) / 2.0)
    }
}
