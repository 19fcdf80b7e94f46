//! Worlds, whatever the type of their forces. What differentiates them is compiled once, in this library, in every width of
//! dual numbers; rollouts outside an experiment are still compiled with the program that takes them.

use super::system::System;
use super::{Force, Situation, World, Wrenches};
use crate::scalar::Scalar;
use std::sync::Arc;

/// A world, whatever the type of its forces.
pub(crate) trait AnyWorld<T>: Send + Sync {
    /// All but its forces.
    fn system(&self) -> &System<T>;

    /// Adds the wrenches of its forces on all bodies.
    fn add_forces(&self, wrenches: &mut Wrenches<T>, now: &Situation<T>);
}

/// A world that can be made of another system in `T`.
pub(crate) trait WithSystem<T> {
    /// Its forces in another system.
    fn with_system(&self, system: System<T>) -> Arc<dyn AnyWorld<T>>;
}

impl<T: Scalar, F: Force> AnyWorld<T> for World<T, F> {
    fn system(&self) -> &System<T> {
        &self.system
    }

    fn add_forces(&self, wrenches: &mut Wrenches<T>, now: &Situation<T>) {
        self.forces.add_to(wrenches, now);
    }
}

impl<T: Scalar, F: Force> WithSystem<T> for World<f64, F> {
    fn with_system(&self, system: System<T>) -> Arc<dyn AnyWorld<T>> {
        Arc::new(World::with_system(self, system))
    }
}
