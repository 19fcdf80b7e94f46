use super::polygon::PairPolygon;
use super::{BodyError, ContactPair, ContactWrench};
use crate::scalar::{DenseDual, Scalar, lift, lift_vector, real_part, real_vector};
use crate::spatial::{Twist, Wrench, skew};
use nalgebra::{SMatrix, Vector3};

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
        let motion = RelativeMotion::of(self, twists);
        let wrench_a = self.sum_polygons(|sum: &mut Wrench<T>, polygon| {
            *sum += polygon.wrench_in_motion(law, &motion);
        });
        self.wrench_from_a(&wrench_a)
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
            angular: in_a * (twist_a.angular - twist_b.angular),
            at_origin: in_a * (twist_a.linear - velocity_of_b),
        }
    }

    fn at(&self, point: &Vector3<T>) -> Vector3<T> {
        self.at_origin + self.angular.cross(point)
    }

    pub fn real(&self) -> RelativeMotion<f64> {
        RelativeMotion {
            angular: real_vector(&self.angular),
            at_origin: real_vector(&self.at_origin),
        }
    }
}

impl RelativeMotion<f64> {
    pub fn lifted<T: Scalar>(&self) -> RelativeMotion<T> {
        RelativeMotion {
            angular: lift_vector(&self.angular),
            at_origin: lift_vector(&self.at_origin),
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

    /// Force per area on A (Pa) at a point of the surface with a normal and an elastic pressure,
    /// which A passes with a velocity relative to B.
    fn traction(&self, normal: &Vector3<T>, pressure: T, velocity: &Vector3<T>) -> Vector3<T> {
        let separating = velocity.dot(normal);
        let damping = -self.dissipation * separating + lift::<T>(1.0);
        // Surfaces that part faster than the skin recovers do not pull. Beyond the kink the pressure
        // is zero, and so are its derivatives.
        if real_part(damping) <= 0.0 {
            return lift_vector(&Vector3::zeros());
        }
        let pressure = pressure * damping;
        let slip = velocity - normal * separating;
        let speed = (slip.dot(&slip) + lift::<T>(self.slip_tolerance.powi(2))).sqrt();
        normal * pressure - slip * (self.friction * pressure / speed)
    }
}

impl SurfaceLaw<f64> {
    pub(super) fn lifted<T: Scalar>(&self) -> SurfaceLaw<T> {
        SurfaceLaw {
            dissipation: lift(self.dissipation),
            friction: lift(self.friction),
            slip_tolerance: self.slip_tolerance,
        }
    }

    /// The derivatives of the traction by velocity (columns 0..3), dissipation and friction.
    fn traction_slopes(
        &self,
        normal: &Vector3<f64>,
        pressure: f64,
        velocity: &Vector3<f64>,
    ) -> SMatrix<f64, 3, 5> {
        let law = SurfaceLaw {
            dissipation: DenseDual::<5>::variable(self.dissipation, 3),
            friction: DenseDual::variable(self.friction, 4),
            slip_tolerance: self.slip_tolerance,
        };
        let velocity = Vector3::from_fn(|i, _| DenseDual::variable(velocity[i], i));
        let traction = law.traction(&lift_vector(normal), lift(pressure), &velocity);
        SMatrix::from_fn(|row, column| traction[row].eps[column])
    }
}

/// A polygon is a sliver if its area is less than this fraction of its length squared: its centroid is round-off.
const SLIVER: f64 = 1e-9;

impl<T: Scalar> PairPolygon<T> {
    /// Wrench on A about A's origin in A's axes, by the rule of the edge midpoints on each triangle
    /// around the centroid: exact where pressure alone acts, second order where the slip varies.
    pub(super) fn wrench_in_motion(
        &self,
        law: &SurfaceLaw<T>,
        motion: &RelativeMotion<T>,
    ) -> Wrench<T> {
        let mut wrench = Wrench::zero();
        self.visit_midpoints(|point, weight| {
            let (normal, pressure) = (&self.plane.normal, self.pressure.at(point));
            let force = law.traction(normal, pressure, &motion.at(point)) * weight;
            wrench.torque += point.cross(&force);
            wrench.force += force;
        });
        wrench
    }

    /// Adds the derivatives of [`Self::wrench_in_motion`] by the relative motion (angular, at A's
    /// origin), dissipation and friction, on the polygon as it is.
    pub(super) fn add_slopes(
        &self,
        law: &SurfaceLaw,
        motion: &RelativeMotion<f64>,
        sum: &mut SMatrix<f64, 6, 8>,
    ) {
        let normal = real_vector(&self.plane.normal);
        self.visit_midpoints(|point, weight| {
            let pressure = real_part(self.pressure.at(point));
            let point = real_vector(point);
            let by_traction = law.traction_slopes(&normal, pressure, &motion.at(&point));
            let slopes = by_traction * real_part(weight);
            let arm = skew(&point);
            // v = v₀ + ω × x, and ω × x = −[x]ₓ ω.
            let by_velocity = slopes.fixed_columns::<3>(0).into_owned();
            let mut force = SMatrix::<f64, 3, 8>::zeros();
            force
                .fixed_columns_mut::<3>(0)
                .copy_from(&(by_velocity * -arm));
            force.fixed_columns_mut::<5>(3).copy_from(&slopes);
            let (torque, total) = (arm * force, force);
            let mut torques = sum.fixed_rows_mut::<3>(0);
            torques += torque;
            let mut forces = sum.fixed_rows_mut::<3>(3);
            forces += total;
        });
    }

    /// Visits the edge midpoints of the triangles between the centroid and the edges, each with its weight: a
    /// third of the area of the triangles it belongs to, as far as that counts. Where the outline begins does not
    /// matter, but for slivers.
    fn visit_midpoints(&self, mut visit: impl FnMut(&Vector3<T>, T)) {
        let corners = self.polygon.corners();
        let (&[first, ..], &[.., one_but_last, last]) = (corners, corners) else {
            return;
        };
        let square = |corner: &Vector3<T>| real_vector(&(corner - first)).norm_squared();
        let length_squared = corners.iter().map(square).fold(0.0, f64::max);
        let center = if real_part(self.moments.area) > self.weight * SLIVER * length_squared {
            self.moments.centroid()
        } else {
            first
        };
        let (half, sixth) = (lift::<T>(0.5), self.weight / 6.0);
        let third_of_triangle = |from: &Vector3<T>, to: &Vector3<T>| {
            let double_area = (from - center).cross(&(to - center));
            self.plane.normal.dot(&double_area) * sixth
        };
        let (mut before, mut third_before) = (last, third_of_triangle(&one_but_last, &last));
        for corner in corners {
            let third = third_of_triangle(&before, corner);
            visit(&((before + corner) * half), third);
            visit(&((before + center) * half), third_before + third);
            (before, third_before) = (*corner, third);
        }
    }
}
