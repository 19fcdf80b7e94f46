//! Coincidence in the surfaces from which values and derivatives are computed.
//!
//! A corner is on a plane if it is within a margin, the rounding of coordinates. Values use this margin. A single margin for values and
//! derivatives was tried: derivatives were wrong in the tests `flush_motion` and `coincidence`. A single margin is not enough in these
//! cases:
//!
//! - *Faces that miss each other by about a margin.* Some corners count as on the plane and others do not, so polygons with weight ½ have
//!   no partner. Derivatives therefore use a wider tolerance ([`COINCIDENCE`](crate::narrow_phase::COINCIDENCE), [`ELASTIC_COINCIDENCE`]).
//!   If the distances to coincidence have a gap, the tolerance is placed in it
//!   ([`NearZeroHistogram::split`](crate::geometry::NearZeroHistogram::split)), so that the limit does not separate the corners of a face.
//! - *Nearly equal fields.* A force jumps within a very small distance. The derivative within this distance is far larger than the slope
//!   over a longer step. The wider tolerance gives the mean of both sides.
//! - *Bodies that are pressed in by less than the tolerance.* The wider tolerance would take their pressure for zero. It is narrowed until
//!   the load stays (`CutSurface::load_at_zero`).
//! - *A whole polygon near a face of B.* The neighbors beyond the face would both count it, or neither would. Values also use a wider
//!   tolerance, placed and narrowed in the same way. With a fixed tolerance the force would jump at its edge.

use super::integrate::{CutSurface, Integrand};
use super::polygon_source::PolygonSource;
use super::sums::PartialSum;
use super::{Culling, Search};
use crate::narrow_phase::ELASTIC_COINCIDENCE;
use crate::scalar::{Scalar, carries_derivatives};

/// Largest fraction of the load that may count as zero, for values and for derivatives. With 1e-6 for both, the derivatives of pair 286437
/// of the test `coincidence` are wrong: 3.6e-6 of its load is on polygons that count as coincident. Values stay more accurate.
const MAX_DISCARDED_LOAD: [f64; 2] = [1e-6, 5e-6];

/// Number of octaves by which the tolerance is narrowed in each step while more of the load would count as zero.
const NARROWER: usize = 3;

/// The surface from which derivatives are computed and, if it may be different, the surface for values.
pub(super) type Surfaces<'a, T> = (CutSurface<'a, T>, Option<CutSurface<'a, T>>);

