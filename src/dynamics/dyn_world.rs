//! Type-erased worlds. [`Force`] is generic over the scalar, so it is not object-safe, and a world has the type of its forces. These traits
//! erase that type. The code that differentiates worlds is therefore compiled once, in this library, for every width of dual numbers.
//! Rollouts outside an experiment are still compiled in the crate that runs them.

use super::model::Model;
use super::{Body, Force, ForceContext, STATE_DIM, World, WrenchAccumulator};
use crate::scalar::{DenseDual, Scalar};
use std::sync::Arc;

/// Dual number with the derivatives with respect to the state of one body.
pub(super) type BodyDual = DenseDual<STATE_DIM>;

/// A world with a type-erased force.
pub(crate) trait DynWorld<T>: Send + Sync {
    /// Everything but the forces.
    fn model(&self) -> &Model<T>;

    /// Adds the wrenches of the forces on all bodies.
    fn add_forces(&self, wrenches: &mut WrenchAccumulator<T>, now: &ForceContext<T>);

    /// Forces other than contact, gravity and controls.
    fn real_forces(&self) -> &dyn DynForce;

    /// Whether the world has forces.
    fn has_forces(&self) -> bool {
        !self.real_forces().is_empty()
    }
}

/// A type-erased force, evaluated in `f64` and in [`BodyDual`].
pub(crate) trait DynForce: Send + Sync {
    /// [`Force::is_empty`].
    fn is_empty(&self) -> bool;

    /// [`Force::coupling_groups`].
    fn coupling_groups(&self, bodies: &[Body]) -> Vec<Vec<usize>>;

    /// [`Force::add_to`].
    fn add_real(&self, wrenches: &mut WrenchAccumulator, now: &ForceContext);

    /// [`Force::add_to`].
    fn add_seeded(&self, wrenches: &mut WrenchAccumulator<BodyDual>, now: &ForceContext<BodyDual>);
}

impl<F: Force> DynForce for F {
    fn is_empty(&self) -> bool {
        Force::is_empty(self)
    }

    fn coupling_groups(&self, bodies: &[Body]) -> Vec<Vec<usize>> {
        Force::coupling_groups(self, bodies)
    }

    fn add_real(&self, wrenches: &mut WrenchAccumulator, now: &ForceContext) {
        self.add_to(wrenches, now);
    }

    fn add_seeded(&self, wrenches: &mut WrenchAccumulator<BodyDual>, now: &ForceContext<BodyDual>) {
        self.add_to(wrenches, now);
    }
}

/// A world that can be rebuilt with another model, in the scalar `T`.
pub(crate) trait WithModel<T> {
    /// Returns a world with the same forces and another model.
    fn with_model(&self, model: Model<T>) -> Arc<dyn DynWorld<T>>;
}

impl<T: Scalar, F: Force> DynWorld<T> for World<T, F> {
    fn model(&self) -> &Model<T> {
        &self.model
    }

    fn add_forces(&self, wrenches: &mut WrenchAccumulator<T>, now: &ForceContext<T>) {
        self.forces.add_to(wrenches, now);
    }

    fn real_forces(&self) -> &dyn DynForce {
        &*self.forces
    }
}

impl<T: Scalar, F: Force> WithModel<T> for World<f64, F> {
    fn with_model(&self, model: Model<T>) -> Arc<dyn DynWorld<T>> {
        Arc::new(World::with_model(self, model))
    }
}
