use super::Culling;
use super::following::Walk;
use crate::broad_phase::Escape;
use crate::broad_phase::{RimlessSeeds, Seeds, Shape, SurfaceFace};
use crate::geometry::{Aabb, AffineField, FACES};
use crate::mesh::FieldTet;
use crate::narrow_phase::PartnerShape;
use crate::spatial::Pose;
use nalgebra::Vector3;

impl Walk<'_, '_> {
    /// Enters where every component of the contact surface must show: at its rim, where surface
    /// triangles intersect, or else at the peaks and creases of
    /// [`Landscape`](crate::broad_phase::Landscape). Where B is rigid, a component without a rim is a connected part of its
    /// surface, all inside A, and shows at any of its triangles.
    ///
    /// Enters nowhere, and returns false, if a component may show nowhere.
    pub fn enter_at_seeds(&mut self) -> bool {
        let shape_a = self.pair.shape_a;
        match self.pair.shape_b {
            PartnerShape::Compliant(shape_b) => {
                let seeds = [shape_a, shape_b].map(|shape| shape.seeds().rimless());
                let [Some(rimless_a), Some(rimless_b)] = seeds else {
                    return false;
                };
                self.enter_at_rims(shape_b.seeds());
                self.enter_at_creases_of_b(rimless_b);
                self.enter_at_creases_of_a(rimless_a, shape_b);
                self.enter_at_escapes(shape_b, [rimless_a, rimless_b]);
                true
            }
            PartnerShape::Rigid(shape_b) => {
                self.enter_at_rims(shape_b.seeds());
                if let Some(parts) = shape_b.seeds().rimless() {
                    self.enter_at_creases_of_b(parts);
                }
                true
            }
            PartnerShape::HalfSpace(_) => false,
        }
    }

    /// Enters at all pairs that culling leaves over.
    pub fn enter_everywhere(&mut self) {
        let pair = self.pair;
        pair.visit_candidates(Culling::default(), |tet_a, tet_b| {
            self.enter_pair(tet_a, tet_b.index);
        });
    }

    fn enter_pair(&mut self, tet_a: usize, tet_b: usize) {
        self.enter(tet_a as u32, tet_b as u32);
    }

    /// At the pairs of surface triangles that intersect.
    fn enter_at_rims(&mut self, seeds_b: &Seeds) {
        let (pair, margin) = (self.pair, self.pair.margin());
        let seeds_a = pair.shape_a.seeds();
        // The pairs of one triangle of B come one after the other.
        let mut triangle_b: Option<(SurfaceFace, Triangle)> = None;
        seeds_a.visit_surface_pairs(seeds_b, &pair.pose_ab, margin, |face_a, face_b| {
            if triangle_b.as_ref().is_none_or(|(face, _)| *face != face_b) {
                let tet_b = pair.tet_b(face_b.tet());
                triangle_b = Some((face_b, Triangle::of(tet_b, face_b.face(), &pair.pose_ab)));
            }
            let tet_a = pair.tet_a(face_a.tet());
            let may_cross = |b: &Triangle| b.may_cross(tet_a, face_a.face(), margin);
            if triangle_b.as_ref().is_some_and(|(_, b)| may_cross(b)) {
                self.enter_pair(face_a.tet(), face_b.tet());
            }
        });
    }

    /// At the tetrahedra of B with convex creases, or at one triangle of each part of a rigid surface.
    fn enter_at_creases_of_b(&mut self, seeds_b: &RimlessSeeds) {
        let (pair, margin) = (self.pair, self.pair.margin());
        let bounds_a = pair.shape_a.tree().bounds();
        seeds_b.visit_creased_near(&bounds_a, &pair.pose_ab, margin, |tet_b| {
            let posed_b = pair.posed_tet(tet_b);
            pair.visit_partners(Culling::default(), &posed_b, |tet_a| {
                self.enter_pair(tet_a, tet_b);
            });
        });
    }

