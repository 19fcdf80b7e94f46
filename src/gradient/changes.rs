use super::{GradientError, Parameter};
use crate::dynamics::{Force, System, World};
use crate::scalar::Scalar;

impl<F: Force> World<f64, F> {
    /// The world after changes of the parameters, one number for each number of theirs: what an
    /// optimizer's step makes of it. Shapes are shared, not built again.
    ///
    /// # Errors
    /// If a parameter is not one of the world's, or the count of changes is not that of its numbers,
    /// or a number is out of its range after the change.
    pub fn changed(
        &self,
        parameters: &[Parameter],
        changes: &[f64],
    ) -> Result<Self, GradientError> {
        let world = self.with_system(changed_within_range(&self.system, parameters, changes)?);
        world.check_forces()?;
        Ok(world)
    }
}

/// Number of numbers in the parameters, if the system has them.
pub(super) fn checked_dimension(
    system: &System,
    parameters: &[Parameter],
) -> Result<usize, GradientError> {
    parameters
        .iter()
        .try_for_each(|parameter| parameter.check(system))?;
    Ok(parameters.iter().map(Parameter::dimension).sum())
}

/// The system after changes of the parameters, all checked.
pub(super) fn changed_within_range(
    system: &System,
    parameters: &[Parameter],
    changes: &[f64],
) -> Result<System, GradientError> {
    let (found, expected) = (changes.len(), checked_dimension(system, parameters)?);
    if found != expected {
        return Err(GradientError::ChangeCount { found, expected });
    }
    let system = changed(system, parameters, changes);
    system.check()?;
    Ok(system)
}

/// The system after changes of the parameters, which it has.
pub(super) fn changed<T: Scalar>(
    system: &System,
    parameters: &[Parameter],
    changes: &[T],
) -> System<T> {
    let mut system = system.lifted();
    let mut rest = changes;
    for parameter in parameters {
        let (own, others) = rest.split_at(parameter.dimension());
        parameter.change(&mut system, own);
        rest = others;
    }
    system
}

/// Checks that all pairs of a system have a law that can be differentiated by the parameters together.
pub(super) fn check_together(
    parameters: &[Parameter],
    system: &System,
) -> Result<(), GradientError> {
    let without_friction = |index: &usize| {
        let name = system.bodies[*index].name();
        let is_parameter = parameters.contains(&Parameter::Friction(name.into()));
        let friction = system.bodies[*index].material.friction;
        is_parameter && friction.is_some_and(|friction| friction <= 0.0)
    };
    let bodies: Vec<usize> = (0..system.bodies.len()).filter(without_friction).collect();
    for (place, &i) in bodies.iter().enumerate() {
        let mut others = bodies[place + 1..].iter();
        if let Some(&j) = others.find(|&&j| system.contact_order(i, j).is_some()) {
            let bodies = [i, j].map(|index| system.bodies[index].name().to_owned());
            return Err(GradientError::NoFriction { bodies });
        }
    }
    Ok(())
}
