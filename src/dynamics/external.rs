use super::BodyState;
use crate::scalar::Scalar;
use nalgebra::Vector3;

/// Acceleration of a body in world axes.
#[derive(Debug, Clone, Copy)]
pub struct Acceleration<T = f64> {
    /// Angular acceleration α (rad/s²) from torques: I⁻¹τ. The gyroscopic part is the integrator's.
    pub angular: Vector3<T>,
    /// Linear acceleration a (m/s²) of the centre of mass.
    pub linear: Vector3<T>,
}

/// What external forces may depend on.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Situation<'a, T = f64> {
    /// Time (s).
    pub time: f64,
    /// Name of the body.
    pub body: &'a str,
    /// Its mass (kg).
    pub mass: T,
    /// Its state.
    pub state: &'a BodyState<T>,
    /// The world's gravity (m/s²).
    pub gravity: &'a Vector3<T>,
}

/// Forces other than contact, as the paper has them (§V): a function that takes the acceleration
/// that contact gives a body to its true acceleration.
///
/// Generic over the scalar, so that derivatives flow through it.
///
/// ```
/// use hydroelastic::dynamics::{Acceleration, ExternalForces, Situation};
/// use hydroelastic::scalar::Scalar;
///
/// /// Gravity, and a drag that grows with the speed.
/// struct ViscousAir(f64);
///
/// impl ExternalForces for ViscousAir {
///     fn acceleration<T: Scalar>(
///         &self,
///         situation: &Situation<T>,
///         contact: Acceleration<T>,
///     ) -> Acceleration<T> {
///         let drag = situation.state.twist.linear * (situation.mass.recip() * self.0);
///         Acceleration {
///             linear: contact.linear + situation.gravity - drag,
///             ..contact
///         }
///     }
/// }
/// ```
pub trait ExternalForces: Send + Sync {
    /// The true acceleration of a dynamic body.
    fn acceleration<T: Scalar>(
        &self,
        situation: &Situation<T>,
        contact: Acceleration<T>,
    ) -> Acceleration<T>;
}

/// The world's gravity and nothing else.
#[derive(Debug, Clone, Copy, Default)]
pub struct Gravity;

impl ExternalForces for Gravity {
    fn acceleration<T: Scalar>(
        &self,
        situation: &Situation<T>,
        contact: Acceleration<T>,
    ) -> Acceleration<T> {
        Acceleration {
            linear: contact.linear + situation.gravity,
            ..contact
        }
    }
}
