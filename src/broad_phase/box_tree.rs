use crate::geometry::{Aabb, AffineField};
use crate::spatial::Pose;
use nalgebra::Matrix3;
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

    /// Visits the keys of the boxes that an affine field has values in, from `least` to `most`, or may have.
    pub fn visit_between(
        &self,
        field: &AffineField,
        [least, most]: [f64; 2],
        mut visit: impl FnMut(K),
    ) {
        let slope = field.gradient.abs();
        let is_near = |node: &RTreeNode<Keyed<K>>| {
            let aabb = aabb_of(node);
            let (middle, reach) = (field.at(&aabb.center()), slope.dot(&aabb.half_extents()));
            middle - reach <= most && middle + reach >= least
        };
        descend(self.0.root(), &is_near, &mut visit);
    }

    /// Visits the pairs of keys, of this tree's boxes (in A) and of the other's (in B), that may
    /// overlap: that no face of either separates by more than `margin` (m).
    pub fn visit_pairs<L: Copy>(
        &self,
        other: &BoxTree<L>,
        pose_ab: &Pose<f64>,
        margin: f64,
        mut visit: impl FnMut(K, L),
    ) {
        let descent = PairDescent::new(pose_ab, margin);
        let Some(first) = self.0.root().children().first() else {
            return;
        };
        let mut partners = Partners::none(first);
        for node_a in self.0.root().children() {
            partners.push_if(true, node_a);
        }
        for node_b in other.0.root().children() {
            descent.descend(node_b, &partners, &mut visit);
        }
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

/// A descent into the tree of A and the tree of B at once: down the tree of B, with the part of the tree
/// of A that each of its boxes may overlap.
struct PairDescent<'d> {
    pose_ab: &'d Pose<f64>,
    pose_ba: Pose<f64>,
    /// |R| of `pose_ba`, entry by entry: half the edges of a box of A to those of the box around it in B.
    reach_ba: Matrix3<f64>,
    margin: f64,
}

/// Nodes of A's tree for one box of B.
const ROOM: usize = 48;

/// Nodes of A's tree that a box of B may overlap. There is room for what a box of like size overlaps;
/// where it does not do, nodes stay undivided.
#[derive(Clone, Copy)]
struct Partners<'t, K: Copy> {
    nodes: [&'t RTreeNode<Keyed<K>>; ROOM],
    len: usize,
}

impl<'t, K: Copy + 't> Partners<'t, K> {
    /// Of no nodes; the one given is a filler.
    fn none(filler: &'t RTreeNode<Keyed<K>>) -> Self {
        Self {
            nodes: [filler; ROOM],
            len: 0,
        }
    }

    fn nodes(&self) -> &[&'t RTreeNode<Keyed<K>>] {
        &self.nodes[..self.len]
    }

    fn has_room_for(&self, count: usize) -> bool {
        self.len + count <= ROOM
    }

    /// Appends a node, for which there must be room, if it `is_near`: written first and then kept or
    /// not, because whether it is cannot be guessed.
    #[inline]
    fn push_if(&mut self, is_near: bool, node: &'t RTreeNode<Keyed<K>>) {
        self.nodes[self.len.min(ROOM - 1)] = node;
        self.len += usize::from(is_near);
    }
}

/// A box of B as both see it.
struct BoxOfB {
    in_a: Aabb,
    /// The axis-aligned box around a thin box that is turned is thick, so such boxes are tested in B's frame too. For
    /// others the second test costs more than it saves.
    in_b: Option<Aabb>,
}

impl BoxOfB {
    /// Longest edge over shortest from which a box is flat.
    const FLAT: f64 = 4.0;

    fn new(own: &Aabb, pose_ab: &Pose<f64>, margin: f64) -> Self {
        let edges = own.half_extents();
        let is_flat = edges.max() > Self::FLAT * edges.min();
        Self {
            in_a: own.posed(pose_ab).inflated(margin),
            // Twice, for the rounding of both boxes.
            in_b: is_flat.then(|| own.inflated(2.0 * margin)),
        }
    }
}

impl<'d> PairDescent<'d> {
    fn new(pose_ab: &'d Pose<f64>, margin: f64) -> Self {
        let pose_ba = pose_ab.inverse();
        Self {
            pose_ab,
            reach_ba: pose_ba.rotation().abs(),
            pose_ba,
            margin,
        }
    }

    /// Visits the pairs of leaves, below a node of B and below its partners, whose boxes may overlap.
    fn descend<K: Copy, L: Copy>(
        &self,
        node_b: &RTreeNode<Keyed<L>>,
        partners: &Partners<K>,
        visit: &mut impl FnMut(K, L),
    ) {
        let box_b = BoxOfB::new(&aabb_of(node_b), self.pose_ab, self.margin);
        let mut near = *partners;
        near.len = 0;
        for node_a in partners.nodes() {
            near.push_if(self.may_overlap(node_a, &box_b), node_a);
        }
        match node_b {
            RTreeNode::Leaf(leaf_b) => {
                for node_a in near.nodes() {
                    self.visit_leaves(node_a, &box_b, &mut |key| visit(key, leaf_b.key));
                }
            }
            RTreeNode::Parent(parent_b) if near.len > 0 => {
                let divided = self.divided(&near, &box_b);
                for child_b in parent_b.children() {
                    self.descend(child_b, &divided, visit);
                }
            }
            RTreeNode::Parent(_) => {}
        }
    }

    /// Whether no face of either box separates a node of A from a box of B.
    fn may_overlap<K>(&self, node_a: &RTreeNode<Keyed<K>>, box_b: &BoxOfB) -> bool {
        let own = aabb_of(node_a);
        let is_near = own.overlaps(&box_b.in_a);
        let Some(in_b) = &box_b.in_b else {
            return is_near;
        };
        let apart = self.pose_ba.transformed_point(&own.center()) - in_b.center();
        let reach = self.reach_ba * own.half_extents() + in_b.half_extents();
        is_near
            & (apart.x.abs() <= reach.x)
            & (apart.y.abs() <= reach.y)
            & (apart.z.abs() <= reach.z)
    }

    /// The children of the nodes that a box of B may overlap; undivided nodes where there is no room.
    fn divided<'t, K: Copy>(&self, nodes: &Partners<'t, K>, box_b: &BoxOfB) -> Partners<'t, K> {
        let mut divided = Partners { len: 0, ..*nodes };
        for (place, node) in nodes.nodes().iter().enumerate() {
            let left = nodes.len - place - 1;
            match node {
                RTreeNode::Parent(parent)
                    if divided.has_room_for(parent.children().len() + left) =>
                {
                    for child in parent.children() {
                        divided.push_if(self.may_overlap(child, box_b), child);
                    }
                }
                _ => divided.push_if(true, node),
            }
        }
        divided
    }

    /// Visits the leaves below a node of A that a box of B may overlap.
    fn visit_leaves<K: Copy>(
        &self,
        node_a: &RTreeNode<Keyed<K>>,
        box_b: &BoxOfB,
        visit: &mut impl FnMut(K),
    ) {
        match node_a {
            RTreeNode::Leaf(leaf) => visit(leaf.key),
            RTreeNode::Parent(parent) => {
                for child in parent.children() {
                    if self.may_overlap(child, box_b) {
                        self.visit_leaves(child, box_b, visit);
                    }
                }
            }
        }
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
