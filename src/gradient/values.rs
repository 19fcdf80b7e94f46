use super::slots::Slots;
use super::{GradientError, Parameter};
use crate::dynamics::{Force, Model, World};
use nalgebra::DVector;
use std::collections::HashSet;

/// Values of parameters. New worlds share the shapes of this world.
impl<F: Force> World<f64, F> {
    /// Values of the parameters, concatenated in order. The value of an orientation is a rotation vector (rad, at most π long).
    ///
    /// # Errors
    /// If the world does not have one of the parameters.
    pub fn values(&self, parameters: &[Parameter]) -> Result<DVector<f64>, GradientError> {
        values(&self.model, parameters)
    }

    /// The world with new values of the parameters, in the order of [`Self::values`].
    ///
    /// Derivatives with respect to an orientation are with respect to a small rotation in world axes, not with respect to a
    /// rotation vector. An optimizer of orientations should use [`Self::perturbed`].
    ///
    /// ```
    /// # use hydroelastic::contact::Shape;
    /// # use hydroelastic::dynamics::{Body, Mass, Material, World};
    /// # use hydroelastic::gradient::Parameter;
    /// # use hydroelastic::mesh::shapes;
    /// # let ball = Shape::new(shapes::icosphere(0.1, 1)?);
    /// # let ball = Body::dynamic("ball", ball, Material::elastic(1e5), Mass::Total(1.0))?;
    /// let world = World::new(vec![ball])?;
    /// let parameters = [Parameter::initial_velocity("ball"), Parameter::modulus("ball")];
    /// assert_eq!(world.values(&parameters)?.as_slice(), [0.0, 0.0, 0.0, 1e5]);
    /// let faster = world.with_values(&parameters, &[2.0, 0.0, 0.0, 1e5])?;
    /// assert_eq!(faster.initial_state().bodies[0].velocity().x, 2.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// - If the world does not have one of the parameters.
    /// - [`GradientError::DuplicateParameter`] if a parameter is named twice.
    /// - If the number of values is wrong.
    /// - If a value is out of range.
    pub fn with_values(
        &self,
        parameters: &[Parameter],
        values: &[f64],
    ) -> Result<Self, GradientError> {
        let model = with_values(&self.model, parameters, values)?;
        Ok(self.with_model(model).with_checked_forces()?)
    }

    /// The world with a change added to each parameter component. A change of an orientation is a rotation vector (rad) in world axes that
    /// rotates the body about its origin.
    ///
    /// # Errors
    /// - If the world does not have one of the parameters.
    /// - If the number of changes is wrong.
    /// - If a number is out of range after the change.
    pub fn perturbed(
        &self,
        parameters: &[Parameter],
        changes: &[f64],
    ) -> Result<Self, GradientError> {
        let model = perturbed(&self.model, parameters, changes)?;
        Ok(self.with_model(model).with_checked_forces()?)
    }
}

/// Returns the values of the parameters.
pub(super) fn values(
    model: &Model,
    parameters: &[Parameter],
) -> Result<DVector<f64>, GradientError> {
    let slots = Slots::resolve(parameters, model)?;
    Ok(DVector::from_vec(slots.values(model)))
}

/// Returns the model with new values of the parameters. Validates the result.
pub(super) fn with_values(
    model: &Model,
    parameters: &[Parameter],
    values: &[f64],
) -> Result<Model, GradientError> {
    check_distinct(parameters)?;
    changed(model, parameters, values, Slots::with_values)
}

/// Returns the model with a change added to each parameter component. Validates the result.
pub(super) fn perturbed(
    model: &Model,
    parameters: &[Parameter],
    changes: &[f64],
) -> Result<Model, GradientError> {
    changed(model, parameters, changes, Slots::perturbed)
}

/// Returns the model that a change to its parameters makes. Validates the result.
fn changed(
    model: &Model,
    parameters: &[Parameter],
    numbers: &[f64],
    change: impl Fn(&Slots, &Model, &[f64]) -> Model,
) -> Result<Model, GradientError> {
    let slots = Slots::resolve(parameters, model)?;
    slots.check_count(numbers.len())?;
    let model = change(&slots, model, numbers);
    slots.check_radii(&model)?;
    model.check()?;
    Ok(model)
}

/// Checks that no parameter is named twice.
fn check_distinct(parameters: &[Parameter]) -> Result<(), GradientError> {
    let mut distinct = HashSet::new();
    match parameters
        .iter()
        .find(|&parameter| !distinct.insert(parameter))
    {
        None => Ok(()),
        Some(parameter) => Err(GradientError::DuplicateParameter {
            parameter: parameter.to_string(),
        }),
    }
}
