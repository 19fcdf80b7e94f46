//! First derivatives of what dissipation and friction add to the elastic pressure, polygon by polygon.
//!
//! Let t be the traction less p n, a function of the pressure p, the normal n and the velocity v of A relative to B, and T
//! its derivative by v. As a body moves or a modulus changes, the equilibrium plane moves along its normal at the speed
//! h = h₀ + h₁y₁ + h₂y₂ (m/s), and turns by dn = −∇h. The wrench W(t) of the traction then changes by
//! h₀K₀ + h₁K₁ + h₂K₂ + Σ over edges s ∫ (w·ν) W(t) dl, where for the monomials m₀ = 1, m₁ = y₁, m₂ = y₂
//!
//! Kᵢ = W(mᵢD) + (∫ mᵢ (n × t) dA, 0) + Gᵢ − Σ over edges s (ν·n) ∫ W(mᵢt) dl,
//!
//! - D = ∂t/∂p·∂p_A/∂n + T(ω × n): pressure and velocity at the moved point;
//! - G₁ = W(θ×t) − W(T(θ×v)) with θ = n × dn = −e₂, as dn = −e₁ for h = y₁; G₂ the same with θ = e₁: turning normal and
//!   velocity together only turns the traction, so turning the normal alone turns the traction, and the velocity back;
//! - an edge moves with the line in which the plane meets the face that owns it. With the face's outward normal ν and
//!   s = 1/|ν − (ν·n)n|, its outward speed in the plane is s(w·ν − h ν·n); w, the velocity of the face, is zero for
//!   faces of A. Where several faces own an edge, the slowest and the fastest share it.
//!
//! Nothing divides by a length or an angle between edges, and no corner is differentiated.

mod area;
mod edges;
mod flux;
mod frame;
mod frozen;
mod in_lanes;
mod lines;
mod rates;
mod traction;
mod wrenches;

use super::jacobian::RelativeJacobian;
use super::linearised::RelativeLinearisation;
use super::loads::OctetsInMotion;
use super::motion::RelativeMotion;
use super::plane::PlanePolygon;
use super::polygon::{CutPolygon, CutSurface, PolygonSource};
use super::response::{LawResponse, PolygonResponse, Responses};
use super::sums::OverOctets;
use super::sums::PartialSum;
use super::{ContactPair, SurfaceLaw};
use crate::geometry::set_bits;
use crate::narrow_phase::{COINCIDENCE, Cut, Octet};
use crate::threads;
use edges::Edges;
pub(crate) use frozen::AddedByLaw;
pub(super) use frozen::FrozenPolygon;
use in_lanes::AddedInLanes;
use nalgebra::{Matrix6x2, Vector6};
use rates::PolygonRates;
use traction::Traction;

/// Octets that are linearised by themselves, in one thread: some 100 µs of work.
const PIECE: usize = 16;

/// The elastic contact, what the surface law adds to it, and what is kept of the polygons.
struct InMotion<R> {
    elastic: RelativeJacobian,
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
    /// In A's axes, of a pair in A's frame.
    ///
    /// The wrench and its derivatives by velocities and law are those of the contact polygons as they are. Those by motions
    /// and moduli have kinks where faces coincide; within round-off of them they are those of polygons that are cut as if
    /// they did (see [`PolygonSource::for_derivatives`]). So are the elastic ones: of two flush sides either may be the
    /// one that has a polygon, and taken for flush are both, or neither.
    pub(super) fn linearisation_in_motion<R: Responses>(
        &self,
        law: &SurfaceLaw,
        motion: &RelativeMotion<f64>,
    ) -> (RelativeLinearisation, R) {
        let (surface, finer) = self.source().for_derivatives(COINCIDENCE, self.search());
        let (mut sum, responses) = surface.linearisation(law, motion);
        sum.kinks.are_equal = surface.has_equal_fields();
        sum.kinks.are_flush |= surface.touches();
        if let Some(finer) = finer {
            // Its derivatives by motions and moduli are not used; near coincidences are rare.
            let (exact, ()) = finer.linearisation(law, motion);
            (sum.wrench, sum.by_twist, sum.by_law) = (exact.wrench, exact.by_twist, exact.by_law);
            sum.kinks.are_flush = true;
        }
        (sum, responses)
    }
}

impl RelativeLinearisation {
    /// From E_B ∂W/∂E_B as the second column by the moduli to the derivatives by both: as the wrench is homogeneous of
    /// degree one in the moduli, E_A ∂W/∂E_A + E_B ∂W/∂E_B = W.
    fn by_both_moduli(mut self, [modulus_a, modulus_b]: [f64; 2]) -> Self {
        let by_b = self.by_moduli.column(1).into_owned();
        let by_a = self.wrench - by_b;
        self.by_moduli = Matrix6x2::from_columns(&[by_a / modulus_a, by_b / modulus_b]);
        self
    }
}

