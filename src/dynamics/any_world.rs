//! Worlds, whatever the type of their forces. What differentiates them is compiled once, in this library, in every width of
//! dual numbers; rollouts outside an experiment are still compiled with the program that takes them.

use super::system::System;
use super::{Body, Force, LOCAL, Situation, World, Wrenches};
use crate::scalar::{DenseDual, Scalar};
use std::sync::Arc;

/// Derivatives by the state of one body.
pub(super) type Seeded = DenseDual<LOCAL>;

/// A world, whatever the type of its forces.
pub(crate) trait AnyWorld<T>: Send + Sync {
    /// All but its forces.
    fn system(&self) -> &System<T>;

    /// Adds the wrenches of its forces on all bodies.
    fn add_forces(&self, wrenches: &mut Wrenches<T>, now: &Situation<T>);

    /// Its forces by themselves.
    fn real_forces(&self) -> &dyn RealForces;

    /// Whether there are any.
    fn has_forces(&self) -> bool {
        !self.real_forces().is_nothing()
    }
}

/// Forces in `f64`, and with derivatives by the state of a body.
pub(crate) trait RealForces: Send + Sync {
    /// [`Force::is_nothing`].
    fn is_nothing(&self) -> bool;

    /// [`Force::coupled`].
    fn coupled(&self, bodies: &[Body]) -> Vec<Vec<usize>>;

    /// [`Force::add_to`].
    fn add_real(&self, wrenches: &mut Wrenches, now: &Situation);

    /// [`Force::add_to`].
    fn add_seeded(&self, wrenches: &mut Wrenches<Seeded>, now: &Situation<Seeded>);
}

impl<F: Force> RealForces for F {
    fn is_nothing(&self) -> bool {
        Force::is_nothing(self)
    }

    fn coupled(&self, bodies: &[Body]) -> Vec<Vec<usize>> {
        Force::coupled(self, bodies)
    }

    fn add_real(&self, wrenches: &mut Wrenches, now: &Situation) {
        self.add_to(wrenches, now);
    }

    fn add_seeded(&self, wrenches: &mut Wrenches<Seeded>, now: &Situation<Seeded>) {
        self.add_to(wrenches, now);
    }
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

    fn real_forces(&self) -> &dyn RealForces {
        &*self.forces
    }
}

impl<T: Scalar, F: Force> WithSystem<T> for World<f64, F> {
    fn with_system(&self, system: System<T>) -> Arc<dyn AnyWorld<T>> {
        Arc::new(World::with_system(self, system))
    }
}
