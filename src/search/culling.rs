use crate::broad_phase::Projections;

/// The steps that leave out pairs of tetrahedra that cannot touch: the four optimizations of the paper, §IV. They change the time that a
/// wrench takes, and the wrench by rounding errors only.
///
/// A half-space is one infinite cell and has no boxes and projections. `tree` leaves out the tetrahedra of A that its surface does not cut
/// or, if it is soft, that lie above it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Culling {
    /// Leave out pairs whose bounding boxes, in A's axes, are apart (§IV-A).
    pub bounding_boxes: bool,
    /// Leave out pairs of which one tetrahedron lies on one side of the equilibrium plane (§IV-B).
    pub plane_check: bool,
    /// Find the pairs whose boxes overlap with R\*-trees instead of trying all pairs (§IV-C); this
    /// includes `bounding_boxes`.
    pub tree: bool,
    /// Number of fixed directions that are tried, at most [`Projections::COUNT`]. Pairs that a direction separates are left out
    /// (§IV-D).
    pub projections: usize,
}

impl Culling {
    /// Slices and clips every pair of tetrahedra: row (a) of the paper's Table I.
    pub const NONE: Self = Self {
        bounding_boxes: false,
        plane_check: false,
        tree: false,
        projections: 0,
    };
}

impl Default for Culling {
    /// The fastest combination: all steps, with all [`Projections::COUNT`] directions. Most pairs whose boxes overlap do not touch, and a
    /// projection costs two comparisons.
    fn default() -> Self {
        Self {
            bounding_boxes: true,
            plane_check: true,
            tree: true,
            projections: Projections::COUNT,
        }
    }
}
