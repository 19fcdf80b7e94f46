//! Forces other than contact and gravity.

mod control;
mod kinds;
mod number;

pub use control::Control;
pub(in crate::dynamics) use control::{TimeSpan, shares_of};
pub use kinds::{Drag, Spring, Thruster};
pub use number::ForceNumber;

use super::body::index_of;
use super::{Body, BodyState, WorldError};
use crate::scalar::Scalar;
use crate::spatial::Wrench;
use nalgebra::Vector3;

/// Inputs of a force: all bodies of a world at the time at which the force acts.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct ForceContext<'a, T = f64> {
    /// Time (s).
    pub time: f64,
    /// Bodies of the world.
    pub bodies: &'a [Body<T>],
    /// States of the bodies, in the same order.
    pub states: &'a [BodyState<T>],
    /// Gravity of the world (m/s²). The world applies it to every dynamic body.
    pub gravity: &'a Vector3<T>,
    /// Net contact wrench on each body, in world axes, about the center of mass, or about the origin of a body that is not dynamic. A force
    /// may depend on it, as in the paper (§V).
    pub contact: &'a [Wrench<T>],
    /// See [`Self::parameter`].
    pub(super) parameters: &'a [(String, T)],
}

/// Sum of the wrenches of forces on each body, about its center of mass, in world axes. Wrenches on fixed and kinematic bodies have no
/// effect.
#[derive(Debug)]
pub struct WrenchAccumulator<'a, T = f64> {
    bodies: &'a [Body<T>],
    states: &'a [BodyState<T>],
    sums: &'a mut [Wrench<T>],
}

/// A force other than contact and gravity.
///
/// The force is generic over the scalar, so that derivatives propagate through it. A tuple of
/// forces, or a list of forces of one type, is a force that adds the wrenches of its elements.
///
/// ```
/// use hydroelastic::dynamics::{Force, ForceContext, WrenchAccumulator};
/// use hydroelastic::scalar::{Scalar, lift};
///
/// /// A drag (N s/m) on all bodies.
/// struct Honey(f64);
///
/// impl Force for Honey {
///     fn add_to<T: Scalar>(&self, wrenches: &mut WrenchAccumulator<T>, now: &ForceContext<T>) {
///         for (body, state) in now.states.iter().enumerate() {
///             wrenches.apply_force_at_com(body, &(state.twist.linear * lift::<T>(-self.0)));
///         }
///     }
/// }
/// ```
pub trait Force: Send + Sync + 'static {
    /// Adds the wrenches on all bodies.
    fn add_to<T: Scalar>(&self, wrenches: &mut WrenchAccumulator<T>, now: &ForceContext<T>);

    /// Groups of body indices. The wrenches on the bodies of a group depend only on the states of that group. Implicit steps solve the
    /// bodies of a group together, and differentiate the force with respect to their states.
    ///
    /// A force that depends on the [contact](ForceContext::contact) of the body on which it acts needs no group for it, because bodies that
    /// touch are solved together.
    ///
    /// By default all bodies are one group. This default is always correct, but slow if there are
    /// many bodies.
    fn coupling_groups(&self, bodies: &[Body]) -> Vec<Vec<usize>> {
        vec![(0..bodies.len()).collect()]
    }

    /// Whether the force is zero in every state, for example because a list of forces is empty. Its
    /// derivatives are then skipped.
    fn is_empty(&self) -> bool {
        false
    }

    /// Checks that a world has the bodies and the force parameters that the force depends on.
    ///
    /// # Errors
    /// If the force does not fit the world.
    fn check(&self, bodies: &[Body], parameters: &[(String, f64)]) -> Result<(), WorldError> {
        let _ = (bodies, parameters);
        Ok(())
    }
}

impl<T: Scalar> ForceContext<'_, T> {
    /// Index of the body with this name, if there is one.
    #[must_use]
    pub fn index_of(&self, name: &str) -> Option<usize> {
        index_of(name, self.bodies)
    }

    /// Value of a force parameter of the world ([`World::with_force_parameter`](super::World::with_force_parameter)). Derivatives with
    /// respect to it propagate through the force.
    #[must_use]
    pub fn parameter(&self, name: &str) -> Option<T> {
        let mut numbers = self.parameters.iter();
        numbers
            .find(|(candidate, _)| candidate == name)
            .map(|(_, value)| *value)
    }

    /// Position (m) and velocity (m/s) in the world of a point of a body, given in the body frame (m).
    ///
    /// # Panics
    /// If `body` is not the index of a body.
    #[must_use]
    pub fn point(&self, body: usize, point: &Vector3<f64>) -> [Vector3<T>; 2] {
        let state = &self.states[body];
        let arm = state.pose.rotated_constant(point);
        let twist = self.bodies[body].twist_at_origin(state);
        [
            state.pose.translation() + arm,
            twist.linear + twist.angular.cross(&arm),
        ]
    }
}

