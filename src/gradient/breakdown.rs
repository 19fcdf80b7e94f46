use super::outcome::numbers;
use super::{GradientError, OutcomeJacobian, Parameter};
use crate::dynamics::{Model, State};
use crate::scalar::DenseDual;
use nalgebra::DMatrix;

/// The first derivative that is not finite.
pub(super) struct Breakdown {
    place: Place,
    /// Which number of the parameters the derivative is by.
    column: usize,
}

/// What the derivative is of.
enum Place {
    /// The state of a body after a step.
    State { step: usize, time: f64, body: usize },
    /// A number of the outcome, all states before it having finite derivatives.
    Outcome { row: usize },
}

impl Breakdown {
    /// In an outcome's derivatives; the first of them.
    pub(super) fn in_outcome(jacobian: &DMatrix<f64>) -> Option<Self> {
        let mut columns = jacobian.column_iter().enumerate();
        columns.find_map(|(column, derivatives)| {
            let row = derivatives.iter().position(|number| !number.is_finite())?;
            let place = Place::Outcome { row };
            Some(Self { place, column })
        })
    }

    /// In a state's derivatives by some of the numbers that were seeded.
    pub(super) fn in_state<const WIDTH: usize>(
        step: usize,
        state: &State<DenseDual<WIDTH>>,
        columns: &[usize],
    ) -> Option<Self> {
        let lacks = |body: usize, column: usize| {
            numbers(state, body).any(|number| !number.eps[column].is_finite())
        };
        columns.iter().find_map(|&column| {
            let body = (0..state.bodies.len()).find(|&body| lacks(body, column))?;
            let time = state.time;
            let place = Place::State { step, time, body };
            Some(Self { place, column })
        })
    }

    /// The same by a number so many places later among those of the parameters.
    pub(super) fn by_later_number(self, offset: usize) -> Self {
        let column = self.column + offset;
        Self { column, ..self }
    }

    /// The step that led to it; the outcome comes after all steps.
    pub(super) fn step(&self) -> usize {
        match self.place {
            Place::State { step, .. } => step,
            Place::Outcome { .. } => usize::MAX,
        }
    }

    /// As an error, beside all that was found.
    pub(super) fn into_error(
        self,
        system: &Model,
        parameters: &[Parameter],
        found: OutcomeJacobian,
    ) -> GradientError {
        let mut names = parameters.iter().flat_map(Parameter::number_names);
        let number = names.nth(self.column).unwrap_or_default();
        let found = Box::new(found);
        match self.place {
            Place::State { step, time, body } => GradientError::StateDerivativeNotFinite {
                step,
                time,
                body: system.bodies[body].name().to_owned(),
                number,
                found,
            },
            Place::Outcome { row } => {
                GradientError::OutcomeDerivativeNotFinite { row, number, found }
            }
        }
    }
}

/// The columns in which a number is not finite.
pub(super) fn columns_not_finite(jacobian: &DMatrix<f64>) -> Vec<usize> {
    let is_finite = |column: usize| jacobian.column(column).iter().all(|x| x.is_finite());
    let columns = 0..jacobian.ncols();
    columns.filter(|&column| !is_finite(column)).collect()
}
