use super::elastic::ElasticWrench;
use super::integrate::CutSurface;
use super::motion::{Motion, RelativeMotion};
use super::moving_wrench::MovingWrench;
use super::polygon_source::PolygonSource;
use super::{
    ContactBody, ContactPolygon, ContactSurface, ContactWrench, Partner, Search, SurfaceLaw,
};
use crate::scalar::{Order, Scalar, real_part};
use crate::spatial::{Pose, Twist, Wrench};

/// Two bodies that may touch: the wrench, its derivatives, the contact surface and the potential energy of their contact.
///
/// A is a compliant body with a mesh. B is any [`Partner`]: another compliant body, a rigid one, or a half-space. A rigid B has
/// no modulus, and derivatives by it are 0. There is no contact of rigid bodies and half-spaces among themselves.
///
/// A new pair is at rest, and its contact elastic. [`Self::moving`] gives it twists and a law for dissipation and friction.
///
/// Wrench, contact surface and energy are generic over the scalar: with `f64` poses and moduli they are values, with dual
/// numbers they carry derivatives of any order. If the bodies do not touch, the surface is empty, and the wrench and its
/// derivatives are zero.
#[derive(Debug, Clone, Copy)]
pub struct ContactPair<'a, T = f64> {
    a: ContactBody<'a, T>,
    b: Partner<'a, T>,
    search: Search,
    /// None for a pair at rest.
    motion: Option<Motion<T>>,
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
    /// A pair at rest, with the default search.
    #[inline]
    #[must_use]
    pub fn new(a: ContactBody<'a, T>, b: impl Into<Partner<'a, T>>) -> Self {
        Self {
            a,
            b: b.into(),
            search: Search::default(),
            motion: None,
        }
    }

    /// The same pair in motion, with a law for dissipation and friction. Twists are in world axes; the linear part is the velocity of
    /// the body's origin. The contact surface and the potential energy do not depend on the motion.
    #[must_use]
    pub fn moving(self, law: SurfaceLaw<T>, twists: [Twist<T>; 2]) -> Self {
        Self {
            motion: Some(Motion { law, twists }),
            ..self
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

    /// The exact contact wrenches (the paper, §III-C and §III-D). For a pair in motion they include dissipation and friction, integrated
    /// exactly.
    #[must_use]
    pub fn wrench(&self) -> ContactWrench<T> {
        if Order::<T>::IS_FIRST {
            let (linearisation, ()) = self.relative_linearisation();
            return self.wrench_from_a(&linearisation.pushforward(&self.tangent()));
        }
        self.pipeline().wrench()
    }

    /// The contact surface, polygon by polygon.
    #[must_use]
    pub fn surface(&self) -> ContactSurface<T> {
        self.surface_of(&self.cut_surface())
    }

    /// Contact surface and wrenches; `None` if the bodies do not touch. In `f64`, and for derivatives of second and higher order,
    /// one search gives both.
    pub(crate) fn surface_and_wrench(&self) -> Option<(ContactSurface<T>, ContactWrench<T>)> {
        let cuts = self.cut_surface();
        let surface = self.surface_of(&cuts);
        if surface.is_empty() {
            return None;
        }
        let wrench = if Order::<T>::IS_FIRST {
            self.wrench()
        } else {
            self.wrench_from_a(&match self.relative_motion() {
                Some((law, motion)) => cuts.integral(&MovingWrench { law, motion }),
                None => cuts.integral(&ElasticWrench),
            })
        };
        Some((surface, wrench))
    }

    fn surface_of(&self, surface: &CutSurface<T>) -> ContactSurface<T> {
        let polygons = surface.sum_of_cuts(|polygons: &mut Vec<_>, cut| {
            if let Some(in_plane) = surface.source.pressed_polygon(cut) {
                let polygon = surface.source.polygon_in_space(cut);
                polygons.push(ContactPolygon::of(
                    cut.tets,
                    (&polygon, &in_plane),
                    self.a.pose(),
                ));
            }
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
        self.source().energy()
    }

    /// The pairs of tetrahedra (of A, of B) that have a contact polygon, in no special order. Where B is a rigid body, its
    /// triangles take the place of tetrahedra; where it is a half-space, that number is 0.
    #[must_use]
    pub fn touching_tets(&self) -> Vec<[usize; 2]> {
        let surface = self.real().cut_surface();
        surface.sum_of_cuts(|tets: &mut Vec<_>, cut| {
            tets.extend(surface.source.is_pressed(cut).then_some(cut.tets));
        })
    }

    /// Counts the work that the wrench takes.
    #[must_use]
    pub fn work_count(&self) -> WorkCount {
        let surface = self.real().cut_surface();
        WorkCount {
            candidate_pairs: surface.found.candidates,
            polygons: surface.polygon_count(),
        }
    }

    /// Both wrenches in the world, from the one on A about A's origin in A's axes.
    pub(super) fn wrench_from_a(&self, wrench_a: &Wrench<T>) -> ContactWrench<T> {
        ContactWrench::from_a(wrench_a, [self.a.pose(), self.b.pose()])
    }

    /// The source of the pair's contact polygons.
    pub(super) fn source(&self) -> PolygonSource<'a, T> {
        PolygonSource::of(&self.a, &self.b)
    }

    /// The cuts that values are made from.
    pub(super) fn cut_surface(&self) -> CutSurface<'a, T> {
        self.source().for_values(self.search)
    }

    pub(super) fn moduli(&self) -> [T; 2] {
        [self.a.modulus(), self.b.scale()]
    }

    /// The pair at rest.
    pub(super) fn at_rest(&self) -> Self {
        Self {
            motion: None,
            ..*self
        }
    }

    /// The motion of the bodies, or `None` for a pair at rest.
    pub(crate) fn motion(&self) -> Option<&Motion<T>> {
        self.motion.as_ref()
    }

    /// The law and the velocity of A relative to B, or `None` for a pair at rest.
    pub(super) fn relative_motion(&self) -> Option<(SurfaceLaw<T>, RelativeMotion<T>)> {
        let Motion { law, twists } = self.motion()?;
        let poses = [self.a.pose(), self.b.pose()];
        Some((*law, RelativeMotion::of(poses, twists)))
    }

    /// The pair at rest without derivatives, in A's frame.
    pub(super) fn real(&self) -> ContactPair<'a> {
        let pose_ab = self.a.pose().real().inverse() * self.b.pose().real();
        self.at_rest().real_at([Pose::identity(), pose_ab])
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
            motion: self.motion.as_ref().map(Motion::real),
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
        let pair = self.0;
        let source = pair.source();
        pair.wrench_from_a(&match pair.relative_motion() {
            Some((law, motion)) => {
                source.integral_for_values(pair.search, &MovingWrench { law, motion })
            }
            None => source.integral_for_values(pair.search, &ElasticWrench),
        })
    }
}
