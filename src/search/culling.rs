use crate::broad_phase::Projections;

/// How pairs of tetrahedra that cannot touch are left out: the four optimizations of the paper,
/// §IV, each with its own switch. They change the time a wrench takes, never the wrench.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Culling {
    /// Leave out pairs whose bounding boxes, in A's axes, are apart (§IV-A).
    pub bounding_boxes: bool,
    /// Leave out pairs of which one lies all on one side of the equilibrium plane (§IV-B).
    pub plane_check: bool,
    /// Find the pairs whose boxes overlap with R\*-trees instead of trying all pairs (§IV-C); this
    /// includes `bounding_boxes`.
    pub tree: bool,
    /// Leave out pairs that one of so many fixed directions separates (§IV-D); at most
    /// [`Projections::COUNT`] are tried.
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
