use super::rotation::{turn_from_real, turned_real};
use super::{Twist, rotation_from_vector, times_constant};
use crate::scalar::{Order, Scalar, lift, lift_vector, real_part, real_vector};
use nalgebra::{Matrix3, Vector3};
use std::ops::Mul;

/// Largest deviation of an entry of RᵀR from the identity for R to be accepted as a rotation. It is
/// the rounding error of a few thousand products, far above the rounding error of one normalized
/// quaternion.
const ORTHONORMALITY: f64 = 1e-9;

/// Largest deviation of RᵀR from the identity for a rotation to be restored bit for bit. It is
/// about ten times the rounding error of an orthonormalized rotation, and below the zero tolerance
/// of a contact.
const ROUND_OFF: f64 = 1e-14;

/// Error for a rotation matrix and a translation that are not a pose.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PoseError {
    /// A component is NaN or infinite.
    #[error("a pose must be finite, but a component of its rotation or translation is {0}")]
    NotFinite(f64),
    /// The matrix is not orthonormal, or its determinant is not 1.
    #[error(
        "a rotation must be orthonormal with determinant 1 to 1e-9, but the matrix is {deviation:e} away from it"
    )]
    NotARotation {
        /// Largest entry of |RᵀR − I|, or |det R − 1| if it is larger.
        deviation: f64,
    },
}

/// Position and orientation of a frame: `pose_ab` maps coordinates in B to coordinates in A.
///
/// [`Self::new`] checks its arguments. The other constructors and products do not. Creating a body
/// from a pose that is not finite is an error.
#[derive(Debug, Clone, Copy)]
pub struct Pose<T = f64> {
    rotation: Matrix3<T>,
    translation: Vector3<T>,
}

impl<T: Scalar> Pose<T> {
    /// Creates a pose from a rotation matrix and the position (m) of the frame's origin. Corrects
    /// small deviations of the rotation from orthonormality, such as those caused by products.
    ///
    /// # Errors
    /// If a number is not finite, or the matrix is not a rotation to 1e-9.
    pub fn new(rotation: Matrix3<T>, translation: Vector3<T>) -> Result<Self, PoseError> {
        let pose = Self {
            rotation,
            translation,
        };
        pose.checked()
    }

    /// Creates a pose from a rotation and a translation (m), without checks or corrections.
    pub(crate) fn from_parts(rotation: Matrix3<T>, translation: Vector3<T>) -> Self {
        Self {
            rotation,
            translation,
        }
    }

    /// Returns the pose of a frame relative to itself.
    #[must_use]
    pub fn identity() -> Self {
        Self::from_translation(Vector3::from_element(lift(0.0)))
    }

    /// Creates the pose of a frame with parallel axes, whose origin is at `translation` (m).
    #[must_use]
    pub fn from_translation(translation: Vector3<T>) -> Self {
        Self {
            rotation: Matrix3::identity(),
            translation,
        }
    }

    /// Creates a pose at the origin from a rotation that may have drifted from orthonormality over
    /// a few products.
    ///
    /// Applies the Newton step of [`Self::orthonormalized`] as a constant factor. The derivatives
    /// of a product of rotations are tangent to the rotations up to rounding error, so the
    /// derivatives need no correction.
    pub(crate) fn from_drifted_rotation(rotation: &Matrix3<T>) -> Self {
        let real = rotation.map(real_part);
        let correction = Matrix3::from_diagonal_element(3.0) - real.transpose() * real;
        Self {
            rotation: times_constant(rotation, &correction).map(|entry| entry * 0.5),
            translation: Vector3::from_element(lift(0.0)),
        }
    }

    /// Creates the pose of a frame that is rotated by `rotation_vector` (rad, axis times angle).
    /// Its origin is at `translation` (m).
    #[must_use]
    pub fn from_rotation_vector(rotation_vector: &Vector3<T>, translation: Vector3<T>) -> Self {
        Self {
            rotation: rotation_from_vector(rotation_vector),
            translation,
        }
    }

    /// Returns a constant pose: all derivatives are zero.
    #[must_use]
    pub fn lifted(pose: &Pose<f64>) -> Self {
        Self {
            rotation: pose.rotation.map(lift),
            translation: lift_vector(&pose.translation),
        }
    }

    /// Returns the pose without its derivatives.
    #[must_use]
    pub fn real(&self) -> Pose<f64> {
        Pose {
            rotation: self.rotation.map(real_part),
            translation: real_vector(&self.translation),
        }
    }

    /// Returns the rotation matrix: the axes of the inner frame as columns.
    #[must_use]
    pub fn rotation(&self) -> &Matrix3<T> {
        &self.rotation
    }

