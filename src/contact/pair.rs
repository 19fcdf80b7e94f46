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
/// A is a compliant body with a mesh. B is any [`Partner`]: another compliant body, a rigid one, or a half-space. A rigid B has no modulus,
/// and derivatives with respect to it are zero. Contact among rigid bodies and half-spaces is not supported.
///
/// A new pair is at rest, and its contact is elastic. [`Self::moving`] sets twists and a law for dissipation and friction.
///
/// The wrench, the contact surface and the energy are generic over the scalar: with `f64` poses and moduli they are values, with dual
/// numbers they carry derivatives of any order. If the bodies do not touch, the surface is empty, and the wrench and its derivatives are
/// zero.
#[derive(Debug, Clone, Copy)]
pub struct ContactPair<'a, T = f64> {
    a: ContactBody<'a, T>,
    b: Partner<'a, T>,
    search: Search,
    /// `None` for a pair at rest.
    motion: Option<Motion<T>>,
}

/// The contact of a pair computed entirely in the scalar: all geometry, clipping and integration carry the derivatives.
/// [`ContactPair::wrench`] does this only for `f64` and for derivatives of second and higher order.
///
/// It is slower than the [linearized contact](super::LinearizedContact), and serves to check it. If faces of both bodies coincide, its
/// derivatives are one-sided, or are lost in round-off.
#[derive(Debug, Clone, Copy)]
pub struct Pipeline<'p, 'a, T>(pub(super) &'p ContactPair<'a, T>);

/// Amount of work for a contact. It depends only on the bodies, the poses and the search, and is the same in every run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct WorkCount {
    /// Number of pairs of tetrahedra that were examined.
    pub candidate_pairs: usize,
    /// Number of contact polygons.
    pub polygons: usize,
}

impl<'a, T: Scalar> ContactPair<'a, T> {
    /// Creates a pair at rest, with the default search.
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

    /// Returns the same pair in motion, with a law for dissipation and friction. Twists are in world axes; their linear part is the
    /// velocity of the body's origin. The contact surface and the potential energy do not depend on the motion.
    #[must_use]
    pub fn moving(self, law: SurfaceLaw<T>, twists: [Twist<T>; 2]) -> Self {
        Self {
            motion: Some(Motion { law, twists }),
            ..self
        }
    }

    /// Returns the same pair with another search. The search changes the computing time, but not the results.
    #[must_use]
    pub fn with_search(self, search: Search) -> Self {
        Self { search, ..self }
    }

    /// Returns this contact computed entirely in the scalar, with first derivatives also carried through the clips.
    #[must_use]
    pub fn pipeline(&self) -> Pipeline<'_, 'a, T> {
        Pipeline(self)
    }

    /// Returns body A.
    #[must_use]
    pub fn a(&self) -> &ContactBody<'a, T> {
        &self.a
    }

    /// Returns body B.
    #[must_use]
    pub fn b(&self) -> &Partner<'a, T> {
        &self.b
    }

    /// Returns the exact contact wrenches (the paper, §III-C and §III-D). For a pair in motion they include dissipation and friction,
    /// integrated exactly.
    #[must_use]
    pub fn wrench(&self) -> ContactWrench<T> {
        if Order::<T>::IS_FIRST {
            let (linearization, ()) = self.relative_linearization();
            return self.wrench_from_a(&linearization.pushforward(&self.tangent()));
        }
        self.pipeline().wrench()
    }

    /// Returns the contact surface with all its polygons.
    #[must_use]
    pub fn surface(&self) -> ContactSurface<T> {
        self.surface_of(&self.cut_surface())
    }

    /// Returns the contact surface and the wrenches, or `None` if the bodies do not touch. For `f64`, and for derivatives of second and
    /// higher order, both come from one search.
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

    /// Returns the potential energy (J) of the contact: ∫ min(p_A, p_B) dV over the overlap, or ∫ p_A dV if B is rigid. The wrench is minus
    /// the derivative of this energy with respect to a rigid motion.
    ///
    /// Takes much longer than the wrench, about a hundred times for large meshes, because all overlapping tetrahedra contribute, not only
    /// those at the contact surface.
    #[must_use]
    pub fn potential_energy(&self) -> T {
        self.source().energy()
    }

    /// Returns the pairs of tetrahedra (of A, of B) with a contact polygon, in no particular order. If B is a rigid body, the second index
    /// is the index of a triangle. If B is a half-space, the second index is 0.
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
            candidate_pairs: surface.search_result.candidates,
            polygons: surface.polygon_count(),
        }
    }

    /// Returns both wrenches in the world, from the wrench on A about A's origin in A's axes.
    pub(super) fn wrench_from_a(&self, wrench_a: &Wrench<T>) -> ContactWrench<T> {
        ContactWrench::from_a(wrench_a, [self.a.pose(), self.b.pose()])
    }

    /// Returns the source of the pair's contact polygons.
    pub(super) fn source(&self) -> PolygonSource<'a, T> {
        PolygonSource::of(&self.a, &self.b)
    }

    /// Returns the cuts from which values are computed.
    pub(super) fn cut_surface(&self) -> CutSurface<'a, T> {
        self.source().for_values(self.search)
    }

    pub(super) fn moduli(&self) -> [T; 2] {
        [self.a.modulus(), self.b.scale()]
    }

    /// Returns the pair at rest.
    pub(super) fn at_rest(&self) -> Self {
        Self {
            motion: None,
            ..*self
        }
    }

    /// Returns the motion of the bodies, or `None` for a pair at rest.
    pub(crate) fn motion(&self) -> Option<&Motion<T>> {
        self.motion.as_ref()
    }

    /// Returns the law and the velocity of A relative to B, or `None` for a pair at rest.
    pub(super) fn relative_motion(&self) -> Option<(SurfaceLaw<T>, RelativeMotion<T>)> {
        let Motion { law, twists } = self.motion()?;
        let poses = [self.a.pose(), self.b.pose()];
        Some((*law, RelativeMotion::of(poses, twists)))
    }

    /// Returns the pair at rest without derivatives, in A's frame.
    pub(super) fn real(&self) -> ContactPair<'a> {
        let pose_ab = self.a.pose().real().inverse() * self.b.pose().real();
        self.at_rest().real_at([Pose::identity(), pose_ab])
    }

    /// Returns the pair without derivatives, at its poses in the world.
    pub(super) fn real_in_world(&self) -> ContactPair<'a> {
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
    /// Computes the wrenches like [`ContactPair::wrench`].
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
