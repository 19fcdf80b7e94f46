//! Worlds, whatever the type of their forces. What differentiates them is compiled once, in this library, in every width of
//! dual numbers; rollouts outside an experiment are still compiled with the program that takes them.

use super::model::Model;
use super::{Body, Force, ForceContext, STATE_DIM, World, WrenchAccumulator};
use crate::scalar::{DenseDual, Scalar};
use std::sync::Arc;

/// Derivatives by the state of one body.
pub(super) type BodyDual = DenseDual<STATE_DIM>;

/// A world, whatever the type of its forces.
pub(crate) trait DynWorld<T>: Send + Sync {
    /// All but its forces.
    fn model(&self) -> &Model<T>;

    /// Adds the wrenches of its forces on all bodies.
    fn add_forces(&self, wrenches: &mut WrenchAccumulator<T>, now: &ForceContext<T>);

    /// Its forces by themselves.
    fn real_forces(&self) -> &dyn DynForce;

    /// Whether there are any.
    fn has_forces(&self) -> bool {
        !self.real_forces().is_empty()
    }
}

/// Forces in `f64`, and with derivatives by the state of a body.
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

/// A world that can be made of another system in `T`.
pub(crate) trait WithModel<T> {
    /// Its forces in another system.
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
