//! The traits of argmin.

use super::error::loss_of;
use super::{Outcome, Problem};
use argmin::core::{CostFunction, Error, Gradient, Jacobian, Operator};

/// The loss.
impl<O: Outcome> CostFunction for Problem<O> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, values: &Vec<f64>) -> Result<f64, Error> {
        Ok(loss_of(&self.value(values)?)?)
    }
}

/// The gradient of the loss.
impl<O: Outcome> Gradient for Problem<O> {
    type Param = Vec<f64>;
    type Gradient = Vec<f64>;

    fn gradient(&self, values: &Vec<f64>) -> Result<Vec<f64>, Error> {
        let (_, gradient) = Self::gradient(self, values)?;
        Ok(gradient.as_slice().to_vec())
    }
}

/// The residuals.
impl<O: Outcome> Operator for Problem<O> {
    type Param = Vec<f64>;
    type Output = Vec<f64>;

    fn apply(&self, values: &Vec<f64>) -> Result<Vec<f64>, Error> {
        Ok(self.value(values)?)
    }
}

/// The Jacobian of the residuals, by rows.
impl<O: Outcome> Jacobian for Problem<O> {
    type Param = Vec<f64>;
    type Jacobian = Vec<Vec<f64>>;

    fn jacobian(&self, values: &Vec<f64>) -> Result<Vec<Vec<f64>>, Error> {
        let jacobian = Self::jacobian(self, values)?.jacobian;
        let rows = jacobian.row_iter().map(|row| row.iter().copied().collect());
        Ok(rows.collect())
    }
}
