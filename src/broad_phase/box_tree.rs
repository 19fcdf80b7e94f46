use crate::geometry::Aabb;
use crate::spatial::Pose;
use rstar::{AABB, ParentNode, RTree, RTreeNode, RTreeObject};
use std::ops::ControlFlow;

/// An R\*-tree of boxes, each with a key that says whose it is.
#[derive(Debug, Clone)]
pub(super) struct BoxTree<K: Copy>(RTree<Keyed<K>>);

#[derive(Debug, Clone)]
struct Keyed<K> {
    lower: [f64; 3],
    upper: [f64; 3],
    key: K,
}

impl<K> RTreeObject for Keyed<K> {
    type Envelope = AABB<[f64; 3]>;

    fn envelope(&self) -> Self::Envelope {
        AABB::from_corners(self.lower, self.upper)
    }
}

impl<K: Copy> BoxTree<K> {
    /// Bulk-loads the tree: O(n log n).
    pub fn new(boxes: impl IntoIterator<Item = (K, Aabb)>) -> Self {
        let keyed = |(key, Aabb { lower, upper }): (K, Aabb)| Keyed {
            lower: lower.into(),
            upper: upper.into(),
            key,
        };
        Self(RTree::bulk_load(boxes.into_iter().map(keyed).collect()))
    }

    /// Visits the keys of the boxes that overlap `query`.
    pub fn visit_overlapping(&self, query: &Aabb, mut visit: impl FnMut(K)) {
        let envelope = AABB::from_corners(query.lower.into(), query.upper.into());
        // Never breaks off, so there is nothing in the result.
        let _: ControlFlow<()> = self
            .0
            .locate_in_envelope_intersecting_int(envelope, |found| {
                visit(found.key);
                ControlFlow::Continue(())
            });
    }

    /// Visits the keys of the boxes (in B) that may overlap the box `region` in the frame of A, given
    /// to within `margin` (m): all those that are not separated from the region by a face of either,
    /// nor is a box around them in the tree.
    pub fn visit_near(
        &self,
        region: &Aabb,
        pose_ab: &Pose<f64>,
        margin: f64,
        mut visit: impl FnMut(K),
    ) {
        let is_near =
            |node: &RTreeNode<Keyed<K>>| region.may_overlap_posed(&aabb_of(node), pose_ab, margin);
        descend(self.0.root(), &is_near, &mut visit);
    }
}

fn aabb_of<K>(node: &RTreeNode<Keyed<K>>) -> Aabb {
    let (lower, upper) = match node {
        RTreeNode::Leaf(leaf) => (leaf.lower, leaf.upper),
        RTreeNode::Parent(parent) => (parent.envelope().lower(), parent.envelope().upper()),
    };
    Aabb {
        lower: lower.into(),
        upper: upper.into(),
    }
}

/// Visits the leaves below a node that are near, entering near nodes only.
fn descend<K: Copy>(
    node: &ParentNode<Keyed<K>>,
    is_near: &impl Fn(&RTreeNode<Keyed<K>>) -> bool,
    visit: &mut impl FnMut(K),
) {
    for child in node.children().iter().filter(|child| is_near(child)) {
        match child {
            RTreeNode::Leaf(leaf) => visit(leaf.key),
            RTreeNode::Parent(parent) => descend(parent, is_near, visit),
        }
    }
}
