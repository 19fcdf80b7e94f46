//! The motion of a pair of bodies.

use super::SurfaceLaw;
use crate::scalar::{Scalar, real_vector, times};
use crate::spatial::{Pose, Twist};
use nalgebra::Vector3;

/// The surface law of a pair, and the twists of its bodies at their origins, in world axes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Motion<T> {
    pub law: SurfaceLaw<T>,
    pub twists: [Twist<T>; 2],
}

impl<T: Scalar> Motion<T> {
    pub fn real(&self) -> Motion<f64> {
        Motion {
            law: self.law.real(),
            twists: self.twists.each_ref().map(Twist::real),
        }
    }
}

/// Velocity field of A relative to B, in A's axes: the angular velocity and the velocity at A's origin.
#[derive(Clone, Copy)]
pub(super) struct RelativeMotion<T> {
    pub angular: Vector3<T>,
    pub at_origin: Vector3<T>,
}

impl<T: Scalar> RelativeMotion<T> {
    /// Computes the relative motion of two bodies with these poses and twists in the world.
    pub fn of([pose_wa, pose_wb]: [&Pose<T>; 2], [twist_a, twist_b]: &[Twist<T>; 2]) -> Self {
        let to_origin_a = pose_wa.translation() - pose_wb.translation();
        let velocity_of_b = twist_b.linear + twist_b.angular.cross(&to_origin_a);
        let in_a = pose_wa.rotation().transpose();
        Self {
            angular: times(&in_a, &(twist_a.angular - twist_b.angular)),
            at_origin: times(&in_a, &(twist_a.linear - velocity_of_b)),
        }
    }

    pub fn at(&self, point: &Vector3<T>) -> Vector3<T> {
        self.at_origin + self.angular.cross(point)
    }

    pub fn real(&self) -> RelativeMotion<f64> {
        RelativeMotion {
            angular: real_vector(&self.angular),
            at_origin: real_vector(&self.at_origin),
        }
    }
}
