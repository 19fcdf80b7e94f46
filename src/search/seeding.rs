//! The seeds of the walk over a contact surface. They are at the boundaries of its components. For closed components they are at components
//! of a rigid surface, or on the paths from the peaks of concave fields to the surface. `extremal_pairs` has the seeds between other fields.

use super::following::Walk;
use crate::broad_phase::{TriangleBvh, visit_crossing_triangles};
use crate::bvh::Bvh;
use crate::contact_shape::{RigidShape, Shape};
use crate::geometry::Aabb;
use crate::seeds::PathEdge;
use crate::spatial::Pose;

impl Walk<'_, '_> {
    /// Queues the pairs at one point of each component of a rigid surface. All points of a closed component of the contact surface are in A.
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

    /// Queues all pairs of tetrahedra that may touch.
    pub fn enter_everywhere(&mut self) {
        let pair = self.pair;
        pair.visit_overlapping(|tet_a, tet_b| {
            self.enter_pair(tet_a, tet_b.index);
        });
    }

    pub fn enter_pair(&mut self, tet_a: usize, tet_b: usize) {
        self.enter(tet_a as u32, tet_b as u32);
    }

    /// Queues all pairs that may have a point in common with the contact polygon of a pair.
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

    /// Queues the pairs of surface triangles that may cross. Every component with a boundary contains one of them.
    pub fn enter_at_boundary(&mut self, triangles_b: &TriangleBvh) {
        let (pair, margin) = (self.pair, self.pair.margin());
        let surfaces = [pair.shape_a.triangle_bvh(), triangles_b];
        let mut crossings = std::mem::take(&mut self.scratch.crossings);
        let memory = &mut self.scratch.tree_nodes;
        visit_crossing_triangles(surfaces, &pair.pose_ab, margin, memory, |a, b| {
            crossings.push([a.tet() as u32, b.tet() as u32]);
        });
        self.enter_all(&crossings);
        crossings.clear();
        self.scratch.crossings = crossings;
    }

    /// Queues the pairs in which the pressures become equal on a path edge of either body.
    pub fn enter_at_peak_paths(
        &mut self,
        shape_b: &Shape,
        [paths_a, paths_b]: [&Bvh<PathEdge>; 2],
    ) {
        let (pair, margin) = (self.pair, self.pair.margin());
        let field = |shape, modulus| PressureOf { shape, modulus };
        let a = field(pair.shape_a, pair.scales[0]);
        let b = field(shape_b, pair.scales[1]);
        visit_peak_paths(
            (&b, paths_b),
            &a,
            (&pair.pose_ab, margin),
            |tet_b, tet_a| {
                self.enter_pair(tet_a, tet_b);
            },
        );
        let pose_ba = pair.pose_ab.inverse();
        visit_peak_paths((&a, paths_a), &b, (&pose_ba, margin), |tet_a, tet_b| {
            self.enter_pair(tet_a, tet_b);
        });
    }
}

/// The pressure of a body: a modulus (Pa) times the extents of a shape.
struct PressureOf<'a> {
    shape: &'a Shape,
    modulus: f64,
}

/// Visits the pairs of a tetrahedron at a path edge of the own body and a tetrahedron of the other body in which the pressures become equal
/// on the edge. Takes the pose of the own body in the frame of the other, and the distance (m) that counts as zero.
fn visit_peak_paths(
    (body, peak_paths): (&PressureOf, &Bvh<PathEdge>),
    other_body: &PressureOf,
    (pose, margin): (&Pose<f64>, f64),
    mut visit: impl FnMut(usize, usize),
) {
    let tree = other_body.shape.tet_bvh().pressing();
    let [tets, other_tets] = [body, other_body].map(|body| body.shape.field().tets());
    peak_paths.visit_near(
        &other_body.shape.bounds(),
        pose,
        margin,
        |PathEdge { tet, corners }| {
            let field_tet = &tets[tet];
            let ends = corners.map(|c| pose.transformed_point(&field_tet.tetrahedron.corners[c]));
            let pressures = corners.map(|c| field_tet.extents[c] * body.modulus);
            tree.visit_overlapping(&Aabb::around(&ends).inflated(margin), |partner| {
                let other_field = other_tets[partner].extent.scaled(other_body.modulus);
                let tolerance = margin * other_body.modulus * other_tets[partner].sensitivity;
                let excess = [0, 1].map(|end| pressures[end] - other_field.at(&ends[end]));
                if may_be_zero(&excess, tolerance) {
                    visit(tet, partner);
                }
            });
        },
    );
}

/// Returns whether an affine function may be zero between these values, each given to within the tolerance.
fn may_be_zero(values: &[f64], tolerance: f64) -> bool {
    values.iter().any(|&value| value <= tolerance)
        && values.iter().any(|&value| value >= -tolerance)
}
