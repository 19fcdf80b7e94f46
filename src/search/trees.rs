use super::Culling;
use crate::broad_phase::Projections;
use crate::narrow_phase::{Cut, Encounter, PosedTet, RelativePair};

impl RelativePair<'_> {
    /// Finds the cuts among the pairs that culling leaves over. Returns the number of these.
    pub(super) fn cull(&self, culling: Culling, cuts: &mut Vec<Cut>) -> usize {
        let mut candidates = 0;
        self.visit_candidates(culling, |tet_a, tet_b| {
            candidates += 1;
            let tet_a = self.tet_a(tet_a);
            if let Encounter::Met(decisions) = self.encounter(tet_a, tet_b, culling.plane_check) {
                let cut = self.cut(tet_a, tet_b, decisions);
                if cut.is_noted() {
                    cuts.push(cut);
                }
            }
        });
        candidates
    }

    /// Visits the pairs of tetrahedra whose boxes overlap.
    pub fn visit_overlapping(&self, visit: impl FnMut(usize, &PosedTet)) {
        self.visit_candidates(Culling::default(), visit);
    }

    /// Visits the pairs of tetrahedra that culling leaves over.
    pub fn visit_candidates(&self, culling: Culling, mut visit: impl FnMut(usize, &PosedTet)) {
        let [shape_a, shape_b] = self.shapes;
        let visit_partners = |index_b: usize| {
            let tet_b = self.posed_tet(index_b);
            self.visit_partners(culling, &tet_b, |index_a| visit(index_a, &tet_b));
        };
        if culling.tree {
            let region = shape_a.tree().bounds();
            shape_b
                .tree()
                .visit_near(&region, &self.pose_ab, self.margin(), visit_partners);
        } else {
            (0..shape_b.field().tets().len())
                .filter(|&b| !self.tet_b(b).is_inert())
                .for_each(visit_partners);
        }
    }

    /// Visits the tetrahedra of A that may touch one of B.
    pub fn visit_partners(&self, culling: Culling, tet_b: &PosedTet, mut visit: impl FnMut(usize)) {
        let (shape_a, margin) = (self.shapes[0], self.margin());
        let directions = culling.projections;
        let query = tet_b.tetrahedron.aabb().inflated(margin);
        let shadows = (directions > 0).then(|| Projections::of(&tet_b.tetrahedron));
        let visit_partner = |index_a: usize| {
            let own = shape_a.tree().projections(index_a);
            let apart = |shadows| own.separate(shadows, directions, margin);
            if !shadows.as_ref().is_some_and(apart) {
                visit(index_a);
            }
        };
        if culling.tree {
            shape_a.tree().visit_overlapping(&query, visit_partner);
        } else {
            let boxes = culling.bounding_boxes;
            (0..shape_a.field().tets().len())
                .filter(|&a| !self.tet_a(a).is_inert())
                .filter(|&a| !boxes || self.tet_a(a).tetrahedron.aabb().overlaps(&query))
                .for_each(visit_partner);
        }
    }
}
