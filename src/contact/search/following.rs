use super::scratch::Scratch;
use super::{Culling, Encounter, Meeting};
use crate::broad_phase::{Seeds, SurfaceFace};
use crate::contact::shadow::PairShadow;
use crate::geometry::{Aabb, FACES};
use crate::mesh::Escape;
use nalgebra::Vector3;

/// A walk over the contact surface.
struct Walk<'w, 'a, V> {
    shadow: &'w PairShadow<'a>,
    scratch: &'w mut Scratch,
    visit: V,
    /// Whether somewhere the fields are equal over a volume: the surface may go on beyond it.
    has_gaps: bool,
}

impl PairShadow<'_> {
    /// Visits the pairs of tetrahedra with a contact polygon: from those where a component of the
    /// contact surface must show, to their neighbours across the faces that a polygon reaches.
    ///
    /// A polygon's edge lies on a face of A or of B, and behind that face the neighbour has the same
    /// edge. In a special position, where the plane only touches a pair, or an edge lies on faces of
    /// both, what is next may be behind several faces; so a pair that is only touched is a step on the
    /// way too. Seeds are the pairs of surface triangles that intersect, and those of
    /// [`Landscape`](crate::mesh::Landscape) for components without a rim.
    pub(super) fn follow(&self, visit: impl FnMut(&Meeting)) -> usize {
        let seeds = self.shapes.map(|shape| shape.seeds());
        Scratch::lent(|scratch| {
            let mut walk = Walk {
                shadow: self,
                scratch,
                visit,
                has_gaps: false,
            };
            if let [Some(seeds_a), Some(seeds_b)] = seeds {
                walk.enter_at_rims(seeds_a, seeds_b);
                walk.enter_at_creases(seeds_a, seeds_b);
                walk.enter_at_escapes(seeds_a, seeds_b);
            }
            if seeds.iter().any(Option::is_none) || walk.has_gaps {
                walk.enter_everywhere();
            }
            walk.scratch.visited.len()
        })
    }
}

impl<V: FnMut(&Meeting)> Walk<'_, '_, V> {
    /// Looks at a pair of tetrahedra and, if it is part of the surface, follows it.
    fn enter(&mut self, tet_a: usize, tet_b: usize) {
        self.enqueue(tet_a as u32, tet_b as u32);
        while let Some([tet_a, tet_b]) = self.scratch.queue.pop() {
            self.look_at(tet_a, tet_b);
        }
    }

    fn enqueue(&mut self, tet_a: u32, tet_b: u32) {
        if self.scratch.visited.insert([tet_a, tet_b]) {
            self.scratch.queue.push([tet_a, tet_b]);
        }
    }

    fn look_at(&mut self, tet_a: u32, tet_b: u32) {
        let (a, b) = (tet_a as usize, tet_b as usize);
        let posed_b = self.scratch.posed_tets.of(self.shadow, b);
        let meeting = match self.shadow.encounter(self.shadow.tet_a(a), posed_b, true) {
            Encounter::Apart => return,
            Encounter::EqualFields => {
                self.has_gaps = true;
                return;
            }
            Encounter::Meeting(meeting) => meeting,
        };
        if meeting.is_polygon {
            (self.visit)(&meeting);
        }
        let [mesh_a, mesh_b] = self.shadow.shapes.map(|shape| shape.field().mesh());
        for face in 0..4 {
            if meeting.sides & 1 << face != 0
                && let Some(next) = mesh_a.neighbour(a, face)
            {
                self.enqueue(next as u32, tet_b);
            }
            if meeting.sides & 1 << (4 + face) != 0
                && let Some(next) = mesh_b.neighbour(b, face)
            {
                self.enqueue(tet_a, next as u32);
            }
        }
    }

    /// At the pairs of surface triangles that intersect.
    fn enter_at_rims(&mut self, seeds_a: &Seeds, seeds_b: &Seeds) {
        let (shadow, margin) = (self.shadow, self.shadow.margin());
        let region = shadow.shapes[0].tree().bounds();
        seeds_b.visit_surface_near(&region, &shadow.pose_ab, margin, |face_b| {
            let corners = &shadow.tet_b(face_b.tet()).tetrahedron.corners;
            let triangle = FACES[face_b.face()].map(|c| shadow.pose_ab.transformed_point(&corners[c]));
            let query = Aabb::around(&triangle).inflated(margin);
            seeds_a.visit_surface(&query, |face_a| {
                if shadow.may_cross(face_a, &triangle) {
                    self.enter(face_a.tet(), face_b.tet());
                }
            });
        });
    }

