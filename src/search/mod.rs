//! Finds the pairs of tetrahedra that the plane of equal pressure cuts, by following the contact surface or by culling all pairs.
//!
//! `following` walks over the contact surface. `seeding` and `extremal_pairs` find the pairs at which the walk starts. `culled_pairs` tests
//! all pairs that a [`Culling`] keeps, and finds the pairs near a place for the walk. Both write their cuts to the `scratch` memory
//! of the thread.
//!
//! # Seeds
//!
//! The walk starts at *seeds*. Every component of the contact surface contains at least one:
//!
//! - the pairs of surface triangles that cross, for components with a boundary (`broad_phase::crossings`);
//! - the tetrahedra on paths of edges from the peaks of concave fields to the surface, for closed components between such fields, for
//!   example those of the ready-made convex shapes (`seeds::peak_paths` has the proof);
//! - the pairs where the component may be extremal in a direction, for closed components between other fields, for example those of
//!   meshes from a mesher. A descent into both trees of tetrahedra finds them with bounds on the fields (`extremal_pairs` has the proof);
//! - one triangle of each component of a rigid surface, because a closed component on a rigid body is such a component, inside A.
//!
//! Both methods for closed components between fields require only that the fields are positive inside
//! ([`Shape::followed`](crate::contact_shape::Shape::followed)). Half-spaces have no mesh to walk over: the tree of A gives the tetrahedra
//! that the surface of the half-space cuts or, if it is soft, that reach below it.
//!
//! If rounding errors decide how the surface continues, the walk also tests all pairs within the rounding error of the polygon. The search
//! tests all pairs that neither boxes nor projections separate if a field is zero inside, or if the walk meets equal fields or too many
//! ill-conditioned pairs.

#![expect(
    clippy::cast_possible_truncation,
    reason = "a mesh has no more tetrahedra than a u32 counts"
)]

mod culled_pairs;
mod culling;
mod extremal_pairs;
mod following;
mod generic;
mod neighbor_pairs;
mod normals;
mod scratch;
mod seeding;
mod visited;

pub use culling::Culling;

use crate::geometry::NearZeroHistogram;
use crate::narrow_phase::{Cut, RelativePair};
use following::Spill;
pub(crate) use generic::GenericPairs;
use scratch::Scratch;

/// Method that finds the pairs of tetrahedra that touch. It changes the time that a wrench takes, and the wrench by rounding errors
/// only.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Search {
    /// Walks from each contact polygon to its neighbors. The walk starts at pairs of which every component of the contact surface
    /// contains one. A component with a boundary starts where the surfaces of both bodies cross. A closed component on a rigid
    /// body starts at one triangle of each component of the body's surface. Any other closed component starts on a path from the peak
    /// of a concave field to the surface, or where the component may be extremal in a direction.
    ///
    /// Culls all pairs on half-spaces, and where the walk could miss something
    /// ([`Shape::followed`](crate::contact::Shape::followed)).
    #[default]
    Following,
    /// Leaves out pairs of tetrahedra that cannot touch and tests all others, as the paper does (§IV).
    Culling(Culling),
}

/// Result of a search. When it is dropped, its memory goes to the next search of the thread.
pub(crate) struct SearchResult {
    scratch: Scratch,
    /// Number of pairs of tetrahedra that were looked at.
    pub candidates: usize,
}

impl SearchResult {
    /// Returns the cuts that are not [generic](Self::generic): those that count, those that do not count only because of rounding
    /// errors, and those where faces only touch. Each cut appears once, always in the same order.
    pub fn cuts(&self) -> &[Cut] {
        &self.scratch.cuts
    }

    /// Returns the generic pairs, without those that were spilled.
    pub fn generic(&self) -> GenericPairs<'_> {
        GenericPairs::new(self.scratch.octets.in_use(), &self.scratch.posed_tets)
    }

    /// Returns whether there is no cut.
    pub fn is_empty(&self) -> bool {
        self.cuts().is_empty() && !self.generic().have_polygons()
    }

    /// Returns the pairs of tetrahedra in which both pressures have the same gradient and are nearly equal. They need not overlap.
    pub fn equal_fields(&self) -> &[[usize; 2]] {
        &self.scratch.equal
    }

    /// Returns the distances of corners from planes in the cuts that count.
    pub fn closeness(&self) -> NearZeroHistogram {
        self.of_all(Cut::counts, Cut::closeness)
    }

    /// Returns the distances of corners from planes in all cuts.
    pub fn noted_closeness(&self) -> NearZeroHistogram {
        self.of_all(|_| true, Cut::closeness)
    }

    /// Returns the distances of whole polygons from faces of B.
    pub fn coplanarity(&self) -> NearZeroHistogram {
        self.of_all(Cut::counts, Cut::coplanarity)
    }

    fn of_all(
        &self,
        is_asked: fn(&Cut) -> bool,
        of: fn(&Cut) -> NearZeroHistogram,
    ) -> NearZeroHistogram {
        let asked = self.cuts().iter().filter(|&cut| is_asked(cut));
        asked
            .map(of)
            .fold(NearZeroHistogram::default(), NearZeroHistogram::or)
    }
}

impl Drop for SearchResult {
    fn drop(&mut self) {
        std::mem::take(&mut self.scratch).release();
    }
}

impl RelativePair<'_> {
    /// Finds the pairs of tetrahedra that the plane of equal pressure cuts.
    pub fn find_pairs(&self, search: Search) -> SearchResult {
        self.find_or_spill(search, None)
    }

    /// Finds the pairs as [`Self::find_pairs`]. In large contacts, octets go to `spill` as soon as they are cut, and the result has only
    /// the last octets.
    pub fn find_spilling(&self, search: Search, spill: &mut Spill) -> SearchResult {
        self.find_or_spill(search, Some(spill))
    }

    fn find_or_spill(&self, search: Search, spill: Option<&mut Spill>) -> SearchResult {
        let mut scratch = Scratch::acquire();
        let candidates = match search {
            Search::Following => self.follow(&mut scratch, spill.map(|spill| spill as _)),
            Search::Culling(culling) => self.cull(culling, &mut scratch),
        };
        SearchResult {
            scratch,
            candidates,
        }
    }
}