impl<'a, T: Scalar> WrenchAccumulator<'a, T> {
    /// Accumulator that adds to `sums`, one wrench for each body.
    pub(super) fn new(now: &ForceContext<'a, T>, sums: &'a mut [Wrench<T>]) -> Self {
        Self {
            bodies: now.bodies,
            states: now.states,
            sums,
        }
    }

    /// Adds a wrench about the center of mass of a body.
    pub fn add(&mut self, body: usize, wrench: &Wrench<T>) {
        self.sums[body] += *wrench;
    }

    /// Adds a force (N) through the center of mass of a body.
    pub fn apply_force_at_com(&mut self, body: usize, force: &Vector3<T>) {
        self.sums[body].force += force;
    }

    /// Adds a force (N) at a point (m) of the world.
    pub fn apply_force_at_point(&mut self, body: usize, force: &Vector3<T>, point: &Vector3<T>) {
        let center = self.bodies[body].center_in(&self.states[body]);
        let torque = (point - center).cross(force);
        self.add(
            body,
            &Wrench {
                torque,
                force: *force,
            },
        );
    }
}

/// Checks that groups of coupled bodies contain only indices below the number of bodies.
pub(in crate::dynamics) fn check_coupled(
    groups: &[Vec<usize>],
    bodies: usize,
) -> Result<(), WorldError> {
    match groups.iter().flatten().find(|&&body| body >= bodies) {
        None => Ok(()),
        Some(&index) => Err(WorldError::CoupledBody { index, bodies }),
    }
}

/// Zero force.
impl Force for () {
    fn add_to<T: Scalar>(&self, _: &mut WrenchAccumulator<T>, _: &ForceContext<T>) {}

    fn coupling_groups(&self, _: &[Body]) -> Vec<Vec<usize>> {
        Vec::new()
    }

    fn is_empty(&self) -> bool {
        true
    }
}

macro_rules! sums {
    ($($names:ident)+) => {
        /// The sum of these forces.
        #[expect(non_snake_case, reason = "each is named as its type is")]
        impl<$($names: Force),+> Force for ($($names,)+) {
            fn add_to<T: Scalar>(&self, wrenches: &mut WrenchAccumulator<T>, now: &ForceContext<T>) {
                let ($($names,)+) = self;
                $($names.add_to(wrenches, now);)+
            }

            fn coupling_groups(&self, bodies: &[Body]) -> Vec<Vec<usize>> {
                let ($($names,)+) = self;
                let mut groups = Vec::new();
                $(groups.extend($names.coupling_groups(bodies));)+
                groups
            }

            fn is_empty(&self) -> bool {
                let ($($names,)+) = self;
                $($names.is_empty())&&+
            }

            fn check(
                &self,
                bodies: &[Body],
                parameters: &[(String, f64)],
            ) -> Result<(), WorldError> {
                let ($($names,)+) = self;
                $($names.check(bodies, parameters)?;)+
                Ok(())
            }
        }
    };
}

sums!(A B);
sums!(A B C);
sums!(A B C D);

/// Sum of the forces of the list.
impl<F: Force> Force for Vec<F> {
    fn add_to<T: Scalar>(&self, wrenches: &mut WrenchAccumulator<T>, now: &ForceContext<T>) {
        for force in self {
            force.add_to(wrenches, now);
        }
    }

    fn coupling_groups(&self, bodies: &[Body]) -> Vec<Vec<usize>> {
        self.iter()
            .flat_map(|force| force.coupling_groups(bodies))
            .collect()
    }

    fn is_empty(&self) -> bool {
        self.iter().all(Force::is_empty)
    }

    fn check(&self, bodies: &[Body], parameters: &[(String, f64)]) -> Result<(), WorldError> {
        self.iter()
            .try_for_each(|force| force.check(bodies, parameters))
    }
}
