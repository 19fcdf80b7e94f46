use super::Projections;
use crate::geometry::Aabb;
use crate::mesh::PressureField;
use crate::spatial::Pose;
use nalgebra::Vector3;
use rstar::{AABB, ParentNode, RTree, RTreeNode, RTreeObject};
use std::ops::ControlFlow;

/// The R\*-tree of a mesh's tetrahedra, by their boxes in the body frame.
#[derive(Debug, Clone)]
pub struct TetTree {
    tree: RTree<TetBox>,
    bounds: Aabb,
    projections: Vec<Projections>,
}

/// The box of one tetrahedron.
#[derive(Debug, Clone)]
struct TetBox {
    lower: [f64; 3],
    upper: [f64; 3],
    tet: u32,
}

impl RTreeObject for TetBox {
    type Envelope = AABB<[f64; 3]>;

    fn envelope(&self) -> Self::Envelope {
        AABB::from_corners(self.lower, self.upper)
    }
}

impl TetTree {
    /// Bulk-loads the tree: O(n log n), once per mesh. Inert tetrahedra are left out.
    #[must_use]
    pub fn new(field: &PressureField) -> Self {
        let tets = field.tets();
        let active = (0_u32..).zip(tets).filter(|(_, tet)| !tet.is_inert());
        let boxes = active.map(|(tet, field_tet)| {
            let Aabb { lower, upper } = field_tet.tetrahedron.aabb();
            TetBox {
                lower: lower.into(),
                upper: upper.into(),
                tet,
            }
        });
        Self {
            tree: RTree::bulk_load(boxes.collect()),
            bounds: field.mesh().aabb(),
            projections: tets
                .iter()
                .map(|tet| Projections::of(&tet.tetrahedron))
                .collect(),
        }
    }

    /// The box around all tetrahedra, in the body frame.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// The projections of a tetrahedron, in the body frame.
    #[must_use]
    pub fn projections(&self, tet: usize) -> &Projections {
        &self.projections[tet]
    }

    /// Visits the tetrahedra whose boxes overlap `query` (both in the body frame).
    pub fn visit_overlapping(&self, query: &Aabb, mut visit: impl FnMut(usize)) {
        let envelope = AABB::from_corners(query.lower.into(), query.upper.into());
        // Never breaks off, so there is nothing in the result.
        let _: ControlFlow<()> = self
            .tree
            .locate_in_envelope_intersecting_int(envelope, |found| {
                visit(found.tet as usize);
                ControlFlow::Continue(())
            });
    }

    /// Visits the tetrahedra (of B) that may overlap the box `region` in the frame of A, given to
    /// within `margin` (m): all those whose own box, or a box around it in the tree, is not
    /// separated from the region by a face of either.
    pub fn visit_near(
        &self,
        region: &Aabb,
        pose_ab: &Pose<f64>,
        margin: f64,
        mut visit: impl FnMut(usize),
    ) {
        let is_near = |envelope: &AABB<[f64; 3]>| {
            let own = Aabb {
                lower: Vector3::from(envelope.lower()),
                upper: Vector3::from(envelope.upper()),
            };
            region.may_overlap_posed(&own, pose_ab, margin)
        };
        descend(self.tree.root(), &is_near, &mut visit);
    }
}

/// Visits the leaves below a node that are near, entering near nodes only.
fn descend(
    node: &ParentNode<TetBox>,
    is_near: &impl Fn(&AABB<[f64; 3]>) -> bool,
    visit: &mut impl FnMut(usize),
) {
    for child in node.children() {
        match child {
            RTreeNode::Leaf(leaf) if is_near(&leaf.envelope()) => visit(leaf.tet as usize),
            RTreeNode::Parent(parent) if is_near(&parent.envelope()) => {
                descend(parent, is_near, visit);
            }
            _ => {}
        }
    }
}
