use super::polygon::{CutPolygon, CutSurface};
use crate::narrow_phase::Weights;
use crate::scalar::{Scalar, lift};
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
    /// No contact.
    pub(crate) fn zero() -> Self {
        let [on_a, on_b] = [Wrench::zero(); 2];
        Self { on_a, on_b }
    }

    /// Both wrenches in the world, from the one on A about A's origin in A's axes.
    pub(super) fn from_a(wrench_a: &Wrench<T>, [pose_wa, pose_wb]: [&Pose<T>; 2]) -> Self {
        let on_a = wrench_a.rotated(pose_wa.rotation());
        let from_a_to_b = pose_wb.translation() - pose_wa.translation();
        let on_b = -on_a.about(&from_a_to_b);
        Self { on_a, on_b }
    }
}

impl<T: Scalar> CutSurface<'_, T> {
    /// The elastic wrench on A, in A's axes about A's origin.
    pub fn wrench(&self) -> Wrench<T> {
        self.sum_of_moments(Weights::has_still_area, |sum: &mut Wrench<T>, polygon| {
            *sum += polygon.wrench();
        })
    }
}

impl<T: Scalar> CutPolygon<T> {
    /// Wrench on A about A's origin, in A's axes: ∫ p n dA and ∫ x × p n dA, both exact (the paper
    /// approximates the second with the centroid, §III-D).
    pub fn wrench(&self) -> Wrench<T> {
        let (total, weighted) = self.pressure_integrals();
        Wrench {
            torque: weighted.cross(&self.plane.normal),
            force: self.plane.normal * total,
        }
    }

    /// ∫ p dA (N) and ∫ p x dA (N m), as far as the polygon counts in values.
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
        let weight = lift::<T>(self.weights.still.area());
        (total * weight, weighted * weight)
    }
}
