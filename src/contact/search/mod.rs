//! Which pairs of tetrahedra meet: by following the contact surface, or by culling all pairs.

mod culling;
mod following;
mod scratch;
mod trees;

pub use culling::Culling;

use super::meeting::{Encounter, Meeting};
use super::shadow::{PairShadow, PosedTet};

/// How the pairs of tetrahedra that touch are found. It changes the time a wrench takes, never the
/// wrench.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Search {
    /// From where the contact surface shows on the surfaces of the bodies, from each polygon to its
    /// neighbours; where the meshes or the pose do not allow it, by culling as well.
    #[default]
    Following,
    /// By leaving out pairs of tetrahedra that cannot touch, as the paper does (§IV).
    Culling(Culling),
}

impl PairShadow<'_> {
    /// Visits the pairs of tetrahedra with a contact polygon, each once. Returns the number of pairs
    /// that were looked at.
    pub fn visit_meetings(&self, search: Search, mut visit: impl FnMut(&Meeting)) -> usize {
        match search {
            Search::Following => self.follow(&mut visit),
            Search::Culling(culling) => {
                let mut count = 0;
                self.visit_candidates(culling, |tet_a, tet_b: &PosedTet| {
                    count += 1;
                    let encounter = self.encounter(self.tet_a(tet_a), tet_b, culling.plane_check);
                    if let Encounter::Meeting(meeting) = encounter
                        && meeting.is_polygon
                    {
                        visit(&meeting);
                    }
                });
                count
            }
        }
    }

    /// As [`Self::visit_candidates`], for the pairs whose boxes overlap.
    pub fn visit_overlapping(&self, visit: impl FnMut(usize, &PosedTet)) {
        self.visit_candidates(Culling::default(), visit);
    }
}
