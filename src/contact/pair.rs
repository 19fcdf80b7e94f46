use super::equilibrium::RoundOff;
use super::jacobian::RelativeJacobian;
use super::narrow_phase::{NarrowPhase, PairPolygon, TetOfB};
use super::{ContactBody, ContactJacobian, ContactPolygon, ContactSurface, ContactWrench, Culling};
use crate::broad_phase::Projections;
use crate::mesh::FieldTet;
use crate::scalar::{Scalar, lift, real_part};
use crate::spatial::{Pose, Wrench};

/// Two bodies that may touch: the wrench, the contact surface, the potential energy and the
/// Jacobian of their contact.
///
/// Every quantity is generic over the scalar: with `f64` poses and moduli it is a value, with dual
/// numbers it carries derivatives of whatever order they have. No contact is an empty surface and
/// a zero wrench with zero derivatives.
#[derive(Debug, Clone, Copy)]
pub struct ContactPair<'a, T = f64> {
    a: ContactBody<'a, T>,
    b: ContactBody<'a, T>,
    culling: Culling,
}

/// How much work a contact took: the same for the same bodies in every run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WorkCount {
    /// Pairs of tetrahedra that the broad phase left over.
    pub candidate_pairs: usize,
    /// Contact polygons.
    pub polygons: usize,
}

impl<'a, T: Scalar> ContactPair<'a, T> {
    /// A pair with the default culling.
    #[must_use]
    pub fn new(a: ContactBody<'a, T>, b: ContactBody<'a, T>) -> Self {
        Self {
            a,
            b,
            culling: Culling::default(),
        }
    }

    /// The same pair with other culling: other times, the same results.
    #[must_use]
    pub fn with_culling(self, culling: Culling) -> Self {
        Self { culling, ..self }
    }

