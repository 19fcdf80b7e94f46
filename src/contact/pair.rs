use super::jacobian::RelativeJacobian;
use super::linearised::RelativeLinearisation;
use super::polygon::{CutPolygon, CutSurface, PartialSum, PolygonSource};
use super::surface_law::RelativeMotion;
use super::{
    ContactBody, ContactJacobian, ContactPolygon, ContactSurface, ContactWrench, Partner, Search,
    SurfaceLaw,
};
use crate::narrow_phase::{ELASTIC_COINCIDENCE, Weights};
use crate::scalar::{Order, Scalar, real_part};
use crate::spatial::{Pose, Twist};

/// Two bodies that may touch: the wrench, the contact surface, the potential energy and the
/// Jacobian of their contact.
///
/// A is a compliant body with a mesh. B is any [`Partner`]: another compliant body, a rigid one, or a half-space. A rigid B has
/// no modulus, and derivatives by it are 0. There is no contact of rigid bodies and half-spaces among themselves.
///
/// Every quantity is generic over the scalar: with `f64` poses and moduli it is a value, with dual
/// numbers it carries derivatives of whatever order they have. No contact is an empty surface and
/// a zero wrench with zero derivatives.
#[derive(Debug, Clone, Copy)]
pub struct ContactPair<'a, T = f64> {
    a: ContactBody<'a, T>,
    b: Partner<'a, T>,
    search: Search,
}

