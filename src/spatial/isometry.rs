use super::Pose;
use nalgebra::{Isometry3, Rotation3, Translation3, UnitQuaternion};

/// The same pose with its rotation as a matrix.
///
/// The quaternion of an isometry is of length 1 by its type, but not by any check: products take it a
/// little away, `new_unchecked` as far as one likes. Its numbers are taken as they are, and a pose is
/// checked where a body is made of it: up to 1e-9 is put right there, and what is further off or not
/// finite is refused.
impl From<Isometry3<f64>> for Pose {
    fn from(isometry: Isometry3<f64>) -> Self {
        let rotation = isometry.rotation.to_rotation_matrix();
        Self::from_parts(rotation.into_inner(), isometry.translation.vector)
    }
}

/// The same pose with its rotation as a quaternion of length 1; of the two that stand for a rotation it
/// may be either. A pose that is not finite gives an isometry that is not finite.
impl From<Pose> for Isometry3<f64> {
    fn from(pose: Pose) -> Self {
        let rotation = Rotation3::from_matrix_unchecked(*pose.rotation());
        let orientation = UnitQuaternion::from_rotation_matrix(&rotation);
        // Its length is off by half of what the matrix is off from a rotation.
        let orientation = UnitQuaternion::new_normalize(orientation.into_inner());
        Self::from_parts(Translation3::from(*pose.translation()), orientation)
    }
}
