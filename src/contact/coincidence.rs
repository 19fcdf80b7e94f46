//! What counts as coincident in the surfaces that values and derivatives are made from.
//!
//! A corner is on a plane if it is within a margin, the rounding of coordinates. Values use this margin. A single margin for values and
//! derivatives was tried: derivatives were wrong in the tests `flush_motion` and `coincidence`. A single margin is not enough in these
//! cases:
//!
//! - *Faces that miss each other by about a margin.* Some corners count as on the plane and others do not, so polygons with weight ½
//!   have no partner. Derivatives therefore use a wider tolerance ([`COINCIDENCE`](crate::narrow_phase::COINCIDENCE),
//!   [`ELASTIC_COINCIDENCE`]). It is placed in a gap of the distances to coincidence, if there is one
//!   ([`NearZeroHistogram::split`](crate::geometry::NearZeroHistogram::split)), so that its own edge does not separate the corners of a face.
//! - *Nearly equal fields.* A force jumps within a very small distance, and the derivative within this distance is far larger than the
//!   slope that a longer step sees. The wider tolerance gives the mean of both sides.
//! - *Bodies that are pressed in by less than the tolerance.* The wider tolerance would take their pressure for zero. It is narrowed
//!   until the load stays (`CutSurface::load_at_zero`).
//! - *A whole polygon near a face of B.* Neighbors beyond the face would both count it, or neither. Values use a wider tolerance too,
//!   placed and narrowed in the same way: with a fixed one the force jumps at its edge.

use super::integrate::{CutSurface, Integrand};
use super::polygon_source::PolygonSource;
use super::sums::PartialSum;
use super::{Culling, Search};
use crate::narrow_phase::ELASTIC_COINCIDENCE;
use crate::scalar::{Scalar, carries_derivatives};

/// Largest fraction of the load that may count as zero.
const MAX_DISCARDED_LOAD: f64 = 1e-6;

/// Octaves by which the tolerance is narrowed at a time while more of the load would count as zero.
const NARROWER: usize = 3;

/// The surface that derivatives are made from and, if it may be another, that for values.
pub(super) type Surfaces<'a, T> = (CutSurface<'a, T>, Option<CutSurface<'a, T>>);