impl<'a, T: Scalar> PolygonSource<'a, T> {
    /// Returns the surface from which values are computed.
    pub fn for_values(&self, search: Search) -> CutSurface<'a, T> {
        self.values_from(self.within(0, search))
    }

    /// Integrates over the surface for values, which may differ from the surface for derivatives. Octets of a large surface are integrated
    /// as soon as they are found.
    pub fn integral_for_values<I: Integrand<T>>(&self, search: Search, integrand: &I) -> I::Sum {
        let (surface, spilled) = self.integrated_within(0, search, integrand);
        let (surface, spilled) = match spilled {
            // This is rare. Repeating the search is cheaper than keeping the octets of every large contact.
            Some(_) if surface.has_polygons_on_faces() => (self.for_values(search), None),
            Some(_) => (surface, spilled),
            None => (self.values_from(surface), None),
        };
        surface.integral_after(spilled.unwrap_or_else(I::Sum::empty), integrand)
    }

    /// Returns the surface from which derivatives are computed, and the surface for values if it may be different.
    pub fn for_derivatives(&self, octaves: u32, search: Search) -> Surfaces<'a, T> {
        let surface = self.within(octaves.cast_signed(), search);
        self.derivatives_from(surface, octaves, search)
    }

    /// Integrates over the surface from which derivatives are computed, in the same way. Also returns the surfaces of
    /// [`Self::for_derivatives`]. The first lacks the octets that were spilled.
    pub fn integral_for_derivatives<I: Integrand<T>>(
        &self,
        octaves: u32,
        search: Search,
        integrand: &I,
    ) -> (I::Sum, Surfaces<'a, T>) {
        let (surface, spilled) = self.integrated_within(octaves.cast_signed(), search, integrand);
        let (surfaces, spilled) = match spilled {
            Some(_) if surface.search_result.noted_closeness().is_within(octaves) => {
                (self.for_derivatives(octaves, search), None)
            }
            Some(_) => ((surface, None), spilled),
            None => (self.derivatives_from(surface, octaves, search), None),
        };
        let spilled = spilled.unwrap_or_else(I::Sum::empty);
        (surfaces.0.integral_after(spilled, integrand), surfaces)
    }

    fn values_from(&self, plain: CutSurface<'a, T>) -> CutSurface<'a, T> {
        if !plain.has_polygons_on_faces() {
            return plain;
        }
        // Culling finds all slivers. Following might miss some, because the edges that connect them are shorter than round-off.
        let everywhere = Search::Culling(Culling::default());
        let surface = self.within(ELASTIC_COINCIDENCE.cast_signed(), everywhere);
        let tolerance = (ELASTIC_COINCIDENCE, false);
        self.settled(surface, tolerance, everywhere, || plain).0
    }

    fn derivatives_from(
        &self,
        surface: CutSurface<'a, T>,
        octaves: u32,
        search: Search,
    ) -> Surfaces<'a, T> {
        self.settled(surface, (octaves, true), search, || self.for_values(search))
    }

    /// Returns the surface in which faces within 2^octaves margins of each other count as coincident. If there are such faces, also returns
    /// the finer surface. The number of octaves changes in two cases:
    ///
    /// - This number would merge distinct corners (see [`NearZeroHistogram::split`]). If `merges`, the new number still merges some corners
    ///   that are nearly coincident.
    /// - This number would take the load for zero, although the bodies do not just touch. The tolerance is then narrowed, at most to the
    ///   margin that values use. Other changes of the load are allowed: if the load jumps as faces pass each other, the derivatives belong
    ///   to neither side.
    ///
    /// Near coincidences of cuts that do not count are included, because a polygon may vanish if its corners count as on the plane.
    ///
    /// [`NearZeroHistogram::split`]: crate::geometry::NearZeroHistogram::split
    fn settled(
        &self,
        surface: CutSurface<'a, T>,
        (octaves, merges): (u32, bool),
        search: Search,
        finer: impl FnOnce() -> CutSurface<'a, T>,
    ) -> Surfaces<'a, T> {
        if !surface.search_result.noted_closeness().is_within(octaves) {
            return (surface, None);
        }
        let finer = finer();
        let closeness = [&surface, &finer].map(|either| either.search_result.closeness());
        let Some(closeness) = closeness.into_iter().find(|near| near.is_within(octaves)) else {
            return (surface, Some(finer));
        };
        let most_discarded = MAX_DISCARDED_LOAD[usize::from(merges)] * finer.load();
        let leaves_load = |octaves: &i32| finer.load_at_zero(*octaves) <= most_discarded;
        let split = closeness.split(octaves, merges);
        let mut narrower = (1..=split).rev().step_by(NARROWER);
        let split = narrower.find(leaves_load).unwrap_or(split.min(0));
        if split == octaves.cast_signed() {
            return (surface, Some(finer));
        }
        (self.within(split, search), Some(finer))
    }

    fn within(&self, octaves: i32, search: Search) -> CutSurface<'a, T> {
        let source = self.with_near_coincidences(octaves);
        CutSurface {
            search_result: source.pair.find_pairs(search),
            source,
        }
    }

    /// Finds the surface and integrates over the octets that are spilled. Returns no integral if no octets are spilled.
    pub fn integrated_within<I: Integrand<T>>(
        &self,
        octaves: i32,
        search: Search,
        integrand: &I,
    ) -> (CutSurface<'a, T>, Option<I::Sum>) {
        if carries_derivatives::<T>() || !I::IS_SPILLED {
            return (self.within(octaves, search), None);
        }
        let (source, mut sum) = (self.with_near_coincidences(octaves), None);
        let search_result = source.pair.find_spilling(search, &mut |generic| {
            let sum = sum.get_or_insert_with(I::Sum::empty);
            source.add_generic(generic, integrand, sum);
        });
        (
            CutSurface {
                source,
                search_result,
            },
            sum,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::{ContactBody, ContactPair, Shape};
    use crate::mesh::shapes;
    use crate::narrow_phase::COINCIDENCE;
    use crate::spatial::Pose;
    use nalgebra::vector;

    /// Rounding of a depth of 1.5 margins, which is about 1e-13 of the height of the upper cube.
    const ROUNDING: f64 = 1e-2;

    /// Returns the distance (m) within which faces count as coincident for derivatives, the same for values, and the depth by which the
    /// bodies are pressed in: two cubes, by this number of margins.
    fn tolerances(octaves: u32, margins: f64) -> [f64; 3] {
        let cube = Shape::new(shapes::cuboid([1.0; 3]).unwrap());
        let body = |height: f64| {
            let pose = Pose::from_translation(vector![0.1, 0.2, 1.0].scale(height));
            ContactBody::new(&cube, pose, 1.0).unwrap()
        };
        let margin = |upper: ContactBody| ContactPair::new(upper, body(0.0)).source().pair.margin();
        let depth = margins * margin(body(1.0));
        let pose = Pose::from_translation(vector![0.1, 0.2, 1.0 - depth]);
        let upper = ContactBody::new(&cube, pose, 1.0).unwrap();
        let pair = ContactPair::new(upper, body(0.0));
        let source = pair.source();
        let (surface, _) = source.for_derivatives(octaves, pair.search());
        [surface.source.pair.margin(), source.pair.margin(), depth]
    }

    /// The pressure at half the depth is compared with the tolerance, which has steps of three octaves.
    #[test]
    fn faces_count_as_coincident_within_what_bodies_are_pressed_in_by_and_not_only_within_much_less()
     {
        for octaves in [ELASTIC_COINCIDENCE, COINCIDENCE] {
            for margins in [1.5, 3.0, 5.0, 10.0, 30.0, 1e2, 3e2, 1e3, 3e3, 1e4, 3e4, 1e6] {
                let [search_resultance, least, depth] = tolerances(octaves, margins);
                let most = least * f64::from(1 << octaves);
                assert!((least..=most).contains(&search_resultance), "{margins:e}");
                assert!(search_resultance <= depth.max(least), "{margins:e}");
                let sixteenth = depth / 16.0 * (1.0 - ROUNDING);
                assert!(search_resultance >= sixteenth.min(most), "{margins:e}");
            }
        }
    }
}
