//! First derivatives of the contribution of dissipation and friction to the wrench of each contact polygon.
//!
//! Let t be the traction without the elastic part p n. It is a function of the pressure p, the normal n and the velocity v of A relative to
//! B, and T is its derivative with respect to v. As a body moves or a modulus changes, the equilibrium plane moves along its normal at the
//! speed h = h₀ + h₁y₁ + h₂y₂ (m/s), and turns by dn = −∇h. The wrench W(t) of the traction then changes by h₀K₀ + h₁K₁ + h₂K₂ + Σ over
//! edges s ∫ (w·ν) W(t) dl, where for the monomials m₀ = 1, m₁ = y₁, m₂ = y₂
//!
//! Kᵢ = W(mᵢD) + (∫ mᵢ (n × t) dA, 0) + Gᵢ − Σ over edges s (ν·n) ∫ W(mᵢt) dl,
//!
//! - D = ∂t/∂p·∂p_A/∂n + T(ω × n) contains the pressure and the velocity at the moved point.
//! - G₁ = W(θ×t) − W(T(θ×v)) with θ = n × dn = −e₂, because dn = −e₁ for h = y₁. G₂ is the same with θ = e₁. Turning normal and velocity
//!   together only turns the traction. Turning the normal alone therefore turns the traction, and the velocity back.
//! - An edge moves with the line in which the plane meets the face that owns it. With the face's outward normal ν and s = 1/|ν − (ν·n)n|,
//!   its outward speed in the plane is s(w·ν − h ν·n). The velocity w of the face is zero for faces of A. If several faces own an edge, the
//!   slowest and the fastest share it.
//!
//! No term is divided by a length or an angle between edges, and no corner is differentiated.

mod area;
mod edges;
mod frozen;
mod linearize;
mod lines;
mod pieces;
mod responses;
#[cfg(test)]
mod tests;
mod wrenches;

use super::integrate::{Integrand, Remainder};
use super::jacobian::RelativeJacobian;
use super::motion::RelativeMotion;
use super::polygon_source::PolygonSource;
use super::relative_linearisation::RelativeLinearisation;
use super::response::Responses;
use super::sums::PartialSum;
use super::{ContactPair, SurfaceLaw};
use crate::lanes;
use crate::narrow_phase::{COINCIDENCE, Cut};
use crate::search::GenericPairs;
pub(crate) use frozen::AddedByLaw;
pub(super) use frozen::FrozenPolygon;
use linearize::{Linearize, MATRIX, Polygons};
use nalgebra::Matrix6x2;
use std::marker::PhantomData;
use std::slice;

/// Number of octets that are linearized in one thread: about 100 µs of work.
const OCTETS: usize = 16;

/// The wrench on A of moving bodies with a surface law, and its derivatives, with the responses of the polygons if `R` keeps them.
pub(super) struct MovingJacobian<'l, R> {
    law: &'l SurfaceLaw,
    motion: &'l RelativeMotion<f64>,
    responses: PhantomData<fn() -> R>,
}

/// The elastic contact, the contribution of the surface law, and the data that is kept of the polygons.
pub(super) struct InMotion<R> {
    elastic: RelativeJacobian,
    /// The first column of the derivatives with respect to the moduli is not set. The second is E_B ∂W/∂E_B.
    added: RelativeLinearisation,
    responses: R,
}

impl<R: Responses> PartialSum for InMotion<R> {
    fn empty() -> Self {
        Self {
            elastic: RelativeJacobian::empty(),
            added: RelativeLinearisation::empty(),
            responses: R::empty(),
        }
    }

    fn merge(&mut self, next: Self) {
        self.elastic.merge(next.elastic);
        self.added.merge(next.added);
        self.responses.merge(next.responses);
    }
}

