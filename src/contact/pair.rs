use super::jacobian::RelativeJacobian;
use super::polygon::{NarrowPhase, PairPolygon};
use super::{ContactBody, ContactJacobian, ContactPolygon, ContactSurface, ContactWrench, Search};
use crate::narrow_phase::Meeting;
use crate::narrow_phase::RelativePair;
use crate::scalar::{Scalar, lift};
use crate::search::PartialSum;
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
    search: Search,
}

/// How much work a contact took: the same for the same bodies, poses and search in every run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct WorkCount {
    /// Pairs of tetrahedra that were looked at.
    pub candidate_pairs: usize,
    /// Contact polygons.
    pub polygons: usize,
}

impl<'a, T: Scalar> ContactPair<'a, T> {
    /// A pair with the default search.
    #[must_use]
    pub fn new(a: ContactBody<'a, T>, b: ContactBody<'a, T>) -> Self {
        Self {
            a,
            b,
            search: Search::default(),
        }
    }

    /// The same pair with another search: other times, the same results.
    #[must_use]
    pub fn with_search(self, search: Search) -> Self {
        Self { search, ..self }
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
        let add = |sum: &mut Wrench<T>, polygon: &PairPolygon<T>| *sum += polygon.wrench();
        let wrench_a = self.sum_polygons(add);
        self.wrench_from_a(&wrench_a)
    }

    /// The wrenches and their derivatives by both poses and both moduli, in closed form from the
    /// polygons' areas and moments: exact, and right also where a derivative through the clipping
    /// would be lost in round-off.
    #[must_use]
    pub fn wrench_and_jacobian(&self) -> (ContactWrench<T>, ContactJacobian<T>) {
        let relative = self.relative_jacobian();
        let (pose_wa, pose_ab) = (self.a.pose(), self.pose_ab());
        let wrench = self.wrench_from_a(&relative.wrench());
        let moduli = [self.a.modulus(), self.b.modulus()];
        let jacobian = relative.in_world(&wrench, pose_wa, &pose_ab, moduli);
        (wrench, jacobian)
    }

    pub(super) fn relative_jacobian(&self) -> RelativeJacobian<T> {
        self.sum_polygons(|sum, polygon| polygon.add_to(sum))
    }

    /// The contact surface, polygon by polygon.
    #[must_use]
    pub fn surface(&self) -> ContactSurface<T> {
        let polygons = self.sum_polygons(|polygons: &mut Vec<_>, polygon| {
            if !polygon.flush && polygon.has_area() {
                polygons.push(ContactPolygon::from_pair(polygon, self.a.pose()));
            }
        });
        ContactSurface { polygons }
    }

    /// Potential energy (J) of the contact: ∫ min(p_A, p_B) dV over the overlap. The wrench is
    /// minus its derivative by a rigid motion.
    ///
    /// Takes much longer than the wrench, for large meshes a hundred times: all overlapping tetrahedra
    /// contribute, not only those at the contact surface.
    #[must_use]
    pub fn potential_energy(&self) -> T {
        let narrow_phase = self.narrow_phase();
        let shadow = &narrow_phase.shadow;
        let mut energy = lift(0.0);
        shadow.visit_overlapping(|tet_a, tet_b| {
            energy += narrow_phase.energy(shadow.tet_a(tet_a), tet_b);
        });
        energy
    }

    /// The pairs of tetrahedra (of A, of B) that have a contact polygon, in no special order.
    #[must_use]
    pub fn touching_tets(&self) -> Vec<[usize; 2]> {
        let mut touching = self.sum_polygons(|touching: &mut Vec<_>, polygon| {
            if !polygon.flush && polygon.has_area() {
                touching.push(polygon.tets);
            }
        });
        // With derivatives, a polygon may come as two halves.
        touching.dedup();
        touching
    }

    /// Counts the work the wrench takes.
    #[must_use]
    pub fn work_count(&self) -> WorkCount {
        let narrow_phase = self.narrow_phase();
        let add = |polygons: &mut usize, meeting: &Meeting| {
            let mut has_area = false;
            narrow_phase.visit_polygon(meeting, |polygon| has_area |= polygon.has_area());
            *polygons += usize::from(has_area);
        };
        let found = narrow_phase.shadow.sum_meetings(self.search, add);
        WorkCount {
            candidate_pairs: found.candidates,
            polygons: found.sum,
        }
    }

    pub(super) fn pose_ab(&self) -> Pose<T> {
        self.a.pose().inverse() * *self.b.pose()
    }

    fn narrow_phase(&self) -> NarrowPhase<'a, T> {
        let pose_ab = self.pose_ab();
        NarrowPhase {
            shadow: RelativePair::of(&self.a, &self.b, &pose_ab),
            modulus_a: self.a.modulus(),
            modulus_b: self.b.modulus(),
            pose_ab,
        }
    }

    /// Adds up the contact polygons; with derivatives, also those without an area.
    pub(super) fn sum_polygons<S: PartialSum>(
        &self,
        add: impl Fn(&mut S, &PairPolygon<T>) + Sync,
    ) -> S {
        let narrow_phase = self.narrow_phase();
        let add_polygon = |sum: &mut S, meeting: &Meeting| {
            narrow_phase.visit_polygon(meeting, |polygon| {
                if polygon.counts() {
                    add(sum, polygon);
                }
            });
        };
        narrow_phase
            .shadow
            .sum_meetings(self.search, add_polygon)
            .sum
    }
}
