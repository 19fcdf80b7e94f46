use super::Culling;
use super::following::Walk;
use crate::broad_phase::{Seeds, SurfaceFace};
use crate::contact::Shape;
use crate::contact::shadow::PairShadow;
use crate::geometry::{Aabb, FACES};
use crate::mesh::Escape;

impl Walk<'_, '_> {
    /// Enters where every component of the contact surface must show: at its rim, where surface
    /// triangles intersect, or else at the peaks and creases of
    /// [`Landscape`](crate::mesh::Landscape).
    pub fn enter_at_seeds(&mut self, seeds_a: &Seeds, seeds_b: &Seeds) {
        self.enter_at_rims(seeds_a, seeds_b);
        self.enter_at_creases(seeds_a, seeds_b);
        self.enter_at_escapes(seeds_a, seeds_b);
    }

    /// Enters at all pairs that culling leaves over.
    pub fn enter_everywhere(&mut self) {
        let shadow = self.shadow;
        shadow.visit_candidates(Culling::default(), |tet_a, tet_b| {
            self.enter_pair(tet_a, tet_b.index);
        });
    }

    fn enter_pair(&mut self, tet_a: usize, tet_b: usize) {
        self.enter(tet_a as u32, tet_b as u32);
    }

    /// At the pairs of surface triangles that intersect.
    fn enter_at_rims(&mut self, seeds_a: &Seeds, seeds_b: &Seeds) {
        let (shadow, margin) = (self.shadow, self.shadow.margin());
        seeds_a.visit_surface_pairs(seeds_b, &shadow.pose_ab, margin, |face_a, face_b| {
            if shadow.may_cross(face_a, face_b) {
                self.enter_pair(face_a.tet(), face_b.tet());
            }
        });
    }

    /// At the tetrahedra with convex creases, of either body.
    fn enter_at_creases(&mut self, seeds_a: &Seeds, seeds_b: &Seeds) {
        let (shadow, margin) = (self.shadow, self.shadow.margin());
        let [tree_a, tree_b] = shadow.shapes.map(Shape::tree);
        seeds_b.visit_creased_near(&tree_a.bounds(), &shadow.pose_ab, margin, |tet_b| {
            let posed_b = shadow.posed_tet(tet_b);
            shadow.visit_partners(Culling::default(), &posed_b, |tet_a| {
                self.enter_pair(tet_a, tet_b);
            });
        });
        let pose_ba = shadow.pose_ab.inverse();
        seeds_a.visit_creased_near(&tree_b.bounds(), &pose_ba, margin, |tet_a| {
            let posed_a = shadow.tet_a(tet_a).tetrahedron.posed(&pose_ba);
            let query = posed_a.aabb().inflated(margin);
            tree_b.visit_overlapping(&query, |tet_b| self.enter_pair(tet_a, tet_b));
        });
    }

    /// Where the pressures become equal on an escape of either body.
    fn enter_at_escapes(&mut self, seeds_a: &Seeds, seeds_b: &Seeds) {
        let (shadow, margin) = (self.shadow, self.shadow.margin());
        let ([modulus_a, modulus_b], pose_ba) = (shadow.moduli, shadow.pose_ab.inverse());
        let [tree_a, tree_b] = shadow.shapes.map(Shape::tree);
        for Escape { tet, corners } in seeds_a.escapes() {
            let tet_a = shadow.tet_a(*tet);
            let ends = corners.map(|c| pose_ba.transformed_point(&tet_a.tetrahedron.corners[c]));
            let pressures = corners.map(|c| tet_a.extents[c] * modulus_a);
            tree_b.visit_overlapping(&Aabb::around(&ends).inflated(margin), |tet_b| {
                let field_b = shadow.tet_b(tet_b).extent.scaled(modulus_b);
                let tolerance = margin * modulus_b * shadow.tet_b(tet_b).sensitivity;
                if changes_sign(pressures, ends.map(|end| field_b.at(&end)), tolerance) {
                    self.enter_pair(*tet, tet_b);
                }
            });
        }
        for Escape { tet, corners } in seeds_b.escapes() {
            let tet_b = shadow.tet_b(*tet);
            let ends = corners.map(|c| {
                shadow
                    .pose_ab
                    .transformed_point(&tet_b.tetrahedron.corners[c])
            });
            let pressures = corners.map(|c| tet_b.extents[c] * modulus_b);
            tree_a.visit_overlapping(&Aabb::around(&ends).inflated(margin), |tet_a| {
                let field_a = shadow.tet_a(tet_a).extent.scaled(modulus_a);
                let tolerance = margin * modulus_a * shadow.tet_a(tet_a).sensitivity;
                if changes_sign(pressures, ends.map(|end| field_a.at(&end)), tolerance) {
                    self.enter_pair(tet_a, *tet);
                }
            });
        }
    }
}

/// Whether the difference of two affine functions, given at both ends of an edge, is zero on it.
fn changes_sign(first: [f64; 2], second: [f64; 2], tolerance: f64) -> bool {
    let differences = [first[0] - second[0], first[1] - second[1]];
    differences.iter().any(|&d| d <= tolerance) && differences.iter().any(|&d| d >= -tolerance)
}

impl PairShadow<'_> {
    /// Whether the plane of a surface triangle of A does not have one of B all on one side.
    fn may_cross(&self, face_a: SurfaceFace, face_b: SurfaceFace) -> bool {
        let (tet_a, tet_b) = (self.tet_a(face_a.tet()), self.tet_b(face_b.tet()));
        let plane = &tet_a.barycentric[face_a.face()];
        let tolerance = self.margin() * tet_a.barycentric_steepness[face_a.face()];
        let heights = FACES[face_b.face()].map(|corner| {
            let corner = &tet_b.tetrahedron.corners[corner];
            plane.at(&self.pose_ab.transformed_point(corner))
        });
        heights.iter().any(|&h| h <= tolerance) && heights.iter().any(|&h| h >= -tolerance)
    }
}
