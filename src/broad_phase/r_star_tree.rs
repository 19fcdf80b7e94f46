use crate::geometry::Aabb;
use crate::mesh::PressureField;
use crate::spatial::Pose;
use rstar::{AABB, ParentNode, RTree, RTreeNode, RTreeObject};
use std::ops::ControlFlow;

/// The R\*-tree of the boxes of a mesh's tetrahedra in the body frame, without inert tetrahedra
/// (the paper, §IV-C).
///
/// Only culling uses it ([`Culling::tree`](crate::contact::Culling::tree)). All other searches use
/// a bounding-volume hierarchy.
#[derive(Debug, Clone)]
pub struct RStarTree(RTree<TetBox>);

/// The box of a tetrahedron.
#[derive(Debug, Clone)]
struct TetBox {
    envelope: AABB<[f64; 3]>,
    tet: usize,
}

impl RTreeObject for TetBox {
    type Envelope = AABB<[f64; 3]>;

    fn envelope(&self) -> Self::Envelope {
        self.envelope
    }
}

impl RStarTree {
    /// Bulk-loads the tree: O(n log n).
    #[must_use]
    pub fn new(field: &PressureField) -> Self {
        let tets = field.tets().iter().enumerate();
        let pressing = tets.filter(|(_, tet)| !tet.is_inert());
        let boxes = pressing.map(|(tet, of)| TetBox {
            envelope: envelope(&of.tetrahedron.aabb()),
            tet,
        });
        Self(RTree::bulk_load(boxes.collect()))
    }

    /// Visits the tetrahedra whose boxes overlap `query` (both in the body frame).
    pub fn visit_overlapping(&self, query: &Aabb, mut visit: impl FnMut(usize)) {
        // The visitor never breaks, so the result carries no value.
        let _: ControlFlow<()> =
            (self.0).locate_in_envelope_intersecting_int(envelope(query), |leaf| {
                visit(leaf.tet);
                ControlFlow::Continue(())
            });
    }

    /// Visits the tetrahedra (of B) that may overlap the box `region` in the frame of A, to within
    /// `margin` (m). A tetrahedron is skipped if a face separates the region from its box, or from
    /// a box around it in the tree.
    pub fn visit_near(
        &self,
        region: &Aabb,
        pose_ab: &Pose<f64>,
        margin: f64,
        mut visit: impl FnMut(usize),
    ) {
        let is_near = |child: &RTreeNode<TetBox>| {
            let envelope = child.envelope();
            let aabb = Aabb {
                lower: envelope.lower().into(),
                upper: envelope.upper().into(),
            };
            region.may_overlap_posed(&aabb, pose_ab, margin)
        };
        descend(self.0.root(), &is_near, &mut visit);
    }
}

fn envelope(aabb: &Aabb) -> AABB<[f64; 3]> {
    AABB::from_corners(aabb.lower.into(), aabb.upper.into())
}

/// Visits the leaves below a node that are near, and enters near nodes only.
fn descend(
    node: &ParentNode<TetBox>,
    is_near: &impl Fn(&RTreeNode<TetBox>) -> bool,
    visit: &mut impl FnMut(usize),
) {
    for child in node.children().iter().filter(|child| is_near(child)) {
        match child {
            RTreeNode::Leaf(leaf) => visit(leaf.tet),
            RTreeNode::Parent(parent) => descend(parent, is_near, visit),
        }
    }
}
