//! Which pairs of tetrahedra meet: by following the contact surface, or by culling all pairs.

#![expect(
    clippy::cast_possible_truncation,
    reason = "a mesh has no more tetrahedra than a u32 counts"
)]

mod culling;
mod following;
mod scratch;
mod seeding;
mod trees;

pub use culling::Culling;

use crate::narrow_phase::Meeting;
use crate::narrow_phase::RelativePair;

/// How the pairs of tetrahedra that touch are found. It changes the time a wrench takes, and the wrench by
/// no more than round-off.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Search {
    /// From where every component of the contact surface must show (at its rim, or on the way from the
    /// peaks and creases of a field to the body's surface), from each polygon to its neighbours; where
    /// the meshes or the pose do not allow it, by culling as well.
    #[default]
    Following,
    /// By leaving out pairs of tetrahedra that cannot touch, as the paper does (§IV).
    Culling(Culling),
}

/// Something that is added up over a contact surface: pieces of it are summed by themselves, and
/// merged in their order.
pub(crate) trait PartialSum: Send {
    /// The sum of nothing.
    fn empty() -> Self;

    /// Adds the next piece.
    fn merge(&mut self, next: Self);
}

impl<U: Send> PartialSum for Vec<U> {
    fn empty() -> Self {
        Vec::new()
    }

    fn merge(&mut self, mut next: Self) {
        self.append(&mut next);
    }
}

impl PartialSum for usize {
    fn empty() -> Self {
        0
    }

    fn merge(&mut self, next: Self) {
        *self += next;
    }
}

/// What a search came to.
pub(crate) struct Found<S> {
    pub sum: S,
    /// Number of pairs of tetrahedra that were looked at.
    pub candidates: usize,
}

impl RelativePair<'_> {
    /// Adds up the pairs of tetrahedra that have a contact polygon, each once and always in the same
    /// order.
    pub fn sum_meetings<S: PartialSum>(
        &self,
        search: Search,
        add: impl Fn(&mut S, &Meeting) + Sync,
    ) -> Found<S> {
        match search {
            Search::Following => self.follow(add),
            Search::Culling(culling) => self.cull(culling, add),
        }
    }
}