    /// Returns the origin of the inner frame (m).
    #[must_use]
    pub fn translation(&self) -> &Vector3<T> {
        &self.translation
    }

    /// Corrects a small deviation of the rotation from orthonormality, such as that caused by
    /// products. Applies one Newton step toward the nearest rotation, R·(3·I − RᵀR)/2. The step
    /// squares the deviation.
    ///
    /// To first order, the step removes the part of the derivatives that is not tangent to the
    /// rotations.
    pub(crate) fn orthonormalized(self) -> Self {
        if Order::<T>::IS_FIRST {
            let real = self.real().orthonormalized();
            let rotation = turned_real(real.rotation(), &turn_from_real(&self.rotation));
            return Self { rotation, ..self };
        }
        let three = Matrix3::from_diagonal_element(lift::<T>(3.0));
        let gram = self.rotation.transpose() * self.rotation;
        Self {
            rotation: (self.rotation * (three - gram)).map(|entry| entry * 0.5),
            ..self
        }
    }

    /// Returns the pose with the same orientation and another origin (m).
    #[must_use]
    pub fn with_translation(self, translation: Vector3<T>) -> Self {
        Self {
            translation,
            ..self
        }
    }

    /// Returns the inverse pose: `pose_ba` for `pose_ab`.
    #[must_use]
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.transpose();
        Self {
            rotation,
            translation: -(rotation * self.translation),
        }
    }

    /// Transforms a point (m) from the inner frame to the outer frame.
    #[must_use]
    pub fn transformed_point(&self, point: &Vector3<T>) -> Vector3<T> {
        self.rotation * point + self.translation
    }

    /// Returns the pose after a small motion, in the axes of the outer frame. The origin moves by
    /// `twist.linear`, and the frame rotates about its own origin by `twist.angular`.
    #[must_use]
    pub fn moved_by(&self, twist: &Twist<T>) -> Self {
        Self {
            rotation: rotation_from_vector(&twist.angular) * self.rotation,
            translation: self.translation + twist.linear,
        }
    }

    /// Rotates a constant direction from the inner frame to the axes of the outer frame.
    #[inline]
    pub(crate) fn rotated_constant(&self, direction: &Vector3<f64>) -> Vector3<T> {
        let row = |i: usize| {
            self.rotation[(i, 0)] * direction.x
                + self.rotation[(i, 1)] * direction.y
                + self.rotation[(i, 2)] * direction.z
        };
        Vector3::new(row(0), row(1), row(2))
    }

    /// Maps a constant point from the inner to the outer frame.
    #[inline]
    pub(crate) fn transformed_constant(&self, point: &Vector3<f64>) -> Vector3<T> {
        self.translation + self.rotated_constant(point)
    }

    /// Checks the real part of the pose, and orthonormalizes the rotation up to rounding error. A
    /// contact decides signs at 1e-14, so a rotation that is off by 1e-10 would lead to
    /// contradictory decisions.
    pub(crate) fn checked(self) -> Result<Self, PoseError> {
        let Pose {
            rotation,
            translation,
        } = self.real();
        let mut entries = rotation.iter().chain(translation.iter());
        if let Some(&value) = entries.find(|value| !value.is_finite()) {
            return Err(PoseError::NotFinite(value));
        }
        let gram = (rotation.transpose() * rotation - Matrix3::identity()).amax();
        let deviation = gram.max((rotation.determinant() - 1.0).abs());
        if deviation > ORTHONORMALITY {
            return Err(PoseError::NotARotation { deviation });
        }
        Ok(self.orthonormalized())
    }
}

impl Pose<f64> {
    /// Restores a pose from the numbers of a saved pose, or from its parts. Unlike [`Self::new`],
    /// it keeps the bits of a rotation that is orthonormal to 1e-14. Every rotation in a rollout is
    /// that accurate.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn restored(rotation: Matrix3<f64>, translation: Vector3<f64>) -> Result<Self, PoseError> {
        let righted = Self::new(rotation, translation)?;
        let gram = rotation.transpose() * rotation;
        let is_exact = (gram - Matrix3::identity()).amax() <= ROUND_OFF;
        Ok(if is_exact {
            Self::from_parts(rotation, translation)
        } else {
            righted
        })
    }
}

impl<T: Scalar> Mul for Pose<T> {
    type Output = Self;
    fn mul(self, inner: Self) -> Self {
        Self {
            rotation: self.rotation * inner.rotation,
            translation: self.transformed_point(&inner.translation),
        }
    }
}
