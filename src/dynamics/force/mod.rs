//! Forces other than contact and gravity.

mod control;
mod kinds;
mod number;

pub use control::Control;
pub(in crate::dynamics) use control::TimeSpan;
pub use kinds::{Drag, Spring, Thruster};
pub use number::ForceNumber;

use super::body::index_of;
use super::{Body, BodyState, WorldError};
use crate::scalar::Scalar;
use crate::spatial::Wrench;
use nalgebra::Vector3;

/// What a force may depend on: all bodies of a world at the time at which it acts.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct ForceContext<'a, T = f64> {
    /// Time (s).
    pub time: f64,
    /// The bodies, in the order of the world's.
    pub bodies: &'a [Body<T>],
    /// Their states, in the same order.
    pub states: &'a [BodyState<T>],
    /// The world's gravity (m/s²), which acts on every dynamic body by itself.
    pub gravity: &'a Vector3<T>,
    /// The net contact wrench on each body, about its center of mass (of a body that forces do not move, its origin), in
    /// world axes. With it a force may depend on what contact does, as in the paper (§V).
    pub contact: &'a [Wrench<T>],
    /// See [`Self::parameter`].
    pub(super) parameters: &'a [(String, T)],
}

/// The wrenches that forces add up, one for each body: about its center of mass, in world axes. Those on bodies that forces
/// do not move have no effect.
#[derive(Debug)]
pub struct WrenchAccumulator<'a, T = f64> {
    bodies: &'a [Body<T>],
    states: &'a [BodyState<T>],
    sums: &'a mut [Wrench<T>],
}

/// Forces other than contact and gravity: what they add to the wrenches on the bodies.
///
/// Generic over the scalar, so that derivatives flow through it. A tuple of forces is a force, their sum, and so is a list of
/// forces of one kind.
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

    /// The places of the bodies whose states the force depends on, in groups: the wrenches on bodies of a group depend on
    /// states of the group alone. Implicit steps solve a group together, and take the derivatives of the force by its states.
    ///
    /// What a force makes of [contact](ForceContext::contact) with the body that it acts on needs no group: bodies that touch are
    /// solved together.
    ///
    /// All bodies are one group unless this says otherwise, which is always right, and slower where there are many bodies.
    fn coupling_groups(&self, bodies: &[Body]) -> Vec<Vec<usize>> {
        vec![(0..bodies.len()).collect()]
    }

    /// Whether there is no force at all, in no state: nothing is spent on its derivatives then. An empty list is none.
    fn is_empty(&self) -> bool {
        false
    }

    /// Checks that a world has the bodies and the force parameters that the force depends on.
    ///
    /// # Errors
    /// If it cannot act in this world.
    fn check(&self, bodies: &[Body], parameters: &[(String, f64)]) -> Result<(), WorldError> {
        let _ = (bodies, parameters);
        Ok(())
    }
}

impl<T: Scalar> ForceContext<'_, T> {
    /// The place of the body of a name, if there is one.
    #[must_use]
    pub fn index_of(&self, name: &str) -> Option<usize> {
        index_of(name, self.bodies)
    }

    /// The number that the world has under a name for its forces to read
    /// ([`World::with_force_parameter`](super::World::with_force_parameter)): the derivatives by it flow through the force.
    #[must_use]
    pub fn parameter(&self, name: &str) -> Option<T> {
        let mut numbers = self.parameters.iter();
        numbers
            .find(|(other, _)| other == name)
            .map(|(_, value)| *value)
    }

    /// The place (m) and the velocity (m/s) in the world of a point of a body, given in the body frame (m).
    ///
    /// # Panics
    /// If there is no body with this place in the list.
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
    /// Onto sums, one for each body.
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

/// Checks that groups of coupled bodies are of a world with so many bodies.
pub(in crate::dynamics) fn check_coupled(
    groups: &[Vec<usize>],
    bodies: usize,
) -> Result<(), WorldError> {
    match groups.iter().flatten().find(|&&body| body >= bodies) {
        None => Ok(()),
        Some(&index) => Err(WorldError::CoupledBody { index, bodies }),
    }
}

/// No force.
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

/// All of them.
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