/// The contact of a pair computed in the scalar throughout: all geometry, clipping and integration carry the derivatives.
/// [`ContactPair::wrench`] does so only for `f64` and for derivatives of second and higher order.
///
/// It is slower than the [linearised contact](super::LinearisedContact), which can be checked against it. Where faces of
/// both bodies coincide, its derivatives are those of one side, or lost in round-off.
#[derive(Debug, Clone, Copy)]
pub struct Pipeline<'p, 'a, T>(pub(super) &'p ContactPair<'a, T>);

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
    #[inline]
    #[must_use]
    pub fn new(a: ContactBody<'a, T>, b: impl Into<Partner<'a, T>>) -> Self {
        Self {
            a,
            b: b.into(),
            search: Search::default(),
        }
    }

    /// The same pair with another search: other times, the same results.
    #[must_use]
    pub fn with_search(self, search: Search) -> Self {
        Self { search, ..self }
    }

    /// This contact computed in the scalar throughout, with first derivatives taken through the clips too.
    #[must_use]
    pub fn pipeline(&self) -> Pipeline<'_, 'a, T> {
        Pipeline(self)
    }

    /// Body A.
    #[must_use]
    pub fn a(&self) -> &ContactBody<'a, T> {
        &self.a
    }

    /// Body B.
    #[must_use]
    pub fn b(&self) -> &Partner<'a, T> {
        &self.b
    }

    /// The exact contact wrenches (the paper, §III-C and §III-D).
    #[must_use]
    pub fn wrench(&self) -> ContactWrench<T> {
        if Order::<T>::IS_FIRST {
            let linearisation = self.real().relative_linearisation();
            return self.wrench_from_a(&linearisation.pushforward(&self.tangent()));
        }
        self.pipeline().wrench()
    }

    /// The wrenches and their derivatives by both poses and both moduli, in closed form from the
    /// polygons' areas and moments: exact, and right also where a derivative through the clipping
    /// would be lost in round-off.
    ///
    /// Wrenches and motions are in world axes, about each body's own origin. Faces within 2e-12 of the bodies' size of each
    /// other count as coincident in the Jacobian, which is there the mean of both sides (about one generic direction where
    /// several coincide).
    #[must_use]
    pub fn wrench_and_jacobian(&self) -> (ContactWrench<T>, ContactJacobian<T>) {
        let linearised = self.linearised_at_rest();
        (linearised.wrench, ContactJacobian::of(&linearised))
    }

    /// The elastic contact in A's axes.
    pub(super) fn relative_linearisation(&self) -> RelativeLinearisation<T> {
        let source = PolygonSource::of(self);
        let ((surface, finer), spilled) =
            source.for_sum_of_derivatives(ELASTIC_COINCIDENCE, self.search);
        let add = |sum: &mut RelativeJacobian<T>, polygon: &CutPolygon<T>| polygon.add_to(sum);
        let mut elastic = surface.sum_of_moments(Weights::have_area, add);
        elastic.merge(spilled);
        self.elastic_linearisation(&elastic, (&surface, finer.as_ref()))
    }

    /// From the sums over the surface that derivatives are made from, and that of values, if it is another.
    pub(super) fn elastic_linearisation(
        &self,
        elastic: &RelativeJacobian<T>,
        (surface, finer): (&CutSurface<T>, Option<&CutSurface<T>>),
    ) -> RelativeLinearisation<T> {
        let mut linearisation = elastic.linearisation(self.moduli());
        linearisation.kinks.are_equal = surface.has_equal_fields();
        linearisation.kinks.are_flush |= surface.touches();
        if let Some(finer) = finer {
            linearisation.wrench = finer.wrench().to_vector();
            linearisation.kinks.are_flush = true;
        }
        linearisation
    }

    /// The contact surface, polygon by polygon.
    #[must_use]
    pub fn surface(&self) -> ContactSurface<T> {
        self.surface_of(&self.cut_surface())
    }

    /// Contact surface and wrenches; `None` if the bodies do not touch. `moving` has the law and the twists of bodies in motion,
    /// and is `None` for bodies at rest. In `f64`, and for derivatives of second and higher order, one search gives both.
    pub(crate) fn surface_and_wrench(
        &self,
        moving: Option<(&SurfaceLaw<T>, [Twist<T>; 2])>,
    ) -> Option<(ContactSurface<T>, ContactWrench<T>)> {
        let cuts = self.cut_surface();
        let surface = self.surface_of(&cuts);
        if surface.is_empty() {
            return None;
        }
        let wrench = match moving {
            Some((law, twists)) if Order::<T>::IS_FIRST => self.wrench_in_motion(law, twists),
            None if Order::<T>::IS_FIRST => self.wrench(),
            Some((law, twists)) => {
                let motion = RelativeMotion::of(self, twists);
                self.wrench_from_a(&cuts.wrench_in_motion(law, &motion))
            }
            None => self.wrench_from_a(&cuts.wrench()),
        };
        Some((surface, wrench))
    }

    fn surface_of(&self, surface: &CutSurface<T>) -> ContactSurface<T> {
        let polygons = surface.sum_of_cuts(|polygons: &mut Vec<_>, cut| {
            let pressed = surface.source.pressed_polygon(cut);
            polygons.extend(pressed.map(|p| ContactPolygon::of(cut.tets, &p, self.a.pose())));
        });
        ContactSurface { polygons }
    }

    /// Potential energy (J) of the contact: ∫ min(p_A, p_B) dV over the overlap, or ∫ p_A dV where B is rigid. The wrench is
    /// minus its derivative by a rigid motion.
    ///
    /// Takes much longer than the wrench, for large meshes a hundred times: all overlapping tetrahedra
    /// contribute, not only those at the contact surface.
    #[must_use]
    pub fn potential_energy(&self) -> T {
        PolygonSource::of(self).energy()
    }

    /// The pairs of tetrahedra (of A, of B) that have a contact polygon, in no special order. Where B is a rigid body, its
    /// triangles take the place of tetrahedra; where it is a half-space, that number is 0.
    #[must_use]
    pub fn touching_tets(&self) -> Vec<[usize; 2]> {
        let surface = self.real().cut_surface();
        surface.sum_of_cuts(|tets: &mut Vec<_>, cut| {
            let is_pressed = surface.source.pressed_polygon(cut).is_some();
            tets.extend(is_pressed.then_some(cut.tets));
        })
    }

    /// Counts the work that the wrench takes.
    #[must_use]
    pub fn work_count(&self) -> WorkCount {
        let surface = self.real().cut_surface();
        WorkCount {
            candidate_pairs: surface.found.candidates,
            polygons: surface.sum(|polygons: &mut usize, _| *polygons += 1),
        }
    }

    /// The cuts that values are made from.
    pub(super) fn cut_surface(&self) -> CutSurface<'a, T> {
        PolygonSource::of(self).for_values(self.search)
    }

    pub(super) fn moduli(&self) -> [T; 2] {
        [self.a.modulus(), self.b.scale()]
    }

    /// The pair without derivatives, in A's frame.
    pub(super) fn real(&self) -> ContactPair<'a> {
        let pose_ab = self.a.pose().real().inverse() * self.b.pose().real();
        self.real_at([Pose::identity(), pose_ab])
    }

    /// The pair without derivatives, where it is.
    pub(super) fn real_in_place(&self) -> ContactPair<'a> {
        self.real_at([self.a.pose().real(), self.b.pose().real()])
    }

    fn real_at(&self, [pose_a, pose_b]: [Pose; 2]) -> ContactPair<'a> {
        let modulus = real_part(self.a.modulus());
        ContactPair {
            a: ContactBody::from_valid(self.a.shape(), pose_a, modulus),
            b: self.b.with(pose_b, real_part),
            search: self.search,
        }
    }

    pub(crate) fn search(&self) -> Search {
        self.search
    }
}

impl<T: Scalar> Pipeline<'_, '_, T> {
    /// [`ContactPair::wrench`].
    #[must_use]
    pub fn wrench(&self) -> ContactWrench<T> {
        let source = PolygonSource::of(self.0);
        let (surface, spilled) = source.for_sum_of_values(self.0.search);
        let mut wrench = surface.wrench();
        wrench.merge(spilled);
        self.0.wrench_from_a(&wrench)
    }
}
