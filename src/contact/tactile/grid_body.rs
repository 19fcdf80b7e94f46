use crate::scalar::Scalar;
use crate::spatial::Pose;
use nalgebra::Matrix3;

/// The body of a pair to which a [`TaxelGrid`](super::TaxelGrid) is fixed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GridBody {
    /// Body A.
    A,
    /// Body B, which may be rigid or a half-space.
    B,
}

impl GridBody {
    /// Returns the pose of this body in A's frame.
    pub(super) fn pose_in_a<T: Scalar>(self, pose_ab: &Pose<T>) -> Pose<T> {
        match self {
            Self::A => Pose::identity(),
            Self::B => *pose_ab,
        }
    }

    /// Returns the matrix that maps the force on A, in A's axes, to the force on this body, in its own axes.
    pub(super) fn force_from_a(self, pose_ab: &Pose) -> Matrix3<f64> {
        match self {
            Self::A => Matrix3::identity(),
            Self::B => -pose_ab.rotation().transpose(),
        }
    }
}
