use crate::scalar::{Scalar, lift_vector, real_vector};
use nalgebra::{Vector3, Vector6};

/// Angular and linear velocity of a rigid body, or a small rigid motion.
///
/// Each use of a twist names its frame and the point that the linear part refers to.
#[derive(Debug, Clone, Copy)]
pub struct Twist<T = f64> {
    /// Angular velocity (rad/s), or rotation vector (rad).
    pub angular: Vector3<T>,
    /// Linear velocity (m/s), or translation (m).
    pub linear: Vector3<T>,
}

impl<T: Scalar> Twist<T> {
    /// Returns the zero twist.
    #[must_use]
    pub fn zero() -> Self {
        Self {
            angular: lift_vector(&Vector3::zeros()),
            linear: lift_vector(&Vector3::zeros()),
        }
    }

    /// Creates a twist from the 6-vector (angular, linear).
    #[must_use]
    pub fn from_vector(vector: &Vector6<T>) -> Self {
        Self {
            angular: Vector3::new(vector[0], vector[1], vector[2]),
            linear: Vector3::new(vector[3], vector[4], vector[5]),
        }
    }

    /// Returns the 6-vector (angular, linear).
    #[must_use]
    pub fn to_vector(&self) -> Vector6<T> {
        let (a, l) = (&self.angular, &self.linear);
        Vector6::new(a.x, a.y, a.z, l.x, l.y, l.z)
    }

    /// Returns the twist without its derivatives.
    #[must_use]
    pub fn real(&self) -> Twist<f64> {
        Twist {
            angular: real_vector(&self.angular),
            linear: real_vector(&self.linear),
        }
    }
}
