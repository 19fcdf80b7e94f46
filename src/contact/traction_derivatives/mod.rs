//! First derivatives of the contribution of dissipation and friction to the wrench of each contact polygon.
//!
//! Let t be the traction on A without the elastic part p n, and let W(t) be its wrench. The traction t is a function of the pressure p, the
//! normal n and the velocity v of A relative to B, and T is its derivative with respect to v. As a body moves or a modulus changes, the
//! equilibrium plane moves along its normal at the speed h = h₀ + h₁y₁ + h₂y₂ (m/s), and its normal changes by dn = −∇h. The wrench W(t)
//! then changes by h₀K₀ + h₁K₁ + h₂K₂ + Σ s ∫ (w·ν) W(t) dl, summed over the edges, where for the monomials m₀ = 1, m₁ = y₁, m₂ = y₂
//!
//! Kᵢ = W(mᵢD) + (∫ mᵢ (n × t) dA, 0) + Gᵢ − Σ s (ν·n) ∫ W(mᵢt) dl, with G₀ = 0.
//!
//! - D = ∂t/∂p·∂p_A/∂n + T(ω × n) is the derivative of t along the normal, because the pressure and the velocity differ at the moved point.
//!   The angular velocity of A relative to B is ω.
//! - G₁ = W(θ×t) − W(T(θ×v)) with θ = n × dn = −e₂, because dn = −e₁ for h = y₁. G₂ is the same with θ = e₁. A rotation of both the normal
//!   and the velocity rotates the traction. A rotation of the normal alone is this rotation, followed by the inverse rotation of the
//!   velocity.
//! - An edge moves with the line in which the plane meets the face that owns the edge. Let ν be the outward normal of the face, w its
//!   velocity, which is zero for faces of A, and s = 1/|ν − (ν·n)n|. The outward speed of the line in the plane is s(w·ν − h ν·n). If
//!   several faces own an edge, the slowest and the fastest line share it.
//!
//! All this also holds for a part of a polygon. A plane that cuts the polygon is then like a face of the body with which it moves.
//!
//! No term is divided by the length of an edge or by an angle between edges, and no corner is differentiated.

mod area;
mod edges;
mod frozen;
mod linearize;
mod lines;
mod parts;
mod pieces;
mod responses;
#[cfg(test)]
mod tests;
mod wrenches;

use super::integrate::{Integrand, Remainder};
use super::jacobian::RelativeJacobian;
use super::motion::RelativeMotion;
use super::polygon_source::PolygonSource;
use super::relative_linearization::RelativeLinearization;
use super::response::Responses;
use super::sums::PartialSum;
use super::{ContactPair, SurfaceLaw};
use crate::lanes;
use crate::narrow_phase::{COINCIDENCE, Cut};
use crate::search::GenericPairs;
pub(super) use edges::Edges;
pub(crate) use frozen::AddedByLaw;
pub(super) use frozen::FrozenPolygon;
use linearize::{Linearize, MATRIX, Polygons};
use nalgebra::Matrix6x2;
pub(super) use parts::{LawOnPart, LawOnParts};
pub(super) use pieces::EdgeFace;
use std::marker::PhantomData;
use std::slice;

/// Number of octets in a piece of work for a thread, which takes about 100 µs.
const OCTETS: usize = 16;

/// The wrench on A of moving bodies with a surface law, and its derivatives, with the responses of the polygons if `R` keeps them.
pub(super) struct MovingJacobian<'l, R> {
    law: &'l SurfaceLaw,
    motion: &'l RelativeMotion<f64>,
    /// Whether edges contribute to the derivatives with respect to motions and moduli.
    are_edges_moved: bool,
    responses: PhantomData<fn() -> R>,
}

/// The elastic contact, the contribution of the surface law, and the responses of the polygons if `R` keeps them.
pub(super) struct InMotion<R> {
    elastic: RelativeJacobian,
    /// The columns of `by_moduli` are zero and E_B ∂W/∂E_B (see [`RelativeLinearization::by_both_moduli`]).
    added: RelativeLinearization,
    responses: R,
}

impl<R: Responses> PartialSum for InMotion<R> {
    fn empty() -> Self {
        Self {
            elastic: RelativeJacobian::empty(),
            added: RelativeLinearization::empty(),
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
    /// The wrench and its derivatives with respect to velocities and law are computed from the actual contact polygons. Derivatives with
    /// respect to motions and moduli have kinks if faces coincide. Near a kink, they are computed from polygons that are cut as if the
    /// faces coincided (see [`PolygonSource::for_derivatives`]). The elastic derivatives are computed from these polygons too. Rounding
    /// error decides which of two flush sides has a polygon, so both sides must count as flush, or neither.
    pub(super) fn linearization_in_motion<R: Responses>(
        &self,
        law: &SurfaceLaw,
        motion: &RelativeMotion<f64>,
    ) -> (RelativeLinearization, R) {
        let integrand = MovingJacobian::<R>::new(law, motion);
        let (sum, (surface, finer)) =
            self.source()
                .integral_for_derivatives(COINCIDENCE, self.search(), &integrand);
        let (mut sum, responses) = sum.linearization(self.moduli());
        sum.kinks.are_equal = surface.has_equal_fields();
        sum.kinks.are_flush |= surface.touches();
        if let Some(finer) = finer {
            let exact = finer.integral(&MovingJacobian::<()>::with_fixed_edges(law, motion));
            let (exact, ()) = exact.linearization(self.moduli());
            (sum.wrench, sum.by_twist, sum.by_law) = (exact.wrench, exact.by_twist, exact.by_law);
            sum.kinks.are_flush = true;
        }
        (sum, responses)
    }
}

impl RelativeLinearization {
    /// Computes the derivatives with respect to both moduli. On input, the second column of `by_moduli` is E_B ∂W/∂E_B. The wrench is
    /// homogeneous of degree one in the moduli, so E_A ∂W/∂E_A + E_B ∂W/∂E_B = W.
    fn by_both_moduli(mut self, [modulus_a, modulus_b]: [f64; 2]) -> Self {
        let by_b = self.by_moduli.column(1).into_owned();
        let by_a = self.wrench - by_b;
        self.by_moduli = Matrix6x2::from_columns(&[by_a / modulus_a, by_b / modulus_b]);
        self
    }
}

impl<R> InMotion<R> {
    /// Returns the wrench on A and its derivatives, at the given moduli.
    fn linearization(self, moduli: [f64; 2]) -> (RelativeLinearization, R) {
        let mut sum = self.elastic.linearization(moduli);
        sum.merge(self.added.by_both_moduli(moduli));
        (sum, self.responses)
    }
}

impl<'l, R> MovingJacobian<'l, R> {
    pub fn new(law: &'l SurfaceLaw, motion: &'l RelativeMotion<f64>) -> Self {
        Self {
            law,
            motion,
            are_edges_moved: !law.is_elastic(),
            responses: PhantomData,
        }
    }

    /// Leaves out what edges contribute to the derivatives with respect to motions and moduli, for callers that do not use these
    /// derivatives.
    fn with_fixed_edges(law: &'l SurfaceLaw, motion: &'l RelativeMotion<f64>) -> Self {
        Self {
            are_edges_moved: false,
            ..Self::new(law, motion)
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
            are_edges_moved: self.are_edges_moved,
            are_responses_kept: R::ARE_KEPT,
        });
        sum.elastic.merge(linearized.elastic);
        sum.added.merge(linearized.added);
        sum.responses.merge(R::of(linearized.responses));
    }
}