    /// At the tetrahedra with convex creases, of either body.
    fn enter_at_creases(&mut self, seeds_a: &Seeds, seeds_b: &Seeds) {
        let (shadow, margin) = (self.shadow, self.shadow.margin());
        let [tree_a, tree_b] = shadow.shapes.map(|shape| shape.tree());
        seeds_b.visit_creased_near(&tree_a.bounds(), &shadow.pose_ab, margin, |tet_b| {
            let posed_b = shadow.posed_tet(tet_b);
            shadow.visit_partners(Culling::default(), &posed_b, |tet_a| self.enter(tet_a, tet_b));
        });
        let pose_ba = shadow.pose_ab.inverse();
        seeds_a.visit_creased_near(&tree_b.bounds(), &pose_ba, margin, |tet_a| {
            let posed_a = shadow.tet_a(tet_a).tetrahedron.posed(&pose_ba);
            let query = posed_a.aabb().inflated(margin);
            tree_b.visit_overlapping(&query, |tet_b| self.enter(tet_a, tet_b));
        });
    }

    /// Where the pressures become equal on an escape of either body.
    fn enter_at_escapes(&mut self, seeds_a: &Seeds, seeds_b: &Seeds) {
        let (shadow, margin) = (self.shadow, self.shadow.margin());
        let ([modulus_a, modulus_b], pose_ba) = (shadow.moduli, shadow.pose_ab.inverse());
        let [tree_a, tree_b] = shadow.shapes.map(|shape| shape.tree());
        for Escape { tet, corners } in seeds_a.escapes() {
            let tet_a = shadow.tet_a(*tet);
            let ends = corners.map(|c| pose_ba.transformed_point(&tet_a.tetrahedron.corners[c]));
            let pressures = corners.map(|c| tet_a.extents[c] * modulus_a);
            tree_b.visit_overlapping(&Aabb::around(&ends).inflated(margin), |tet_b| {
                let field_b = shadow.tet_b(tet_b).extent.scaled(modulus_b);
                let tolerance = margin * modulus_b * shadow.tet_b(tet_b).sensitivity;
                if changes_sign(pressures, ends.map(|end| field_b.at(&end)), tolerance) {
                    self.enter(*tet, tet_b);
                }
            });
        }
        for Escape { tet, corners } in seeds_b.escapes() {
            let tet_b = shadow.tet_b(*tet);
            let ends = corners.map(|c| shadow.pose_ab.transformed_point(&tet_b.tetrahedron.corners[c]));
            let pressures = corners.map(|c| tet_b.extents[c] * modulus_b);
            tree_a.visit_overlapping(&Aabb::around(&ends).inflated(margin), |tet_a| {
                let field_a = shadow.tet_a(tet_a).extent.scaled(modulus_a);
                let tolerance = margin * modulus_a * shadow.tet_a(tet_a).sensitivity;
                if changes_sign(pressures, ends.map(|end| field_a.at(&end)), tolerance) {
                    self.enter(tet_a, *tet);
                }
            });
        }
    }

    /// At all pairs that culling leaves over.
    fn enter_everywhere(&mut self) {
        let shadow = self.shadow;
        shadow.visit_candidates(Culling::default(), |tet_a, tet_b| self.enter(tet_a, tet_b.index));
    }
}

/// Whether the difference of two affine functions, given at both ends of an edge, is zero on it.
fn changes_sign(first: [f64; 2], second: [f64; 2], tolerance: f64) -> bool {
    let differences = [first[0] - second[0], first[1] - second[1]];
    differences.iter().any(|&d| d <= tolerance) && differences.iter().any(|&d| d >= -tolerance)
}

impl PairShadow<'_> {
    /// Whether the plane of a surface triangle of A does not have a triangle all on one side.
    fn may_cross(&self, face_a: SurfaceFace, triangle: &[Vector3<f64>; 3]) -> bool {
        let tet_a = self.tet_a(face_a.tet());
        let plane = &tet_a.barycentric[face_a.face()];
        let tolerance = self.margin() * tet_a.barycentric_steepness[face_a.face()];
        let heights = triangle.each_ref().map(|corner| plane.at(corner));
        heights.iter().any(|&h| h <= tolerance) && heights.iter().any(|&h| h >= -tolerance)
    }
}
