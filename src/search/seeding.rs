//! Where the walk over a contact surface enters it: at the rims and, for components without a rim, at components of a rigid
//! surface, or at peaks and creases of the fields. (At turns: `turns.rs`.)

use super::following::Walk;
use crate::broad_phase::{Escape, Ridges, RigidShape, Shape, TriangleBvh, visit_crossings};
use crate::geometry::Aabb;
use crate::spatial::Pose;

impl Walk<'_, '_> {
    /// Enters where a component without a rim must show, if both bodies' fields rise to few peaks: at the convex creases, and
    /// on the escapes from peaks and creases (see [`Landscape`](crate::broad_phase::Landscape)).
    pub fn enter_at_ridges(&mut self, shape_b: &Shape, ridges: [&Ridges; 2]) {
        self.enter_at_creases(shape_b, ridges);
        self.enter_at_escapes(shape_b, ridges);
    }

    /// Enters at one point of each component of a rigid surface: of one without a rim, all points are in A.
    pub fn enter_at_components(&mut self, shape_b: &RigidShape) {
        let (pair, margin) = (self.pair, self.pair.margin());
        let shape_a = pair.shape_a;
        let (components, bounds) = (shape_b.components(), shape_a.bounds());
        components.visit_near(&bounds, &pair.pose_ab, margin, |triangle| {
            let in_a = pair.pose_ab.transformed_point(&shape_b.centroid(triangle));
            let enter_pair = |tet_a| self.enter_pair(tet_a, triangle);
            shape_a.tet_bvh().visit_at(&in_a, margin, enter_pair);
        });
    }

    /// Enters at a cell of B with every tetrahedron of A that it may touch.
    fn enter_with_all_of_a(&mut self, cell: usize) {
        let posed = self.pair.posed_tet(cell);
        self.pair
            .visit_partners(&posed, |tet_a| self.enter_pair(tet_a, cell));
    }

    /// Enters at all pairs of tetrahedra that may touch.
    pub fn enter_everywhere(&mut self) {
        let pair = self.pair;
        pair.visit_overlapping(|tet_a, tet_b| {
            self.enter_pair(tet_a, tet_b.index);
        });
    }

    pub fn enter_pair(&mut self, tet_a: usize, tet_b: usize) {
        self.enter(tet_a as u32, tet_b as u32);
    }

    /// Enters at all pairs that may have a point in common with the contact surface in a pair that was looked at.
    pub fn enter_around(&mut self, tet_a: u32, tet_b: u32) {
        let (pair, margin) = (self.pair, self.pair.margin());
        let tree_a = pair.shape_a.tet_bvh().pressing();
        let box_of_b = |tet: usize| pair.tet_b(tet).tetrahedron.posed(&pair.pose_ab).aabb();
        let posed_b = self.scratch.posed_tets.get(tet_b);
        let Some(region) = pair.box_of_polygon(pair.tet_a(tet_a as usize), posed_b) else {
            return;
        };
        pair.visit_cells_near(&region, |tet_b| {
            if let Some(query) = region.common(&box_of_b(tet_b).inflated(margin)) {
                tree_a.visit_overlapping(&query, |tet_a| self.enter_pair(tet_a, tet_b));
            }
        });
    }

    /// Enters where every component with a rim must show: at the pairs of surface triangles that may cross.
    pub fn enter_at_rims(&mut self, triangles_b: &TriangleBvh) {
        let (pair, margin) = (self.pair, self.pair.margin());
        let surfaces = [pair.shape_a.triangle_bvh(), triangles_b];
        let mut crossings = std::mem::take(&mut self.scratch.crossings);
        let memory = &mut self.scratch.tree_nodes;
        visit_crossings(surfaces, &pair.pose_ab, margin, memory, |a, b| {
            crossings.push([a.tet() as u32, b.tet() as u32]);
        });
        self.enter_all(&crossings);
        crossings.clear();
        self.scratch.crossings = crossings;
    }

    /// Enters at the tetrahedra with convex creases, of either body, with all of the other body that they may touch.
    fn enter_at_creases(&mut self, shape_b: &Shape, [ridges_a, ridges_b]: [&Ridges; 2]) {
        let (pair, margin) = (self.pair, self.pair.margin());
        let tree_b = shape_b.tet_bvh().pressing();
        let bounds_a = pair.shape_a.bounds();
        (ridges_b.creased).visit_near(&bounds_a, &pair.pose_ab, margin, |tet_b| {
            self.enter_with_all_of_a(tet_b);
        });
        let pose_ba = pair.pose_ab.inverse();
        (ridges_a.creased).visit_near(&shape_b.bounds(), &pose_ba, margin, |tet_a| {
            let posed_a = pair.tet_a(tet_a).tetrahedron.posed(&pose_ba);
            let query = posed_a.aabb().inflated(margin);
            tree_b.visit_overlapping(&query, |tet_b| self.enter_pair(tet_a, tet_b));
        });
    }

    /// Enters where the pressures become equal on an escape of either body.
    fn enter_at_escapes(&mut self, shape_b: &Shape, [ridges_a, ridges_b]: [&Ridges; 2]) {
        let (pair, margin) = (self.pair, self.pair.margin());
        let field = |shape, modulus| PressureOf { shape, modulus };
        let a = field(pair.shape_a, pair.scales[0]);
        let b = field(shape_b, pair.scales[1]);
        visit_escapes(
            (&b, ridges_b),
            &a,
            (&pair.pose_ab, margin),
            |tet_b, tet_a| {
                self.enter_pair(tet_a, tet_b);
            },
        );
        let pose_ba = pair.pose_ab.inverse();
        visit_escapes((&a, ridges_a), &b, (&pose_ba, margin), |tet_a, tet_b| {
            self.enter_pair(tet_a, tet_b);
        });
    }
}

/// The pressure of a body: a modulus (Pa) times the extents of a shape.
struct PressureOf<'a> {
    shape: &'a Shape,
    modulus: f64,
}

/// Visits the pairs of a body's own tetrahedron at an escape and one of the other body, in which the pressures become equal
/// on the escape. Takes the pose of the own body in the frame of the other, and what counts as zero as a distance (m).
fn visit_escapes(
    (own, ridges): (&PressureOf, &Ridges),
    other: &PressureOf,
    (pose, margin): (&Pose<f64>, f64),
    mut visit: impl FnMut(usize, usize),
) {
    let tree = other.shape.tet_bvh().pressing();
    let [own_tets, other_tets] = [own, other].map(|body| body.shape.field().tets());
    (ridges.escapes).visit_near(
        &other.shape.bounds(),
        pose,
        margin,
        |Escape { tet, corners }| {
            let own_tet = &own_tets[tet];
            let ends = corners.map(|c| pose.transformed_point(&own_tet.tetrahedron.corners[c]));
            let pressures = corners.map(|c| own_tet.extents[c] * own.modulus);
            tree.visit_overlapping(&Aabb::around(&ends).inflated(margin), |partner| {
                let other_field = other_tets[partner].extent.scaled(other.modulus);
                let tolerance = margin * other.modulus * other_tets[partner].sensitivity;
                let excess = [0, 1].map(|end| pressures[end] - other_field.at(&ends[end]));
                if may_be_zero(&excess, tolerance) {
                    visit(tet, partner);
                }
            });
        },
    );
}

/// Whether an affine function with these values, each to within the tolerance, may be zero between them.
fn may_be_zero(values: &[f64], tolerance: f64) -> bool {
    values.iter().any(|&value| value <= tolerance)
        && values.iter().any(|&value| value >= -tolerance)
}
