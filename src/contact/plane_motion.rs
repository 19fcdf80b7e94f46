//! The relative motion of two bodies, along the axes of the plane of a contact polygon.

use super::SurfaceLaw;
use super::motion::RelativeMotion;
use super::polygon_fields::PolygonFields;
use crate::friction::Slip;
use crate::lanes::space::{components, cross, splat, sum};
use crate::lanes::{Lanes, Linear, Numbers};
use crate::scalar::Scalar;
use nalgebra::Vector3;

/// The motion of A relative to B along e₁, e₂ and n of a plane.
#[derive(Clone, Copy)]
pub(super) struct PlaneMotion<T> {
    /// The velocity (m/s) at y = 0.
    pub velocity: [T; 3],
    /// The angular velocity (rad/s).
    pub angular: [T; 3],
}

impl<T: Scalar> PlaneMotion<T> {
    pub fn of(motion: &RelativeMotion<T>, plane: &PolygonFields<T>) -> Self {
        let velocity = motion.at(&Vector3::from(plane.origin)).into();
        Self {
            velocity: components(&plane.axes, velocity),
            angular: components(&plane.axes, motion.angular.into()),
        }
    }

    /// Returns the slip of the surfaces in this motion.
    pub fn slip_by(&self, law: &SurfaceLaw<T>) -> Slip<T> {
        let (at_origin, spin) = self.slip();
        Slip {
            at_origin,
            spin,
            tolerance: law.slip_tolerance,
        }
    }
}

impl<N: Numbers> PlaneMotion<N> {
    /// Computes [`Self::of`] for as many planes as there are lanes.
    #[inline(always)]
    pub fn in_lanes<L: Lanes<Numbers = N>>(
        lanes: L,
        motion: &RelativeMotion<f64>,
        axes: &[[N; 3]; 3],
        origin: [N; 3],
    ) -> Self {
        let angular = splat(lanes, motion.angular.as_ref());
        let at_origin = splat(lanes, motion.at_origin.as_ref());
        let velocity = sum(at_origin, cross(angular, origin));
        Self {
            velocity: components(axes, velocity),
            angular: components(axes, angular),
        }
    }
}

/// Methods for both scalars and lanes.
impl<N: Linear> PlaneMotion<N> {
    /// Returns 1 − d v₃, the factor of the pressure by Hunt and Crossley, with v₃ = v·n.
    #[inline(always)]
    pub fn damping(&self, dissipation: N, one: N) -> [N; 3] {
        let [v0, v1, v2] = self.separating();
        [
            one - dissipation * v0,
            -(dissipation * v1),
            -(dissipation * v2),
        ]
    }

    /// Returns the velocity in the plane at y = 0, and the spin about n.
    #[inline(always)]
    pub fn slip(&self) -> ([N; 2], N) {
        ([self.velocity[0], self.velocity[1]], self.angular[2])
    }

    /// Returns v₃, which is positive if the surfaces separate.
    #[inline(always)]
    pub fn separating(&self) -> [N; 3] {
        [self.velocity[2], -self.angular[1], self.angular[0]]
    }
}
