use super::SurfaceLaw;
use super::friction::{Affine, product};
use super::motion::RelativeMotion;
use super::plane::{Outline, PlanePolygon, quadratic_moments};
use super::polygon::CutPolygon;
use crate::scalar::{Scalar, carries_derivatives, lift, real_part};
use crate::spatial::Wrench;
use nalgebra::Vector3;

impl<T: Scalar> CutPolygon<T> {
    /// Wrench on A about A's origin in A's axes, of the traction
    ///
    /// t = pψ(−μu₁, −μu₂, 1) along e₁, e₂ and n, ψ = 1 − d v₃, u = (v₁, v₂)/√(v₁² + v₂² + v_s²),
    ///
    /// integrated over the part of the polygon where ψ is positive: the normal part is a polynomial, and friction has a
    /// closed form (see [`Slip`](super::friction::Slip)).
    pub fn wrench_in_motion(&self, law: &SurfaceLaw<T>, motion: &RelativeMotion<T>) -> Wrench<T> {
        let Some(plane) = PlanePolygon::of(self, motion) else {
            return Wrench::zero();
        };
        let damping = plane.motion.damping(law.dissipation, lift(1.0));
        // Surfaces that part faster than the skin recovers do not pull.
        let part = plane.outline.cut(&damping);
        let outline = part.as_ref().unwrap_or(&plane.outline);
        let traction = product(&plane.pressure, &damping);
        let [normal, by_y1, by_y2] = quadratic_moments(&traction, &outline.moments());
        let [along_e1, along_e2, about_n] = plane.friction(law, outline, &damping);
        let weight = lift::<T>(self.weights.still.area());
        let force = plane.axes * Vector3::new(along_e1, along_e2, normal) * weight;
        let torque = plane.axes * Vector3::new(by_y2, -by_y1, about_n) * weight;
        Wrench {
            torque: torque + plane.center.cross(&force),
            force,
        }
    }
}

impl<T: Scalar> PlanePolygon<T> {
    /// Force along e₁ and e₂ and torque about n of friction.
    fn friction(&self, law: &SurfaceLaw<T>, outline: &Outline<T>, damping: &Affine<T>) -> [T; 3] {
        if real_part(law.friction) == 0.0 && !carries_derivatives::<T>() {
            return [lift(0.0); 3];
        }
        let slip = self.motion.slip_by(law);
        let along_slip = slip.resultant(outline.corners(), &self.pressure, damping);
        along_slip.map(|part| -(law.friction * part))
    }
}
