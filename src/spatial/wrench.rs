use crate::scalar::{Scalar, lift_vector, real_vector, times};
use nalgebra::{Matrix3, Vector3, Vector6};
use std::ops::{Add, AddAssign, Neg};

/// Torque and force on a rigid body.
///
/// Each use of a wrench names its axes and the point about which the torque is taken.
#[derive(Debug, Clone, Copy)]
pub struct Wrench<T = f64> {
    /// Torque (N m).
    pub torque: Vector3<T>,
    /// Force (N).
    pub force: Vector3<T>,
}

impl<T: Scalar> Wrench<T> {
    /// Returns the zero wrench.
    #[must_use]
    pub fn zero() -> Self {
        Self {
            torque: lift_vector(&Vector3::zeros()),
            force: lift_vector(&Vector3::zeros()),
        }
    }

    /// Returns the same wrench about another point, at `offset` (m) from the present point. The
    /// torque becomes τ − offset × F.
    #[must_use]
    pub fn about(&self, offset: &Vector3<T>) -> Self {
        Self {
            torque: self.torque - offset.cross(&self.force),
            force: self.force,
        }
    }

    /// Returns the same wrench in other axes. `rotation_wa` maps vectors in A's axes to W's axes.
    #[must_use]
    pub fn rotated(&self, rotation_wa: &Matrix3<T>) -> Self {
        Self {
            torque: times(rotation_wa, &self.torque),
            force: times(rotation_wa, &self.force),
        }
    }

    /// Creates a wrench from the 6-vector (torque, force).
    #[must_use]
    pub fn from_vector(vector: &Vector6<T>) -> Self {
        Self {
            torque: Vector3::new(vector[0], vector[1], vector[2]),
            force: Vector3::new(vector[3], vector[4], vector[5]),
        }
    }

    /// Returns the 6-vector (torque, force).
    #[must_use]
    pub fn to_vector(&self) -> Vector6<T> {
        let (t, f) = (&self.torque, &self.force);
        Vector6::new(t.x, t.y, t.z, f.x, f.y, f.z)
    }

    /// Returns the wrench without its derivatives.
    #[must_use]
    pub fn real(&self) -> Wrench<f64> {
        Wrench {
            torque: real_vector(&self.torque),
            force: real_vector(&self.force),
        }
    }
}

impl<T: Scalar> Add for Wrench<T> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            torque: self.torque + other.torque,
            force: self.force + other.force,
        }
    }
}

impl<T: Scalar> AddAssign for Wrench<T> {
    fn add_assign(&mut self, other: Self) {
        self.torque += other.torque;
        self.force += other.force;
    }
}

impl<T: Scalar> Neg for Wrench<T> {
    type Output = Self;
    fn neg(self) -> Self {
        Self {
            torque: -self.torque,
            force: -self.force,
        }
    }
}
