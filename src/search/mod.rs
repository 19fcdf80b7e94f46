//! Which pairs of tetrahedra are cut by the plane of equal pressure: by following the contact surface, or by culling all
//! pairs.

#![expect(
    clippy::cast_possible_truncation,
    reason = "a mesh has no more tetrahedra than a u32 counts"
)]

mod culling;
mod following;
mod scratch;
mod seeding;
mod trees;
mod turns;

pub use culling::Culling;

use crate::geometry::Closeness;
use crate::narrow_phase::{Cut, RelativePair};
use scratch::Scratch;

/// How the pairs of tetrahedra that touch are found. It changes the time a wrench takes, and the wrench by
/// no more than round-off.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Search {
    /// From where every component of the contact surface must show (at its rim, or on the way from the
    /// peaks and creases of a field to the body's surface), from each polygon to its neighbors; where
    /// the meshes or the pose do not allow it, by culling as well.
    #[default]
    Following,
    /// By leaving out pairs of tetrahedra that cannot touch, as the paper does (§IV).
    Culling(Culling),
}

/// What a search found. Its memory goes to the thread's next search when it is dropped.
pub(crate) struct Found {
    scratch: Scratch,
    /// Number of pairs of tetrahedra that were looked at.
    pub candidates: usize,
}

impl Found {
    /// The cuts that count, or would but for a little, each once and always in the same order.
    pub fn cuts(&self) -> &[Cut] {
        &self.scratch.cuts
    }

    /// How near to each other corners and planes are in those that count.
    pub fn closeness(&self) -> Closeness {
        self.of_all(Cut::counts, Cut::closeness)
    }

    /// The same in all of them.
    pub fn noted_closeness(&self) -> Closeness {
        self.of_all(|_| true, Cut::closeness)
    }

    /// How near polygons are, all over, to faces.
    pub fn flatness(&self) -> Closeness {
        self.of_all(Cut::counts, Cut::flatness)
    }

    fn of_all(&self, is_asked: fn(&Cut) -> bool, of: fn(&Cut) -> Closeness) -> Closeness {
        let asked = self.cuts().iter().filter(|&cut| is_asked(cut));
        asked.map(of).fold(Closeness::default(), Closeness::or)
    }
}

impl Drop for Found {
    fn drop(&mut self) {
        std::mem::take(&mut self.scratch).left();
    }
}

impl RelativePair<'_> {
    /// Finds the pairs of tetrahedra that the plane of equal pressure cuts.
    pub fn found(&self, search: Search) -> Found {
        let mut scratch = Scratch::taken();
        let candidates = match search {
            Search::Following => self.follow(&mut scratch),
            Search::Culling(culling) => self.cull(culling, &mut scratch.cuts),
        };
        Found {
            scratch,
            candidates,
        }
    }
}
