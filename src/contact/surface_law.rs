use super::narrow_phase::PairPolygon;
use super::{BodyError, ContactPair, ContactWrench};
use crate::scalar::{Scalar, lift, lift_vector, real_part};
use crate::spatial::{Twist, Wrench};
use nalgebra::Vector3;

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
    /// If dissipation or friction is negative, the slip tolerance is not positive, or one of them is
    /// not finite.
    pub fn new(dissipation: T, friction: T, slip_tolerance: f64) -> Result<Self, BodyError> {
        let numbers = [
            ("dissipation", real_part(dissipation), 0.0),
            ("friction", real_part(friction), 0.0),
            ("slip tolerance", slip_tolerance, f64::MIN_POSITIVE),
        ];
        for (quantity, value, least) in numbers {
            if !(value >= least && value.is_finite()) {
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

impl<T: Scalar> ContactPair<'_, T> {
    /// The contact wrenches of moving bodies. Each twist is in world axes, its linear part the
    /// velocity of the body's origin.
    ///
    /// Without dissipation and friction this is [`Self::wrench`].
    #[must_use]
    pub fn wrench_in_motion(&self, law: &SurfaceLaw<T>, twists: [Twist<T>; 2]) -> ContactWrench<T> {
        let pose_wa = self.a().pose();
        let motion = RelativeMotion::of(self, twists);
        let wrench_a = self.sum_polygons(|sum: &mut Wrench<T>, polygon| {
            *sum += polygon.wrench_in_motion(law, &motion);
        });
        ContactWrench::from_wrench_a(wrench_a, pose_wa, &self.pose_ab())
    }
}

/// The velocity of A relative to B as a field, in A's axes about A's origin.
struct RelativeMotion<T> {
    angular: Vector3<T>,
    at_origin: Vector3<T>,
}

impl<T: Scalar> RelativeMotion<T> {
    fn of(pair: &ContactPair<T>, [twist_a, twist_b]: [Twist<T>; 2]) -> Self {
        let (pose_wa, pose_wb) = (pair.a().pose(), pair.b().pose());
        let to_origin_a = pose_wa.translation() - pose_wb.translation();
        let velocity_of_b = twist_b.linear + twist_b.angular.cross(&to_origin_a);
        let in_a = pose_wa.rotation().transpose();
        Self {
            angular: in_a * (twist_a.angular - twist_b.angular),
            at_origin: in_a * (twist_a.linear - velocity_of_b),
        }
    }

    fn at(&self, point: &Vector3<T>) -> Vector3<T> {
        self.at_origin + self.angular.cross(point)
    }
}

impl<T: Scalar> PairPolygon<T> {
    /// Wrench on A about A's origin in A's axes, by the rule of the edge midpoints on each triangle
    /// of the fan: exact where pressure alone acts, second order where the slip varies.
    fn wrench_in_motion(&self, law: &SurfaceLaw<T>, motion: &RelativeMotion<T>) -> Wrench<T> {
        let corners = self.polygon.corners();
        let mut wrench = Wrench::zero();
        for pair in corners[1..].windows(2) {
            let [a, b, c] = [corners[0], pair[0], pair[1]];
            let double_area = self.plane.normal.dot(&(b - a).cross(&(c - a)));
            let weight = double_area / 6.0;
            for midpoint in [a + b, b + c, c + a] {
                let point = midpoint * lift::<T>(0.5);
                let force = self.traction(law, &motion.at(&point), &point) * weight;
                wrench.torque += point.cross(&force);
                wrench.force += force;
            }
        }
        wrench
    }

    /// Force per area on A (Pa) at a point that A passes with the velocity relative to B.
    fn traction(
        &self,
        law: &SurfaceLaw<T>,
        velocity: &Vector3<T>,
        point: &Vector3<T>,
    ) -> Vector3<T> {
        let normal = &self.plane.normal;
        let separating = velocity.dot(normal);
        let damping = -law.dissipation * separating + lift::<T>(1.0);
        // Surfaces that part faster than the skin recovers do not pull. Beyond the kink the pressure
        // is zero, and so are its derivatives.
        if real_part(damping) <= 0.0 {
            return lift_vector(&Vector3::zeros());
        }
        let pressure = self.pressure.at(point) * damping;
        let slip = velocity - normal * separating;
        let speed = (slip.dot(&slip) + lift::<T>(law.slip_tolerance.powi(2))).sqrt();
        normal * pressure - slip * (law.friction * pressure / speed)
    }
}