impl<'a, T: Scalar> PolygonSource<'a, T> {
    /// The surface that values are made from.
    pub fn for_values(&self, search: Search) -> CutSurface<'a, T> {
        self.values_from(self.within(0, search))
    }

    /// Integrates over the surface that values are made from. Of a large surface, octets are integrated as soon as they are found.
    pub fn integral_for_values<I: Integrand<T>>(&self, search: Search, integrand: &I) -> I::Sum {
        let (surface, spilled) = self.integrated_within(0, search, integrand);
        let (surface, spilled) = match spilled {
            // Rare: repeating the search is cheaper than keeping the octets of every large contact.
            Some(_) if surface.has_polygons_on_faces() => (self.for_values(search), None),
            Some(_) => (surface, spilled),
            None => (self.values_from(surface), None),
        };
        surface.integral_after(spilled.unwrap_or_else(I::Sum::empty), integrand)
    }

    /// The surface that derivatives are made from. That for values as well, if it may be another.
    pub fn for_derivatives(&self, octaves: u32, search: Search) -> Surfaces<'a, T> {
        let surface = self.within(octaves.cast_signed(), search);
        self.derivatives_from(surface, octaves, search)
    }

    /// Integrates over the surface that derivatives are made from, in the same way. Returns the surfaces of [`Self::for_derivatives`]
    /// too; the first lacks the octets that were spilled.
    pub fn integral_for_derivatives<I: Integrand<T>>(
        &self,
        octaves: u32,
        search: Search,
        integrand: &I,
    ) -> (I::Sum, Surfaces<'a, T>) {
        let (surface, spilled) = self.integrated_within(octaves.cast_signed(), search, integrand);
        let (surfaces, spilled) = match spilled {
            Some(_) if surface.found.noted_closeness().is_within(octaves) => {
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

    /// The surface where faces within 2^octaves margins of each other count as coincident. The octaves are others where that
    /// many would merge distinct corners (see [`NearZeroHistogram::split`]), but still some that are nearly coincident, if `merges`. They are fewer where they would take the load for zero:
    /// bodies that are pressed in by less do not just touch. For this they are narrowed down to the margin, which values are
    /// made with. Otherwise the load may change: where it jumps as faces pass
    /// each other, the derivatives belong to neither side.
    ///
    /// If there are such faces, gives the finer surface as well. They are looked for in cuts that do not count, too: where corners
    /// are taken to be on the plane, nothing may be left of a polygon.
    ///
    /// [`NearZeroHistogram::split`]: crate::geometry::NearZeroHistogram::split
    fn settled(
        &self,
        surface: CutSurface<'a, T>,
        (octaves, merges): (u32, bool),
        search: Search,
        finer: impl FnOnce() -> CutSurface<'a, T>,
    ) -> Surfaces<'a, T> {
        if !surface.found.noted_closeness().is_within(octaves) {
            return (surface, None);
        }
        let finer = finer();
        let closeness = [&surface, &finer].map(|either| either.found.closeness());
        let Some(closeness) = closeness.into_iter().find(|near| near.is_within(octaves)) else {
            return (surface, Some(finer));
        };
        let load = finer.load();
        let leaves_load = |octaves: &i32| finer.load_at_zero(*octaves) <= MAX_DISCARDED_LOAD * load;
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
            found: source.pair.found(search),
            source,
        }
    }

    /// Finds the surface and integrates over the octets that are spilled. Returns no integral if none are.
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
        let found = source.pair.found_spilling(search, &mut |generic| {
            let sum = sum.get_or_insert_with(I::Sum::empty);
            source.add_generic(generic, integrand, sum);
        });
        (CutSurface { source, found }, sum)
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

    /// Rounding of a depth of 1.5 margins, which is some 1e-13 of the height that the upper cube is placed at.
    const ROUNDING: f64 = 1e-2;

    /// How far apart (m) faces may be that count as coincident, for derivatives; the same for values; and how deep the bodies are
    /// pressed in: cubes, by so many margins.
    fn tolerances(octaves: u32, margins: f64) -> [f64; 3] {
        let cube = Shape::new(shapes::cuboid([1.0; 3]).unwrap());
        let body = |height: f64| {
            let place = Pose::from_translation(vector![0.1, 0.2, 1.0].scale(height));
            ContactBody::new(&cube, place, 1.0).unwrap()
        };
        let margin = |upper: ContactBody| ContactPair::new(upper, body(0.0)).source().pair.margin();
        let depth = margins * margin(body(1.0));
        let place = Pose::from_translation(vector![0.1, 0.2, 1.0 - depth]);
        let upper = ContactBody::new(&cube, place, 1.0).unwrap();
        let pair = ContactPair::new(upper, body(0.0));
        let source = pair.source();
        let (surface, _) = source.for_derivatives(octaves, pair.search());
        [surface.source.pair.margin(), source.pair.margin(), depth]
    }

    /// It is the pressure half as deep that is held against the tolerance, of which there is one every three octaves.
    #[test]
    fn faces_count_as_coincident_within_what_bodies_are_pressed_in_by_and_not_only_within_much_less()
     {
        for octaves in [ELASTIC_COINCIDENCE, COINCIDENCE] {
            for margins in [1.5, 3.0, 5.0, 10.0, 30.0, 1e2, 3e2, 1e3, 3e3, 1e4, 3e4, 1e6] {
                let [found, least, depth] = tolerances(octaves, margins);
                let most = least * f64::from(1 << octaves);
                assert!((least..=most).contains(&found), "{margins:e}");
                assert!(found <= depth.max(least), "{margins:e}");
                let sixteenth = depth / 16.0 * (1.0 - ROUNDING);
                assert!(found >= sixteenth.min(most), "{margins:e}");
            }
        }
    }
}
