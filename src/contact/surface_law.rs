use super::{BodyError, ContactPair, ContactWrench, LinearisedContact, Pipeline};
use crate::scalar::{Order, Scalar, real_part, real_vector, times};
use crate::spatial::Twist;
use nalgebra::Vector3;
use std::ops::RangeInclusive;

/// Slip tolerances (m/s) of which squares and cubes, and their inverses, are numbers of double precision.
pub(crate) const SLIP_TOLERANCES: RangeInclusive<f64> = 1e-100..=1e100;

/// What the surfaces of a pair add to the elastic pressure when they move against each other.
///
/// With v the velocity of A relative to B at a point of the contact surface, v_n its part along the
/// normal (positive when separating) and v_t the rest, the pressure becomes
/// p' = p·max(0, 1 − d·v_n) with the dissipation d \[Hunt 1975\], and friction pulls A with the
/// traction −μ·p'·v_t/√(|v_t|² + v_s²): Coulomb's law made smooth at rest by the slip tolerance v_s.
///
/// Dissipation resists rolling too: skin that is pressed in pushes back more than skin that is let go.
#[derive(Debug, Clone, Copy)]
pub struct SurfaceLaw<T = f64> {
    pub(crate) dissipation: T,
    pub(crate) friction: T,
    pub(crate) slip_tolerance: f64,
}

impl<T: Scalar> SurfaceLaw<T> {
    /// From the Hunt–Crossley dissipation d (s/m), the coefficient of friction μ, and the slip
    /// tolerance v_s (m/s): the speed at which friction has 71 % of its full value.
    ///
    /// # Errors
    /// If dissipation or friction is negative or not finite, or the slip tolerance is not from 1e-100 to 1e100 m/s.
    pub fn new(dissipation: T, friction: T, slip_tolerance: f64) -> Result<Self, BodyError> {
        let not_negative = 0.0..=f64::MAX;
        let numbers = [
            ("dissipation", real_part(dissipation), &not_negative),
            ("friction", real_part(friction), &not_negative),
            ("slip tolerance", slip_tolerance, &SLIP_TOLERANCES),
        ];
        for (quantity, value, range) in numbers {
            if !range.contains(&value) {
                return Err(BodyError::SurfaceLaw { quantity, value });
            }
        }
        Ok(Self {
            dissipation,
            friction,
            slip_tolerance,
        })
    }
}

impl<T: Copy> SurfaceLaw<T> {
    /// Hunt–Crossley dissipation (s/m).
    #[must_use]
    pub fn dissipation(&self) -> T {
        self.dissipation
    }

    /// Coefficient of friction.
    #[must_use]
    pub fn friction(&self) -> T {
        self.friction
    }

    /// Slip tolerance (m/s).
    #[must_use]
    pub fn slip_tolerance(&self) -> f64 {
        self.slip_tolerance
    }
}

impl<T: Scalar> ContactPair<'_, T> {
    /// The contact wrenches of moving bodies. Each twist is in world axes, its linear part the
    /// velocity of the body's origin.
    ///
    /// The law is integrated exactly over the contact polygons. Without dissipation and friction this is
    /// [`Self::wrench`].
    #[must_use]
    pub fn wrench_in_motion(&self, law: &SurfaceLaw<T>, twists: [Twist<T>; 2]) -> ContactWrench<T> {
        if Order::<T>::IS_FIRST {
            let motion = RelativeMotion::of(self, twists);
            let real = self.real();
            let (linearisation, ()) = real.linearisation_in_motion(&law.real(), &motion.real());
            let tangent = self.tangent_in_motion(law, &motion);
            return self.wrench_from_a(&linearisation.pushforward(&tangent));
        }
        self.pipeline().wrench_in_motion(law, twists)
    }
}

impl<T: Scalar> Pipeline<'_, '_, T> {
    /// [`ContactPair::wrench_in_motion`].
    #[must_use]
    pub fn wrench_in_motion(&self, law: &SurfaceLaw<T>, twists: [Twist<T>; 2]) -> ContactWrench<T> {
        let motion = RelativeMotion::of(self.0, twists);
        let surface = self.0.cut_surface();
        let wrench_a = surface.wrench_in_motion(law, &motion);
        self.0.wrench_from_a(&wrench_a)
    }
}

impl ContactPair<'_> {
    /// The contact of moving bodies with all its first derivatives; arguments as of [`Self::wrench_in_motion`].
    #[must_use]
    pub fn linearised(&self, law: &SurfaceLaw, twists: [Twist; 2]) -> LinearisedContact {
        let motion = RelativeMotion::of(self, twists);
        let (relative, ()) = self.real().linearisation_in_motion(law, &motion);
        relative.in_world(self, Some((&motion, &twists[1].angular)))
    }
}

/// The velocity of A relative to B as a field, in A's axes about A's origin.
#[derive(Clone, Copy)]
pub(super) struct RelativeMotion<T> {
    pub angular: Vector3<T>,
    pub at_origin: Vector3<T>,
}

impl<T: Scalar> RelativeMotion<T> {
    pub fn of(pair: &ContactPair<T>, [twist_a, twist_b]: [Twist<T>; 2]) -> Self {
        let (pose_wa, pose_wb) = (pair.a().pose(), pair.b().pose());
        let to_origin_a = pose_wa.translation() - pose_wb.translation();
        let velocity_of_b = twist_b.linear + twist_b.angular.cross(&to_origin_a);
        let in_a = pose_wa.rotation().transpose();
        Self {
            angular: times(&in_a, &(twist_a.angular - twist_b.angular)),
            at_origin: times(&in_a, &(twist_a.linear - velocity_of_b)),
        }
    }

    pub fn at(&self, point: &Vector3<T>) -> Vector3<T> {
        self.at_origin + self.angular.cross(point)
    }

    pub fn real(&self) -> RelativeMotion<f64> {
        RelativeMotion {
            angular: real_vector(&self.angular),
            at_origin: real_vector(&self.at_origin),
        }
    }
}

impl<T: Scalar> SurfaceLaw<T> {
    pub(super) fn real(&self) -> SurfaceLaw<f64> {
        SurfaceLaw {
            dissipation: real_part(self.dissipation),
            friction: real_part(self.friction),
            slip_tolerance: self.slip_tolerance,
        }
    }

    /// Whether nothing is added to the elastic pressure, nor to its derivatives.
    pub(super) fn is_elastic(&self) -> bool {
        real_part(self.dissipation) == 0.0 && real_part(self.friction) == 0.0
    }
}
