//! Culling: leaves out pairs of tetrahedra that cannot touch, and cuts all others.

use super::Culling;
use super::scratch::Scratch;
use crate::broad_phase::Projections;
use crate::contact_shape::PartnerShape;
use crate::geometry::Aabb;
use crate::mesh::FieldTet;
use crate::narrow_phase::{PairClass, PosedTet, RelativePair};

impl RelativePair<'_> {
    /// Cuts the pairs that culling keeps. Returns the number of these pairs.
    pub(super) fn cull(&self, culling: Culling, scratch: &mut Scratch) -> usize {
        let mut candidates = 0;
        self.visit_candidates(culling, |tet_a, tet_b| {
            candidates += 1;
            let tet_a = self.tet_a(tet_a);
            match self.classify(tet_a, tet_b, culling.plane_check) {
                PairClass::Disjoint => {}
                PairClass::EqualFields => scratch.equal.push([tet_a.index, tet_b.index]),
                PairClass::Intersecting(topology) => {
                    let cut = self.cut(tet_a, tet_b, topology);
                    if cut.is_noted() {
                        scratch.cuts.push(cut);
                    }
                }
            }
        });
        candidates
    }

    /// Visits the pairs of tetrahedra that neither boxes nor projections separate.
    pub fn visit_overlapping(&self, mut visit: impl FnMut(usize, &PosedTet)) {
        if let PartnerShape::HalfSpace(_) = self.shape_b {
            let half_space = self.posed_tet(0);
            self.visit_at_half_space(&half_space, |a| visit(a.index, &half_space));
            return;
        }
        self.visit_cells_near(&self.shape_a.bounds(), |index_b| {
            let tet_b = self.posed_tet(index_b);
            self.visit_partners(&tet_b, |index_a| visit(index_a, &tet_b));
        });
    }

    /// Visits the pairs of tetrahedra that culling keeps.
    fn visit_candidates(&self, culling: Culling, mut visit: impl FnMut(usize, &PosedTet)) {
        let region = self.shape_a.bounds();
        let visit_culled = |index_b: usize| {
            let tet_b = self.posed_tet(index_b);
            self.visit_culled(culling, &tet_b, |index_a| visit(index_a, &tet_b));
        };
        match self.shape_b {
            PartnerShape::HalfSpace(_) if culling.tree => self.visit_overlapping(visit),
            PartnerShape::HalfSpace(_) => {
                let (half_space, tets) = (self.posed_tet(0), self.shape_a.field().tets());
                let pressing = tets.iter().filter(|a| !a.is_inert());
                pressing.for_each(|a| visit(a.index, &half_space));
            }
            PartnerShape::Rigid(_) if culling.tree => self.visit_cells_near(&region, visit_culled),
            PartnerShape::Compliant(shape) if culling.tree => {
                let tree = shape.r_star_tree();
                tree.visit_near(&region, &self.pose_ab, self.margin(), visit_culled);
            }
            _ => (0..self.shape_b.cells().len())
                .filter(|&b| !self.tet_b(b).is_inert())
                .for_each(visit_culled),
        }
    }

    /// Visits the tetrahedra of A in which the pressures of A and of a half-space may be equal.
    fn visit_at_half_space(&self, half_space: &PosedTet, visit: impl FnMut(&FieldTet)) {
        // The equilibrium plane of a rigid half-space is its surface. For others it may lie at any depth.
        let is_rigid = self.shape_b.is_rigid();
        let deepest = if is_rigid { 0.0 } else { f64::INFINITY };
        self.visit_reaching(half_space, deepest, visit);
    }

    /// Visits the tetrahedra or triangles of B that may overlap the box `region` in A's frame. Visits nothing for a half-space.
    pub fn visit_cells_near(&self, region: &Aabb, mut visit: impl FnMut(usize)) {
        let (pose_ab, margin) = (&self.pose_ab, self.margin());
        match self.shape_b {
            PartnerShape::Compliant(shape) => {
                let bvh = shape.tet_bvh().pressing();
                bvh.visit_near(region, pose_ab, margin, visit);
            }
            PartnerShape::Rigid(shape) => {
                let bvh = shape.triangle_bvh().bvh();
                bvh.visit_near(region, pose_ab, margin, |face| visit(face.tet()));
            }
            PartnerShape::HalfSpace(_) => {}
        }
    }

    /// Visits the tetrahedra of A that have points from the surface of a half-space down to where its field has the value
    /// `deepest`, or nearly.
    pub fn visit_reaching(
        &self,
        half_space: &PosedTet,
        deepest: f64,
        mut visit: impl FnMut(&FieldTet),
    ) {
        let field = &half_space.field;
        // Must be finite, because the boxes of missing children are at infinity.
        let near = (self.tolerance.noted() * half_space.sensitivity).min(f64::MAX);
        let [least, most] = [-near, deepest + near];
        let tree = self.shape_a.tet_bvh();
        tree.visit_between(field, [least, most], |tet_a| visit(self.tet_a(tet_a)));
    }

    /// Returns whether a tetrahedron of A and one of B may touch: neither boxes nor projections separate them.
    pub fn may_touch(&self, tet_a: usize, tet_b: &PosedTet) -> bool {
        if let PartnerShape::HalfSpace(_) = self.shape_b {
            return true;
        }
        let (margin, of_b) = (self.margin(), &tet_b.tetrahedron);
        let box_a = self.tet_a(tet_a).tetrahedron.aabb();
        box_a.overlaps(&of_b.aabb().inflated(margin))
            && !self.are_separated(tet_a, &Projections::of(of_b), Projections::COUNT)
    }

    /// Visits the tetrahedra of A that may touch one of B.
    pub fn visit_partners(&self, tet_b: &PosedTet, mut visit: impl FnMut(usize)) {
        let query = tet_b.tetrahedron.aabb().inflated(self.margin());
        let shadows = Projections::of(&tet_b.tetrahedron);
        let bvh = self.shape_a.tet_bvh().pressing();
        bvh.visit_overlapping(&query, |index_a| {
            if !self.are_separated(index_a, &shadows, Projections::COUNT) {
                visit(index_a);
            }
        });
    }

    /// Visits the tetrahedra of A that culling keeps for one of B.
    fn visit_culled(&self, culling: Culling, tet_b: &PosedTet, mut visit: impl FnMut(usize)) {
        let (shape_a, directions) = (self.shape_a, culling.projections);
        let query = tet_b.tetrahedron.aabb().inflated(self.margin());
        let shadows = (directions > 0).then(|| Projections::of(&tet_b.tetrahedron));
        let visit_partner = |index_a: usize| {
            let apart = |shadows| self.are_separated(index_a, shadows, directions);
            if !shadows.as_ref().is_some_and(apart) {
                visit(index_a);
            }
        };
        if culling.tree {
            let tree = shape_a.r_star_tree();
            tree.visit_overlapping(&query, visit_partner);
        } else {
            let boxes = culling.bounding_boxes;
            (0..shape_a.field().tets().len())
                .filter(|&a| !self.tet_a(a).is_inert())
                .filter(|&a| !boxes || self.tet_a(a).tetrahedron.aabb().overlaps(&query))
                .for_each(visit_partner);
        }
    }

    /// Returns whether one of the first `count` fixed directions separates a tetrahedron of A from another with these projections.
    #[inline]
    fn are_separated(&self, tet_a: usize, shadows: &Projections, count: usize) -> bool {
        let projections_a = self.shape_a.projections(tet_a);
        projections_a.separate(shadows, count, self.margin())
    }
}
