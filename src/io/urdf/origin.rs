//! Poses of `<origin>` elements.

use super::UrdfError;
use super::element::Element;
use crate::scalar::portable::sin_cos;
use crate::spatial::Pose;
use nalgebra::{Matrix3, Unit, UnitQuaternion, Vector3, Vector4};

/// Pose in the `<origin>` of an element, or the identity without `<origin>`.
pub(super) fn origin_of(element: Element) -> Result<Pose, UrdfError> {
    let Some(origin) = element.child("origin")? else {
        return Ok(Pose::identity());
    };
    let translation = origin.numbers("xyz")?.unwrap_or_default();
    let rotation = match (origin.numbers("rpy")?, origin.numbers("quat_xyzw")?) {
        (None, None) => Matrix3::identity(),
        (Some(angles), None) => rotation_from_angles(angles),
        (None, Some(numbers)) => {
            // The coordinates of a quaternion are in the order x, y, z, w here too.
            let direction: Unit<Vector4<f64>> = origin.direction("quat_xyzw", numbers)?;
            let quaternion = UnitQuaternion::new_unchecked(direction.into_inner().into());
            quaternion.to_rotation_matrix().into_inner()
        }
        (Some(_), Some(_)) => {
            return Err(UrdfError::TwoRotations {
                at: origin.location(),
            });
        }
    };
    Ok(Pose::from_parts(rotation, Vector3::from(translation)))
}

/// Rotation by roll, pitch and yaw (rad): the product of the rotations about z by yaw, y by pitch and x by roll.
fn rotation_from_angles(angles: [f64; 3]) -> Matrix3<f64> {
    let [(sr, cr), (sp, cp), (sy, cy)] = angles.map(sin_cos);
    Matrix3::new(
        cy * cp,
        cy * sp * sr - sy * cr,
        cy * sp * cr + sy * sr,
        sy * cp,
        sy * sp * sr + cy * cr,
        sy * sp * cr - cy * sr,
        -sp,
        cp * sr,
        cp * cr,
    )
}
