use super::narrow_phase::PairPolygon;
use super::search::PartialSum;
use crate::scalar::Scalar;
use crate::spatial::{Pose, Wrench};
use nalgebra::Vector3;

/// The contact wrenches on two bodies, in world axes, each about the origin of its own body frame.
#[derive(Debug, Clone, Copy)]
pub struct ContactWrench<T = f64> {
    /// Wrench on A, about A's origin.
    pub on_a: Wrench<T>,
    /// Wrench on B, about B's origin: the opposite force, along the same line.
    pub on_b: Wrench<T>,
}

impl<T: Scalar> ContactWrench<T> {
    /// From the wrench on A about A's origin, in A's axes.
    pub(super) fn from_wrench_a(wrench_a: Wrench<T>, pose_wa: &Pose<T>, pose_ab: &Pose<T>) -> Self {
        let wrench_b = -wrench_a.about(pose_ab.translation());
        Self {
            on_a: wrench_a.rotated(pose_wa.rotation()),
            on_b: wrench_b.rotated(pose_wa.rotation()),
        }
    }
}

impl<T: Scalar> PartialSum for Wrench<T> {
    fn empty() -> Self {
        Self::zero()
    }

    fn merge(&mut self, next: Self) {
        *self += next;
    }
}

impl<T: Scalar> PairPolygon<T> {
    /// Wrench on A about A's origin, in A's axes: ∫ p n dA and ∫ x × p n dA, both exact (the paper
    /// approximates the second with the centroid, §III-D).
    pub fn wrench(&self) -> Wrench<T> {
        let (total, weighted) = self.pressure_integrals();
        Wrench {
            torque: weighted.cross(&self.plane.normal),
            force: self.plane.normal * total,
        }
    }

    /// ∫ p dA (N) and ∫ p x dA (N m).
    ///
    /// With x = r + y around the reference point r and p = p(r) + ∇p·y:
    /// ∫ p dA = p(r)·area + ∇p·∫y, ∫ p x dA = r·∫p dA + p(r)·∫y + (∫y yᵀ)·∇p.
    pub fn pressure_integrals(&self) -> (T, Vector3<T>) {
        let moments = &self.moments;
        let pressure_at_reference = self.pressure.at(&moments.reference);
        let gradient = &self.pressure.gradient;
        let total = pressure_at_reference * moments.area + gradient.dot(&moments.first);
        let weighted = moments.reference * total
            + moments.first * pressure_at_reference
            + moments.second * gradient;
        (total, weighted)
    }
}
