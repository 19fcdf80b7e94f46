use super::Pose;
use nalgebra::{Isometry3, Rotation3, Translation3, UnitQuaternion};

/// Converts an isometry to a pose, with the rotation as a matrix.
///
/// The conversion does not check that the quaternion has unit length. Products of quaternions drift
/// from unit length, and `new_unchecked` accepts any quaternion. The pose is checked when a body is
/// created from it. Deviations from a rotation up to 1e-9 are corrected there. Larger deviations
/// and non-finite numbers are errors.
impl From<Isometry3<f64>> for Pose {
    fn from(isometry: Isometry3<f64>) -> Self {
        let rotation = isometry.rotation.to_rotation_matrix();
        Self::from_parts(rotation.into_inner(), isometry.translation.vector)
    }
}

/// Converts a pose to an isometry, with the rotation as a unit quaternion.
///
/// The result may be either of the two quaternions that represent the rotation. If the pose is not
/// finite, the isometry is not finite either.
impl From<Pose> for Isometry3<f64> {
    fn from(pose: Pose) -> Self {
        let rotation = Rotation3::from_matrix_unchecked(*pose.rotation());
        let orientation = UnitQuaternion::from_rotation_matrix(&rotation);
        // The length of the quaternion deviates from 1 by half the deviation of the matrix from a
        // rotation.
        let orientation = UnitQuaternion::new_normalize(orientation.into_inner());
        Self::from_parts(Translation3::from(*pose.translation()), orientation)
    }
}
