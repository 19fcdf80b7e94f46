//! Worlds whatever the type of their forces, so that what steps and differentiates them is compiled once, in this library,
//! and not again with every program.

use super::system::System;
use super::{Force, Situation, World, Wrenches};
use crate::scalar::Scalar;
use std::sync::Arc;

/// A world to be stepped.
pub(crate) trait Stepped<T>: Send + Sync {
    /// All but its forces.
    fn system(&self) -> &System<T>;

    /// Adds the wrenches of its forces on all bodies.
    fn add_forces(&self, wrenches: &mut Wrenches<T>, now: &Situation<T>);
}

/// A world whose forces can act in `T`.
pub(crate) trait ActsIn<T> {
    /// Its forces in another system.
    fn with_system(&self, system: System<T>) -> Arc<dyn Stepped<T>>;
}

impl<T: Scalar, F: Force> Stepped<T> for World<T, F> {
    fn system(&self) -> &System<T> {
        &self.system
    }

    fn add_forces(&self, wrenches: &mut Wrenches<T>, now: &Situation<T>) {
        self.forces.add_to(wrenches, now);
    }
}

impl<T: Scalar, F: Force> ActsIn<T> for World<f64, F> {
    fn with_system(&self, system: System<T>) -> Arc<dyn Stepped<T>> {
        let forces = Arc::clone(&self.forces);
        Arc::new(World { system, forces })
    }
}