impl ContactPair<'_> {
    /// Linearizes a pair in A's frame. The result is in A's axes.
    ///
    /// The wrench and its derivatives with respect to velocities and law are those of the contact polygons as they are. Derivatives with
    /// respect to motions and moduli have kinks if faces coincide. Within round-off of a kink, they are computed from polygons that are cut
    /// as if the faces coincided (see [`PolygonSource::for_derivatives`]). The same holds for the elastic derivatives: either of two flush
    /// sides may have the polygon, and both sides, or neither, count as flush.
    pub(super) fn linearisation_in_motion<R: Responses>(
        &self,
        law: &SurfaceLaw,
        motion: &RelativeMotion<f64>,
    ) -> (RelativeLinearisation, R) {
        let integrand = MovingJacobian::<R>::new(law, motion);
        let (sum, (surface, finer)) =
            self.source()
                .integral_for_derivatives(COINCIDENCE, self.search(), &integrand);
        let (mut sum, responses) = sum.linearisation(self.moduli());
        sum.kinks.are_equal = surface.has_equal_fields();
        sum.kinks.are_flush |= surface.touches();
        if let Some(finer) = finer {
            // Derivatives with respect to motions and moduli are not used. Near coincidences are rare.
            let exact = finer.integral(&MovingJacobian::<()>::new(law, motion));
            let (exact, ()) = exact.linearisation(self.moduli());
            (sum.wrench, sum.by_twist, sum.by_law) = (exact.wrench, exact.by_twist, exact.by_law);
            sum.kinks.are_flush = true;
        }
        (sum, responses)
    }
}

impl RelativeLinearisation {
    /// Computes the derivatives with respect to both moduli from E_B ∂W/∂E_B in the second column. The wrench is homogeneous of degree one
    /// in the moduli, so E_A ∂W/∂E_A + E_B ∂W/∂E_B = W.
    fn by_both_moduli(mut self, [modulus_a, modulus_b]: [f64; 2]) -> Self {
        let by_b = self.by_moduli.column(1).into_owned();
        let by_a = self.wrench - by_b;
        self.by_moduli = Matrix6x2::from_columns(&[by_a / modulus_a, by_b / modulus_b]);
        self
    }
}

impl<R> InMotion<R> {
    /// Returns the wrench on A and its derivatives, at the given moduli.
    fn linearisation(self, moduli: [f64; 2]) -> (RelativeLinearisation, R) {
        let mut sum = self.elastic.linearisation(moduli);
        sum.merge(self.added.by_both_moduli(moduli));
        (sum, self.responses)
    }
}

impl<'l, R> MovingJacobian<'l, R> {
    pub fn new(law: &'l SurfaceLaw, motion: &'l RelativeMotion<f64>) -> Self {
        Self {
            law,
            motion,
            responses: PhantomData,
        }
    }
}

impl<R: Responses> Integrand<f64> for MovingJacobian<'_, R> {
    type Sum = InMotion<R>;

    const OCTETS: usize = OCTETS;

    fn add(&self, source: &PolygonSource<f64>, cut: &Cut, sum: &mut InMotion<R>) {
        self.add_cuts(source, slice::from_ref(cut), sum);
    }

    fn add_cuts(&self, source: &PolygonSource<f64>, cuts: &[Cut], sum: &mut InMotion<R>) {
        self.add_polygons(source, Polygons::Cuts(cuts), sum);
    }

    fn add_octets(
        &self,
        source: &PolygonSource<f64>,
        generic: GenericPairs,
        _: &mut Remainder,
        sum: &mut InMotion<R>,
    ) {
        sum.elastic.add_octets(generic.octets);
        self.add_polygons(source, Polygons::Generic(generic), sum);
    }
}

impl<R: Responses> MovingJacobian<'_, R> {
    fn add_polygons(&self, source: &PolygonSource<f64>, polygons: Polygons, sum: &mut InMotion<R>) {
        let linearized = lanes::run(Linearize {
            source,
            polygons,
            law: self.law,
            motion: self.motion,
            are_responses_kept: R::ARE_KEPT,
        });
        sum.elastic.merge(linearized.elastic);
        sum.added.merge(linearized.added);
        sum.responses.merge(R::of(linearized.responses));
    }
}
