use super::rotation::{turn_from_real, turned_real};
use super::{Twist, rotation_from_vector, times_constant};
use crate::scalar::{Order, Scalar, lift, lift_vector, real_part, real_vector};
use nalgebra::{Matrix3, Vector3};
use std::ops::Mul;

/// How far RᵀR may be from the identity, entry by entry, for R to count as a rotation: the
/// round-off of a few thousand products, far above that of one normalised quaternion.
const ORTHONORMALITY: f64 = 1e-9;

/// How far RᵀR may be from the identity for a rotation to be restored bit for bit: some ten times the
/// round-off of one that was made orthonormal, and below what a contact counts as zero.
const ROUND_OFF: f64 = 1e-14;

/// Why a rotation matrix and a translation are not a pose.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PoseError {
    /// A component is NaN or infinite.
    #[error("a pose must be finite, but a component of its rotation or translation is {0}")]
    NotFinite(f64),
    /// The matrix is not orthonormal, or it mirrors.
    #[error(
        "a rotation must be orthonormal with determinant 1 to 1e-9, but the matrix is {deviation:e} away from it"
    )]
    NotARotation {
        /// Largest entry of |RᵀR − I|, or |det R − 1| where that is larger.
        deviation: f64,
    },
}

/// Position and orientation of a frame: `pose_ab` maps coordinates in B to coordinates in A.
///
/// [`Self::new`] checks its numbers; the other constructors and products take them as they are, and a
/// pose that is not finite is refused where a body is made of it.
#[derive(Debug, Clone, Copy)]
pub struct Pose<T = f64> {
    rotation: Matrix3<T>,
    translation: Vector3<T>,
}

impl<T: Scalar> Pose<T> {
    /// From a rotation matrix and the position (m) of the frame's origin. A rotation that products
    /// have taken a little from orthonormality is put right.
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

    /// From a rotation and a translation as they are.
    pub(super) fn from_parts(rotation: Matrix3<T>, translation: Vector3<T>) -> Self {
        Self {
            rotation,
            translation,
        }
    }

    /// The pose of a frame in itself.
    #[must_use]
    pub fn identity() -> Self {
        Self::from_translation(Vector3::from_element(lift(0.0)))
    }

    /// A frame with parallel axes, its origin at `translation` (m).
    #[must_use]
    pub fn from_translation(translation: Vector3<T>) -> Self {
        Self {
            rotation: Matrix3::identity(),
            translation,
        }
    }

    /// A frame at the origin with a rotation that a few products may have taken from orthonormality.
    ///
    /// The Newton step of [`Self::orthonormalised`] as a constant factor: derivatives of a product of
    /// rotations are those of a rotation to round-off, and have nothing that it would put right.
    pub(crate) fn from_drifted_rotation(rotation: &Matrix3<T>) -> Self {
        let real = rotation.map(real_part);
        let correction = Matrix3::from_diagonal_element(3.0) - real.transpose() * real;
        Self {
            rotation: times_constant(rotation, &correction).map(|entry| entry * 0.5),
            translation: Vector3::from_element(lift(0.0)),
        }
    }

    /// A frame turned by `rotation_vector` (rad, axis times angle), its origin at `translation` (m).
    #[must_use]
    pub fn from_rotation_vector(rotation_vector: &Vector3<T>, translation: Vector3<T>) -> Self {
        Self {
            rotation: rotation_from_vector(rotation_vector),
            translation,
        }
    }

    /// A constant pose: all derivatives zero.
    #[must_use]
    pub fn lifted(pose: &Pose<f64>) -> Self {
        Self {
            rotation: pose.rotation.map(lift),
            translation: lift_vector(&pose.translation),
        }
    }

    /// The pose without its derivatives.
    #[must_use]
    pub fn real(&self) -> Pose<f64> {
        Pose {
            rotation: self.rotation.map(real_part),
            translation: real_vector(&self.translation),
        }
    }

    /// Rotation matrix: the axes of the inner frame as columns.
    #[must_use]
    pub fn rotation(&self) -> &Matrix3<T> {
        &self.rotation
    }

    /// Origin of the inner frame (m).
    #[must_use]
    pub fn translation(&self) -> &Vector3<T> {
        &self.translation
    }

    /// The pose with its rotation, which products have taken a little away from orthonormality, put
    /// right by one Newton step towards the nearest rotation, R·(3·I − RᵀR)/2: it squares the
    /// deviation.
    ///
    /// To first order in the derivatives, that step takes out of them what is no turn.
    pub(crate) fn orthonormalised(self) -> Self {
        if Order::<T>::IS_FIRST {
            let real = self.real().orthonormalised();
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

    /// The same orientation with the origin elsewhere (m).
    #[must_use]
    pub fn with_translation(self, translation: Vector3<T>) -> Self {
        Self {
            translation,
            ..self
        }
    }

    /// `pose_ba` from `pose_ab`.
    #[must_use]
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.transpose();
        Self {
            rotation,
            translation: -(rotation * self.translation),
        }
    }

    /// The point's coordinates (m) in the outer frame.
    #[must_use]
    pub fn transformed_point(&self, point: &Vector3<T>) -> Vector3<T> {
        self.rotation * point + self.translation
    }

    /// The pose after a small motion in the axes of the outer frame: the origin moves by
    /// `twist.linear`, and the frame turns about its own origin by `twist.angular`.
    #[must_use]
    pub fn moved_by(&self, twist: &Twist<T>) -> Self {
        Self {
            rotation: rotation_from_vector(&twist.angular) * self.rotation,
            translation: self.translation + twist.linear,
        }
    }

    /// A constant direction in the axes of the outer frame.
    #[inline]
    pub(crate) fn rotated_constant(&self, direction: &Vector3<f64>) -> Vector3<T> {
        let row = |i: usize| {
            self.rotation[(i, 0)] * direction.x
                + self.rotation[(i, 1)] * direction.y
                + self.rotation[(i, 2)] * direction.z
        };
        Vector3::new(row(0), row(1), row(2))
    }

    /// The pose, if its real part is one, with the rotation made orthonormal to round-off: the
    /// contact decides on signs at 1e-14, where a rotation off by 1e-10 would contradict itself.
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
        Ok(self.orthonormalised())
    }
}

impl Pose<f64> {
    /// From the numbers of a pose that was saved or taken apart: as [`Self::new`], but a rotation that is orthonormal to 1e-14,
    /// as every one in a rollout is, keeps its bits.
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