    /// Body A.
    #[must_use]
    pub fn a(&self) -> &ContactBody<'a, T> {
        &self.a
    }

    /// Body B.
    #[must_use]
    pub fn b(&self) -> &ContactBody<'a, T> {
        &self.b
    }

    /// The exact contact wrenches (the paper, §III-C and §III-D).
    #[must_use]
    pub fn wrench(&self) -> ContactWrench<T> {
        let mut wrench_a = Wrench::zero();
        self.visit_polygons(|polygon| wrench_a += polygon.wrench());
        ContactWrench::from_wrench_a(wrench_a, self.a.pose(), &self.pose_ab())
    }

    /// The wrenches and their derivatives by both poses and both moduli, in closed form from the
    /// polygons' areas and moments: exact, and right also where a derivative through the clipping
    /// would be lost in round-off.
    #[must_use]
    pub fn wrench_and_jacobian(&self) -> (ContactWrench<T>, ContactJacobian<T>) {
        let relative = self.relative_jacobian();
        let (pose_wa, pose_ab) = (self.a.pose(), self.pose_ab());
        let wrench = ContactWrench::from_wrench_a(relative.wrench(), pose_wa, &pose_ab);
        let moduli = [self.a.modulus(), self.b.modulus()];
        let jacobian = relative.in_world(&wrench, pose_wa, &pose_ab, moduli);
        (wrench, jacobian)
    }

    pub(super) fn relative_jacobian(&self) -> RelativeJacobian<T> {
        let mut relative = RelativeJacobian::zero();
        self.visit_polygons(|polygon| polygon.add_to(&mut relative));
        relative
    }

    /// The contact surface, polygon by polygon.
    #[must_use]
    pub fn surface(&self) -> ContactSurface<T> {
        let mut polygons = Vec::new();
        self.visit_polygons(|polygon| {
            if !polygon.flush {
                polygons.push(ContactPolygon::from_pair(polygon, self.a.pose()));
            }
        });
        ContactSurface { polygons }
    }

    /// Potential energy (J) of the contact: ∫ min(p_A, p_B) dV over the overlap. The wrench is
    /// minus its derivative by a rigid motion.
    ///
    /// Takes several times as long as the wrench: all overlapping tetrahedra contribute, not
    /// only those at the contact surface.
    #[must_use]
    pub fn potential_energy(&self) -> T {
        let narrow_phase = self.narrow_phase();
        let mut energy = lift(0.0);
        self.visit_candidates(&narrow_phase, |tet_a, tet_b| {
            energy += narrow_phase.energy(tet_a, tet_b);
        });
        energy
    }

    /// The pairs of tetrahedra (of A, of B) that have a contact polygon, in no special order.
    #[must_use]
    pub fn touching_tets(&self) -> Vec<[usize; 2]> {
        let mut touching = Vec::new();
        self.visit_polygons(|polygon| {
            if !polygon.flush {
                touching.push(polygon.tets);
            }
        });
        touching
    }

    /// Counts the work the wrench takes.
    #[must_use]
    pub fn work_count(&self) -> WorkCount {
        let narrow_phase = self.narrow_phase();
        let (mut candidate_pairs, mut polygons) = (0, 0);
        self.visit_candidates(&narrow_phase, |tet_a, tet_b| {
            candidate_pairs += 1;
            polygons += usize::from(narrow_phase.polygon(tet_a, tet_b).is_some());
        });
        WorkCount {
            candidate_pairs,
            polygons,
        }
    }

    pub(super) fn pose_ab(&self) -> Pose<T> {
        self.a.pose().inverse() * *self.b.pose()
    }

    fn narrow_phase(&self) -> NarrowPhase<T> {
        let (field_a, field_b) = (self.a.shape().field(), self.b.shape().field());
        let steepest_a = real_part(self.a.modulus()) * field_a.steepest();
        let steepest_b = real_part(self.b.modulus()) * field_b.steepest();
        let pose_ab = self.pose_ab();
        NarrowPhase {
            modulus_a: self.a.modulus(),
            modulus_b: self.b.modulus(),
            real_pose_ab: pose_ab.real(),
            pose_ab,
            round_off: RoundOff {
                length: field_a.reach() + field_b.reach(),
                steepest: steepest_a.max(steepest_b),
            },
            plane_check: self.culling.plane_check,
        }
    }

    pub(super) fn visit_polygons(&self, mut visit: impl FnMut(&PairPolygon<T>)) {
        let narrow_phase = self.narrow_phase();
        self.visit_candidates(&narrow_phase, |tet_a, tet_b| {
            if let Some(polygon) = narrow_phase.polygon(tet_a, tet_b) {
                visit(&polygon);
            }
        });
    }

    /// Visits the pairs of tetrahedra that culling leaves over.
    fn visit_candidates<'n>(
        &'n self,
        narrow_phase: &'n NarrowPhase<T>,
        mut visit: impl FnMut(&FieldTet, &TetOfB<'n, T>),
    ) {
        let (shape_a, shape_b) = (self.a.shape(), self.b.shape());
        let (tets_a, tets_b) = (shape_a.field().tets(), shape_b.field().tets());
        let margin = narrow_phase.round_off.margin();
        let directions = self.culling.projections;
        let visit_partners = |index_b: usize| {
            let tet_b = narrow_phase.tet_of_b(&tets_b[index_b]);
            let query = tet_b.tetrahedron.aabb().inflated(margin);
            let shadows = (directions > 0).then(|| Projections::of(&tet_b.tetrahedron));
            let visit_partner = |index_a: usize| {
                let own = shape_a.tree().projections(index_a);
                let apart = |shadows| own.separate(shadows, directions, margin);
                if !shadows.as_ref().is_some_and(apart) {
                    visit(&tets_a[index_a], &tet_b);
                }
            };
            if self.culling.tree {
                shape_a.tree().visit_overlapping(&query, visit_partner);
            } else {
                let boxes = self.culling.bounding_boxes;
                (0..tets_a.len())
                    .filter(|&a| !tets_a[a].is_inert())
                    .filter(|&a| !boxes || tets_a[a].tetrahedron.aabb().overlaps(&query))
                    .for_each(visit_partner);
            }
        };
        if self.culling.tree {
            let (region, pose_ab) = (shape_a.tree().bounds(), &narrow_phase.real_pose_ab);
            shape_b
                .tree()
                .visit_near(&region, pose_ab, margin, visit_partners);
        } else {
            (0..tets_b.len())
                .filter(|&b| !tets_b[b].is_inert())
                .for_each(visit_partners);
        }
    }
}
