use crate::broad_phase::Projections;

/// How pairs of tetrahedra that cannot touch are left out: the four optimizations of the paper, §IV, each with its own
/// switch. They change the time that a wrench takes, and the wrench by no more than round-off.
///
/// On a half-space, which is one cell without end, there are no boxes and projections. `tree` leaves out the tetrahedra of A
/// that its surface does not cut or, if it is soft, that lie above it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Culling {
    /// Leave out pairs whose bounding boxes, in A's axes, are apart (§IV-A).
    pub bounding_boxes: bool,
    /// Leave out pairs of which one tetrahedron lies all on one side of the equilibrium plane (§IV-B).
    pub plane_check: bool,
    /// Find the pairs whose boxes overlap with R\*-trees instead of trying all pairs (§IV-C); this
    /// includes `bounding_boxes`.
    pub tree: bool,
    /// How many fixed directions are tried, at most [`Projections::COUNT`]: pairs that one of them separates are left out
    /// (§IV-D).
    pub projections: usize,
}

impl Culling {
    /// Every pair of tetrahedra goes through slicing and clipping: row (a) of the paper's Table I.
    pub const NONE: Self = Self {
        bounding_boxes: false,
        plane_check: false,
        tree: false,
        projections: 0,
    };
}

impl Default for Culling {
    /// The fastest combination: everything, with all [`Projections::COUNT`] directions. Most pairs
    /// whose boxes overlap have nothing in common, and a projection costs two comparisons.
    fn default() -> Self {
        Self {
            bounding_boxes: true,
            plane_check: true,
            tree: true,
            projections: Projections::COUNT,
        }
    }
}
