//! Which pairs of tetrahedra are cut by the plane of equal pressure: by following the contact surface, or by culling all
//! pairs.
//!
//! `following` walks over the contact surface from where `seeding` and `extremal_pairs` enter it; `culled_pairs` looks at all pairs
//! that a [`Culling`] leaves over, and serves the walk where it has to look around. Both leave their cuts in the `scratch`
//! memory of the thread.

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

/// How the pairs of tetrahedra that touch are found. It changes the time that a wrench takes, and the wrench by no more than
/// round-off.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Search {
    /// From each contact polygon to its neighbors, from where every component of the contact surface must show: at its boundary,
    /// where the surfaces of both bodies cross, or, without a boundary, at a component of B's surface if B is rigid, and else
    /// on the way from the peaks of concave fields to the surface, or where the component turns around. Where meshes or pose do not allow it
    /// ([`Shape::followed`](crate::contact::Shape::followed)), and on half-spaces, by culling.
    #[default]
    Following,
    /// By leaving out pairs of tetrahedra that cannot touch, as the paper does (§IV).
    Culling(Culling),
}

/// What a search found. Its memory goes to the thread's next search when it is dropped.
pub(crate) struct SearchResult {
    scratch: Scratch,
    /// Number of pairs of tetrahedra that were looked at.
    pub candidates: usize,
}

impl SearchResult {
    /// Cuts that count and are not [generic](Self::generic), cuts that do not count only because of round-off, and cuts where faces
    /// only touch. Each cut appears once, always in the same order.
    pub fn cuts(&self) -> &[Cut] {
        &self.scratch.cuts
    }

    /// The generic pairs, without those that were spilled.
    pub fn generic(&self) -> GenericPairs<'_> {
        GenericPairs::new(self.scratch.octets.in_use(), &self.scratch.posed_tets)
    }

    /// Whether there is no cut at all.
    pub fn is_empty(&self) -> bool {
        self.cuts().is_empty() && !self.generic().have_polygons()
    }

    /// The pairs of tetrahedra in which both pressures have one gradient and come near each other, whether they overlap or not.
    pub fn equal_fields(&self) -> &[[usize; 2]] {
        &self.scratch.equal
    }

    /// How near corners are to planes in the cuts that count.
    pub fn closeness(&self) -> NearZeroHistogram {
        self.of_all(Cut::counts, Cut::closeness)
    }

    /// The same in all of them.
    pub fn noted_closeness(&self) -> NearZeroHistogram {
        self.of_all(|_| true, Cut::closeness)
    }

    /// How near whole polygons are to faces of B.
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
    pub fn found(&self, search: Search) -> SearchResult {
        self.found_or_spilled(search, None)
    }

    /// As [`Self::found`]; but where they are many, octets go to `spill`, as soon as they were looked at, and only the last are
    /// among what was found.
    pub fn found_spilling(&self, search: Search, spill: &mut Spill) -> SearchResult {
        self.found_or_spilled(search, Some(spill))
    }

    fn found_or_spilled(&self, search: Search, spill: Option<&mut Spill>) -> SearchResult {
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
