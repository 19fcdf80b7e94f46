use crate::scalar::{Scalar, dot_constant, lift, lift_vector, real_part, real_vector};
use crate::spatial::Pose;
use nalgebra::Vector3;

/// An affine function of position: `gradient · x + offset`.
#[derive(Debug, Clone, Copy)]
pub struct AffineField<T = f64> {
    /// Gradient (unit of the value per m).
    pub gradient: Vector3<T>,
    /// Value at the origin of the frame.
    pub offset: T,
}

impl<T: Scalar> AffineField<T> {
    /// Returns the value at a point (m).
    #[inline]
    #[must_use]
    pub fn at(&self, point: &Vector3<T>) -> T {
        self.gradient.dot(point) + self.offset
    }

    /// Returns the value at a constant point (m).
    #[inline]
    pub(crate) fn at_constant(&self, point: &Vector3<f64>) -> T {
        dot_constant(&self.gradient, point) + self.offset
    }

    /// Returns the field times a factor.
    #[must_use]
    pub fn scaled(&self, factor: T) -> Self {
        Self {
            gradient: self.gradient * factor,
            offset: self.offset * factor,
        }
    }

    /// Returns the field without its derivatives.
    #[must_use]
    pub fn real(&self) -> AffineField<f64> {
        AffineField {
            gradient: real_vector(&self.gradient),
            offset: real_part(self.offset),
        }
    }
}

impl AffineField<f64> {
    /// Transforms the field from B to A: the result is a function of coordinates in A.
    #[must_use]
    pub fn posed<T: Scalar>(&self, pose_ab: &Pose<T>) -> AffineField<T> {
        let gradient = pose_ab.rotated_constant(&self.gradient);
        AffineField {
            gradient,
            offset: lift::<T>(self.offset) - gradient.dot(pose_ab.translation()),
        }
    }

    /// Returns the field as a constant: all derivatives are zero.
    #[must_use]
    pub fn lifted<T: Scalar>(&self) -> AffineField<T> {
        AffineField {
            gradient: lift_vector(&self.gradient),
            offset: lift(self.offset),
        }
    }
}