    fn enter_at_creases_of_a(&mut self, seeds_a: &RimlessSeeds, shape_b: &Shape) {
        let (pair, margin, tree_b) = (self.pair, self.pair.margin(), shape_b.tree());
        let pose_ba = pair.pose_ab.inverse();
        seeds_a.visit_creased_near(&tree_b.bounds(), &pose_ba, margin, |tet_a| {
            let posed_a = pair.tet_a(tet_a).tetrahedron.posed(&pose_ba);
            let query = posed_a.aabb().inflated(margin);
            tree_b.visit_overlapping(&query, |tet_b| self.enter_pair(tet_a, tet_b));
        });
    }

    /// Where the pressures become equal on an escape of either body.
    fn enter_at_escapes(&mut self, shape_b: &Shape, [seeds_a, seeds_b]: [&RimlessSeeds; 2]) {
        let (pair, margin) = (self.pair, self.pair.margin());
        let field = |shape, modulus| Field { shape, modulus };
        let a = field(pair.shape_a, pair.scales[0]);
        let b = field(shape_b, pair.scales[1]);
        visit_escapes(
            (&b, seeds_b),
            &a,
            (&pair.pose_ab, margin),
            |tet_b, tet_a| {
                self.enter_pair(tet_a, tet_b);
            },
        );
        let pose_ba = pair.pose_ab.inverse();
        visit_escapes((&a, seeds_a), &b, (&pose_ba, margin), |tet_a, tet_b| {
            self.enter_pair(tet_a, tet_b);
        });
    }
}

/// The pressure field of a body.
struct Field<'a> {
    shape: &'a Shape,
    modulus: f64,
}

/// Visits the tetrahedra of a body at an escape, and of the other body, in which the pressures become equal on it; from the pose of
/// the body in the other, and what counts as zero as a distance.
fn visit_escapes(
    (own, seeds): (&Field, &RimlessSeeds),
    other: &Field,
    (pose, margin): (&Pose<f64>, f64),
    mut visit: impl FnMut(usize, usize),
) {
    let tree = other.shape.tree();
    let [own_tets, other_tets] = [own, other].map(|body| body.shape.field().tets());
    seeds.visit_escapes_near(&tree.bounds(), pose, margin, |Escape { tet, corners }| {
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
    });
}

/// Whether an affine function with these values, each to within the tolerance, may be zero between them.
fn may_be_zero(values: &[f64], tolerance: f64) -> bool {
    values.iter().any(|&value| value <= tolerance)
        && values.iter().any(|&value| value >= -tolerance)
}

/// A surface triangle of B in A's frame.
struct Triangle {
    corners: [Vector3<f64>; 3],
    /// 0 on its plane.
    plane: AffineField,
    steepness: f64,
}

impl Triangle {
    fn of(tet_b: &FieldTet, face: usize, pose_ab: &Pose<f64>) -> Self {
        let corners = &tet_b.tetrahedron.corners;
        Self {
            corners: FACES[face].map(|corner| pose_ab.transformed_point(&corners[corner])),
            plane: tet_b.barycentric[face].posed(pose_ab),
            steepness: tet_b.barycentric_steepness[face],
        }
    }

    /// Whether neither this plane nor that of a face of A has all of the other triangle on one side,
    /// further than the margin (m).
    fn may_cross(&self, tet_a: &FieldTet, face: usize, margin: f64) -> bool {
        let is_cut = |plane: &AffineField, tolerance: f64, corners: [&Vector3<f64>; 3]| {
            may_be_zero(&corners.map(|corner| plane.at(corner)), tolerance)
        };
        let corners_a = FACES[face].map(|corner| &tet_a.tetrahedron.corners[corner]);
        let tolerance_a = margin * tet_a.barycentric_steepness[face];
        is_cut(
            &tet_a.barycentric[face],
            tolerance_a,
            self.corners.each_ref(),
        ) && is_cut(&self.plane, margin * self.steepness, corners_a)
    }
}
