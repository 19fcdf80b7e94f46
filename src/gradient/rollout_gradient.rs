use super::slots::Slots;
use super::{GradientError, Parameter};
use crate::contact::ShapeGradient;
use crate::dynamics::{Inertia, KinkSummary, Model, ModelGradient};
use crate::spatial::MassGradient;
use nalgebra::Vector3;
use std::fmt;

/// The derivatives of a loss by all that a rollout depends on, as [`Experiment::full_gradient`](super::Experiment::full_gradient)
/// gives them.
#[derive(Clone)]
pub struct RolloutGradient {
    /// The loss.
    pub value: f64,
    pub(super) system: Model,
    pub(super) gradient: ModelGradient,
    /// Whether forces other than contact, gravity and controls act, which may depend on where centers of mass are.
    pub(super) has_forces: bool,
}

/// What stays of a dynamic body's mass properties as its vertices move. Those that follow are of a solid of uniform density.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum HoldFixed {
    /// Mass, center of mass and inertia: vertices matter for contact alone, and the density need not be uniform.
    MassProperties,
    /// The mass; its center and the inertia are those of the new shape.
    Mass,
    /// The density: mass, center and inertia are those of the new shape.
    Density,
}

impl RolloutGradient {
    /// By the numbers of a parameter, in their order: the unit of the loss over theirs.
    ///
    /// # Errors
    /// If it is not one of the world's.
    pub fn by(&self, parameter: &Parameter) -> Result<Vec<f64>, GradientError> {
        let slots = Slots::resolve(std::slice::from_ref(parameter), &self.system)?;
        Ok(slots.gradient(&self.gradient))
    }

    /// Where derivatives that went into it may have been one of several: see [`Experiment::kinks`](super::Experiment::kinks).
    #[must_use]
    pub fn kinks(&self) -> Vec<KinkSummary> {
        self.gradient.kinks()
    }

    /// By the shape of the named body: through contact, and through its mass as far as that does not stay. Of bodies that forces
    /// do not move the mass does not matter: ask with [`HoldFixed::MassProperties`].
    ///
    /// # Errors
    /// If there is no such body; and, unless [`HoldFixed::MassProperties`] are asked for, as [`Self::by_mass_properties`], or if
    /// mass properties are not those of the shape at a uniform density.
    pub fn by_shape(&self, body: &str, keeping: HoldFixed) -> Result<ShapeGradient, GradientError> {
        let mut gradient = self.gradient.shapes[self.system.index_of(body)?].clone();
        let through_mass = match keeping {
            HoldFixed::MassProperties => return Ok(gradient),
            HoldFixed::Mass => self.by_vertices_through_mass(body, false)?,
            HoldFixed::Density => self.by_vertices_through_mass(body, true)?,
        };
        for (by_vertex, own) in gradient.by_vertices.iter_mut().zip(through_mass) {
            *by_vertex += own;
        }
        Ok(gradient)
    }

    /// By the mass properties of the named body, its shape staying as it is.
    ///
    /// # Errors
    /// If there is no such body, forces do not move it, or the world has forces other than contact, gravity and controls: what
    /// they make of a center of mass is not known.
    pub fn by_mass_properties(&self, body: &str) -> Result<MassGradient, GradientError> {
        let (index, inertia) = self.dynamic(body)?;
        if self.has_forces {
            return Err(GradientError::ForcesByCenter(body.to_owned()));
        }
        let own = &self.gradient.bodies[index];
        // The inertia is mass times what the gradient is by.
        let by_inertia = own.inertia / inertia.mass;
        Ok(MassGradient {
            by_mass: own.mass - by_inertia.dot(&inertia.per_mass()),
            by_center_of_mass: own.center,
            by_inertia,
        })
    }

    /// The place of the named body, which forces move, and its inertia.
    fn dynamic(&self, body: &str) -> Result<(usize, &Inertia), GradientError> {
        let index = self.system.index_of(body)?;
        match self.system.bodies[index].inertia() {
            Some(inertia) => Ok((index, inertia)),
            None => Err(GradientError::NotDynamic {
                body: body.to_owned(),
                parameter: "the mass".to_owned(),
            }),
        }
    }

    /// By the vertices of the named body through its mass properties, which follow the shape: at the same density, or at the same
    /// mass.
    fn by_vertices_through_mass(
        &self,
        body: &str,
        keeps_density: bool,
    ) -> Result<Vec<Vector3<f64>>, GradientError> {
        let by = self.by_mass_properties(body)?;
        let (index, inertia) = self.dynamic(body)?;
        let body = &self.system.bodies[index];
        if !body.is_uniform() {
            return Err(GradientError::NotUniform(body.name().to_owned()));
        }
        let by_mass = if keeps_density {
            by.by_mass
        } else {
            // As all else grows with the volume, the density falls: mass properties at a density of their own.
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
