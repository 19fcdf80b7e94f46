use crate::scalar::Scalar;
use crate::spatial::{Pose, Wrench};

/// The contact wrenches on two bodies, in world axes, each about the origin of its own body frame.
#[derive(Debug, Clone, Copy)]
pub struct ContactWrench<T = f64> {
    /// Wrench on A, about A's origin.
    pub on_a: Wrench<T>,
    /// Wrench on B, about B's origin: the opposite force, along the same line.
    pub on_b: Wrench<T>,
}

impl<T: Scalar> ContactWrench<T> {
    /// Creates the wrenches of bodies that do not touch.
    pub(crate) fn zero() -> Self {
        let [on_a, on_b] = [Wrench::zero(); 2];
        Self { on_a, on_b }
    }

    /// Computes both wrenches in the world from the wrench on A about A's origin in A's axes.
    pub(super) fn from_a(wrench_a: &Wrench<T>, [pose_wa, pose_wb]: [&Pose<T>; 2]) -> Self {
        let on_a = wrench_a.rotated(pose_wa.rotation());
        let from_a_to_b = pose_wb.translation() - pose_wa.translation();
        let on_b = -on_a.about(&from_a_to_b);
        Self { on_a, on_b }
    }
}
