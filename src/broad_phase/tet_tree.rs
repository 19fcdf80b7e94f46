use super::Projections;
use super::box_tree::BoxTree;
use crate::geometry::Aabb;
use crate::mesh::PressureField;
use crate::spatial::Pose;
use crate::threads;
use nalgebra::Vector3;

/// The R\*-tree of a mesh's tetrahedra, by their boxes in the body frame.
#[derive(Debug, Clone)]
pub struct TetTree {
    tree: BoxTree<u32>,
    inert: BoxTree<u32>,
    bounds: Aabb,
    projections: Vec<Projections>,
}

impl TetTree {
    /// Bulk-loads the tree: O(n log n), once per mesh. Inert tetrahedra have one of their own.
    #[must_use]
    pub fn new(field: &PressureField) -> Self {
        let tets = field.tets();
        let tree_of = |is_inert: bool| {
            let own = (0_u32..).zip(tets);
            let own = own.filter(|(_, tet)| tet.is_inert() == is_inert);
            BoxTree::new(own.map(|(index, tet)| (index, tet.tetrahedron.aabb())))
        };
        Self {
            tree: tree_of(false),
            inert: tree_of(true),
            bounds: field.mesh().aabb(),
            projections: threads::values_of(tets.len(), |tet| {
                Projections::of(&tets[tet].tetrahedron)
            }),
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

    /// Visits all tetrahedra, inert ones too, in whose boxes a point is, given to within `margin` (m).
    pub(crate) fn visit_at(&self, point: &Vector3<f64>, margin: f64, mut visit: impl FnMut(usize)) {
        let query = Aabb::around([point]).inflated(margin);
        for tree in [&self.tree, &self.inert] {
            tree.visit_overlapping(&query, |tet| visit(tet as usize));
        }
    }

    /// Visits the tetrahedra whose boxes overlap `query` (both in the body frame), but for inert ones.
    pub fn visit_overlapping(&self, query: &Aabb, mut visit: impl FnMut(usize)) {
        self.tree
            .visit_overlapping(query, |tet| visit(tet as usize));
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
        self.tree
            .visit_near(region, pose_ab, margin, |tet| visit(tet as usize));
    }
}
