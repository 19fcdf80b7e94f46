use super::slots::Slots;
use super::{GradientError, Parameter};
use crate::contact::ShapeGradient;
use crate::dynamics::{Inertia, KinkSummary, Model, ModelGradient};
use crate::spatial::MassGradient;
use nalgebra::Vector3;
use std::fmt;

/// Derivatives of a loss with respect to all inputs of a rollout. [`Experiment::full_gradient`](super::Experiment::full_gradient)
/// returns it.
#[derive(Clone)]
pub struct RolloutGradient {
    /// Value of the loss.
    pub value: f64,
    pub(super) model: Model,
    pub(super) gradient: ModelGradient,
    /// Whether the world has forces other than contact, gravity and controls. These forces may depend on the centers of mass.
    pub(super) has_forces: bool,
}

/// Mass properties of a dynamic body that are held fixed as its vertices move. The other mass
/// properties change as for a solid of uniform density.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum HoldFixed {
    /// Holds mass, center of mass and inertia fixed. Vertices affect only the contact, and the density need not be uniform.
    MassProperties,
    /// Holds the mass fixed. Center of mass and inertia follow from the new shape.
    Mass,
    /// Holds the density fixed. Mass, center of mass and inertia follow from the new shape.
    Density,
}

impl RolloutGradient {
    /// Derivatives with respect to the numbers of a parameter, in their order (unit of the loss per
    /// unit of the parameter).
    ///
    /// # Errors
    /// If the world does not have the parameter.
    pub fn by(&self, parameter: &Parameter) -> Result<Vec<f64>, GradientError> {
        let slots = Slots::resolve(std::slice::from_ref(parameter), &self.model)?;
        Ok(slots.gradient(&self.model, &self.gradient))
    }

    /// Nonsmooth points of the rollout, where the gradient is one of several possible derivatives: see
    /// [`Experiment::kinks`](super::Experiment::kinks).
    #[must_use]
    pub fn kinks(&self) -> Vec<KinkSummary> {
        self.gradient.kinks()
    }

    /// Derivatives with respect to the shape of the named body: through contact, and through the mass properties that are not held
    /// fixed. For fixed and kinematic bodies, use [`HoldFixed::MassProperties`], because their mass has no effect.
    ///
    /// # Errors
    /// - If the world has no body of this name.
    /// - As [`Self::by_mass_properties`], except with [`HoldFixed::MassProperties`].
    /// - [`GradientError::NotUniform`] if the mass properties are not the mass properties of the
    ///   shape at a uniform density, except with [`HoldFixed::MassProperties`].
    pub fn by_shape(
        &self,
        body: &str,
        hold_fixed: HoldFixed,
    ) -> Result<ShapeGradient, GradientError> {
        let mut gradient = self.gradient.shapes[self.model.index_of(body)?].clone();
        let through_mass = match hold_fixed {
            HoldFixed::MassProperties => return Ok(gradient),
            HoldFixed::Mass => self.by_vertices_through_mass(body, false)?,
            HoldFixed::Density => self.by_vertices_through_mass(body, true)?,
        };
        for (by_vertex, through_mass) in gradient.by_vertices.iter_mut().zip(through_mass) {
            *by_vertex += through_mass;
        }
        Ok(gradient)
    }

    /// Derivatives with respect to the mass properties of the named body, for a fixed shape.
    ///
    /// # Errors
    /// - If the world has no body of this name.
    /// - [`GradientError::NotDynamic`] if the body is fixed or kinematic.
    /// - [`GradientError::Massless`] if the body is massless.
    /// - [`GradientError::ForcesByCenter`] if the world has forces other than contact, gravity and controls, because these forces may
    ///   depend on the center of mass in an unknown way.
    pub fn by_mass_properties(&self, body: &str) -> Result<MassGradient, GradientError> {
        let (index, inertia) = self.dynamic(body)?;
        if inertia.mass <= 0.0 {
            return Err(GradientError::Massless(body.to_owned()));
        }
        if self.has_forces {
            return Err(GradientError::ForcesByCenter(body.to_owned()));
        }
        let by_body = &self.gradient.bodies[index];
        // `by_body.inertia` is the derivative with respect to the inertia per mass.
        let by_inertia = by_body.inertia / inertia.mass;
        Ok(MassGradient {
            by_mass: by_body.mass - by_inertia.dot(&inertia.per_mass()),
            by_center_of_mass: by_body.center,
            by_inertia,
        })
    }

    /// Index and inertia of the named dynamic body.
    fn dynamic(&self, body: &str) -> Result<(usize, &Inertia), GradientError> {
        let index = self.model.index_of(body)?;
        match self.model.bodies[index].inertia() {
            Some(inertia) => Ok((index, inertia)),
            None => Err(GradientError::NotDynamic {
                body: body.to_owned(),
                parameter: "the mass".to_owned(),
            }),
        }
    }

    /// Derivatives with respect to the vertices of the named body, through its mass properties, at fixed density or at fixed mass.
    fn by_vertices_through_mass(
        &self,
        body: &str,
        is_density_fixed: bool,
    ) -> Result<Vec<Vector3<f64>>, GradientError> {
        let by = self.by_mass_properties(body)?;
        let (index, inertia) = self.dynamic(body)?;
        let body = &self.model.bodies[index];
        if !body.is_uniform() {
            return Err(GradientError::NotUniform(body.name().to_owned()));
        }
        let by_mass = if is_density_fixed {
            by.by_mass
        } else {
            // At fixed mass, the inertia is the inertia at the current density, divided by the relative change of mass at that
            // density. This division gives the derivative with respect to the mass.
            -by.by_inertia.dot(&inertia.per_mass())
        };
        let (shape, by) = (body.shape(), MassGradient { by_mass, ..by });
        Ok(shape.mass_gradient(inertia.mass / shape.volume(), &by)?)
    }
}

impl fmt::Debug for RolloutGradient {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter
            .debug_struct("RolloutGradient")
            .field("value", &self.value)
            .finish_non_exhaustive()
    }
}