impl<R> InMotion<R> {
    /// The wrench on A and its derivatives, at the given moduli.
    fn linearisation(self, moduli: [f64; 2]) -> (RelativeLinearisation, R) {
        let mut sum = self.elastic.linearisation(moduli);
        sum.merge(self.added.by_both_moduli(moduli));
        (sum, self.responses)
    }
}

impl CutSurface<'_, f64> {
    fn linearisation<R: Responses>(
        &self,
        law: &SurfaceLaw,
        motion: &RelativeMotion<f64>,
    ) -> (RelativeLinearisation, R) {
        let sum = self.sum_in_motion(law, motion);
        sum.linearisation(self.source.moduli())
    }

    /// Sums over the cuts: over the special ones one by one, and over the generic ones in lanes.
    fn sum_in_motion<R: Responses>(
        &self,
        law: &SurfaceLaw,
        motion: &RelativeMotion<f64>,
    ) -> InMotion<R> {
        let source = &self.source;
        let mut sum = self.sum_of_special_cuts(&|sum: &mut InMotion<R>, cut: &Cut| {
            source.add_in_motion(cut, (law, motion), sum);
        });
        let octets = self.found.octets();
        sum.elastic.merge(RelativeJacobian::over(octets));
        let (found, pair) = (&self.found, &source.pair);
        let piece = |octets: &[Octet]| {
            let added = AddedInLanes {
                moving: OctetsInMotion {
                    octets,
                    law,
                    motion,
                },
                found,
                pair,
                are_responses_kept: R::ARE_KEPT,
            };
            added.sum::<R>()
        };
        let mut pieces = octets.chunks(PIECE);
        threads::for_pieces(octets, PIECE, piece, |(added, responses, left)| {
            sum.added.merge(added);
            sum.responses.merge(responses);
            for (octet, left) in pieces.next().unwrap_or_default().iter().zip(left) {
                for place in set_bits(left) {
                    let cut = found.cut_of(octet, place, pair);
                    source.add_law(&cut, &source.polygon(&cut), (law, motion), &mut sum);
                }
            }
        });
        sum
    }
}

impl PolygonSource<'_, f64> {
    /// Adds all that the polygon of a cut contributes.
    fn add_in_motion<R: Responses>(
        &self,
        cut: &Cut,
        moving: (&SurfaceLaw, &RelativeMotion<f64>),
        sum: &mut InMotion<R>,
    ) {
        let polygon = self.polygon(cut);
        if polygon.has_area() && polygon.weights.have_area() {
            polygon.add_to(&mut sum.elastic);
        }
        self.add_law(cut, &polygon, moving, sum);
    }

    /// Adds what the law contributes, and keeps how the polygon answers.
    fn add_law<R: Responses>(
        &self,
        cut: &Cut,
        polygon: &CutPolygon<f64>,
        moving: (&SurfaceLaw, &RelativeMotion<f64>),
        sum: &mut InMotion<R>,
    ) {
        let law = self.add_traction_rates::<R>((cut, polygon), moving, &mut sum.added);
        sum.responses
            .keep(|| PolygonResponse::of(cut, polygon, law));
    }

    /// Adds what dissipation and friction contribute to the wrench on A and its derivatives; of those by the moduli, only
    /// E_B ∂W/∂E_B, in the second column. Gives how the polygon answers to changes of shape, if that is kept.
    fn add_traction_rates<R: Responses>(
        &self,
        (cut, polygon): (&Cut, &CutPolygon<f64>),
        (law, motion): (&SurfaceLaw, &RelativeMotion<f64>),
        sum: &mut RelativeLinearisation,
    ) -> Option<LawResponse> {
        let plane = PlanePolygon::of(polygon, motion)?;
        let mut response = R::ARE_KEPT.then(|| LawResponse::on(&plane));
        let rates = Traction::on(&plane, law, |traction| {
            let mut rates = PolygonRates::default();
            sum.kinks.are_clamped |= traction.is_clamped;
            if polygon.has_area() && polygon.weights.have_area() {
                rates.set_area(traction, polygon);
            }
            if !law.is_elastic() {
                let edges = Edges::of(self, (cut, polygon), &plane);
                edges.add_to(traction, &mut rates, response.as_mut());
            }
            rates
        });
        if let Some(response) = &mut response {
            let more = rates.more_by_growth.map(Vector6::from);
            response.by_speed = rates.rates.by_speed.map(Vector6::from);
            response.more_by_growth = (more != [Vector6::zeros(); 3]).then_some(more);
            response.by_pressure = rates.rates.by_pressure.map(Vector6::from);
        }
        rates.add_to(&plane, polygon, sum);
        response
    }
}
