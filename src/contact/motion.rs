//! The motion of a pair of bodies.

use super::{ContactPair, SurfaceLaw};
use crate::scalar::{Scalar, real_vector, times};
use crate::spatial::Twist;
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
            twists: self.twists.each_ref().map(|twist| Twist {
                angular: real_vector(&twist.angular),
                linear: real_vector(&twist.linear),
            }),
        }
    }
}

impl<T: Scalar> ContactPair<'_, T> {
    /// The law and the velocity of A relative to B; none for a pair at rest.
    pub(super) fn relative_motion(&self) -> Option<(SurfaceLaw<T>, RelativeMotion<T>)> {
        let Motion { law, twists } = self.motion()?;
        Some((*law, RelativeMotion::of(self, *twists)))
    }
}

/// The velocity of A relative to B as a field, in A's axes about A's origin.
#[derive(Clone, Copy)]
pub(super) struct RelativeMotion<T> {
    pub angular: Vector3<T>,
    pub at_origin: Vector3<T>,
}

impl<T: Scalar> RelativeMotion<T> {
    pub fn of(pair: &ContactPair<T>, [twist_a, twist_b]: [Twist<T>; 2]) -> Self {
        let (pose_wa, pose_wb) = (pair.a().pose(), pair.b().pose());
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
