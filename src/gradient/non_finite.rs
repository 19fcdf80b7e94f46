use super::outcome::numbers;
use super::{GradientError, OutcomeJacobian, Parameter};
use crate::dynamics::{Model, State};
use crate::scalar::DenseDual;
use nalgebra::DMatrix;

/// The first derivative that is not finite.
pub(super) struct NonFinite {
    location: Location,
    /// Index of the parameter component of the derivative.
    column: usize,
}

/// Quantity that the derivative belongs to.
enum Location {
    /// The state of a body after a step.
    State { step: usize, time: f64, body: usize },
    /// An outcome component. The derivatives of all states are finite.
    Outcome { row: usize },
}

impl NonFinite {
    /// Finds the first derivative of an outcome that is not finite.
    pub(super) fn in_outcome(jacobian: &DMatrix<f64>) -> Option<Self> {
        let mut columns = jacobian.column_iter().enumerate();
        columns.find_map(|(column, derivatives)| {
            let row = derivatives.iter().position(|number| !number.is_finite())?;
            let location = Location::Outcome { row };
            Some(Self { location, column })
        })
    }

    /// Finds the first derivative of a state that is not finite, in some of the seeded columns.
    pub(super) fn in_state<const WIDTH: usize>(
        step: usize,
        state: &State<DenseDual<WIDTH>>,
        columns: &[usize],
    ) -> Option<Self> {
        let is_non_finite = |body: usize, column: usize| {
            numbers(state, body).any(|number| !number.eps[column].is_finite())
        };
        columns.iter().find_map(|&column| {
            let body = (0..state.bodies.len()).find(|&body| is_non_finite(body, column))?;
            let time = state.time;
            let location = Location::State { step, time, body };
            Some(Self { location, column })
        })
    }

    /// Adds an offset to the index of the parameter's number.
    pub(super) fn with_column_offset(self, offset: usize) -> Self {
        let column = self.column + offset;
        Self { column, ..self }
    }

    /// Step after which the derivative is not finite, or `usize::MAX` for the outcome, which is
    /// evaluated after all steps.
    pub(super) fn step(&self) -> usize {
        match self.location {
            Location::State { step, .. } => step,
            Location::Outcome { .. } => usize::MAX,
        }
    }

    /// Converts to an error that also holds all computed derivatives.
    pub(super) fn into_error(
        self,
        model: &Model,
        parameters: &[Parameter],
        jacobian: OutcomeJacobian,
    ) -> GradientError {
        let mut names = parameters.iter().flat_map(Parameter::number_names);
        let number = names.nth(self.column).unwrap_or_default();
        let found = Box::new(jacobian);
        match self.location {
            Location::State { step, time, body } => GradientError::StateDerivativeNotFinite {
                step,
                time,
                body: model.bodies[body].name().to_owned(),
                number,
                found,
            },
            Location::Outcome { row } => {
                GradientError::OutcomeDerivativeNotFinite { row, number, found }
            }
        }
    }
}

/// Columns in which a number is not finite.
pub(super) fn columns_not_finite(jacobian: &DMatrix<f64>) -> Vec<usize> {
    let is_finite = |column: usize| jacobian.column(column).iter().all(|x| x.is_finite());
    let columns = 0..jacobian.ncols();
    columns.filter(|&column| !is_finite(column)).collect()
}
