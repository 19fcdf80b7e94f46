//! Rigid-body kinematics and momenta in the coordinates of an implicit step: about the center of mass, angular before linear.

use super::{BodyState, Inertia};
use crate::scalar::portable::atan2;
use crate::scalar::{Scalar, lift};
use crate::spatial::{Pose, Twist, left_jacobian, rotation_from_vector, times_constant, turned_by};
use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3, Vector6};

impl<T: Scalar> Inertia<T> {
    /// Angular momentum (N m s) about the center of mass and momentum (N s) of a body, in world axes.
    pub(in crate::dynamics) fn momentum(&self, state: &BodyState<T>) -> Vector6<T> {
        self.momentum_per_mass(state)
            .map(|component| component * self.mass)
    }

    /// [`Self::momentum`] divided by the mass.
    pub(in crate::dynamics) fn momentum_per_mass(&self, state: &BodyState<T>) -> Vector6<T> {
        let Twist { angular, linear } = &state.twist;
        six(
            &self.angular_momentum_per_mass(state.pose.rotation(), angular),
            linear,
        )
    }

    /// Rotational inertia (kg m²) in world axes.
    pub(in crate::dynamics) fn in_world(&self, rotation: &Matrix3<T>) -> Matrix3<T> {
        let frame = self.principal.frame(rotation);
        let moments = Matrix3::from_diagonal(&self.principal.moments);
        times_constant(&frame, &moments) * frame.transpose() * (self.mass * self.factor)
    }

    /// Pose of a body after a turn (rad, world axes) about its center of mass and a shift of the center of mass (m).
    pub(in crate::dynamics) fn displaced(
        &self,
        pose: &Pose<T>,
        displacement: &Vector6<T>,
    ) -> Pose<T> {
        let Twist { angular, linear } = Twist::from_vector(displacement);
        self.turned_and_moved(pose, &turned_by(pose.rotation(), &angular), &linear)
    }
}

impl Inertia {
    /// Velocities that an impulse (N m s, N s) gives to the body.
    pub(in crate::dynamics) fn velocities(
        &self,
        rotation: &Matrix3<f64>,
        impulse: &Vector6<f64>,
    ) -> Vector6<f64> {
        let Twist { angular, linear } = Twist::from_vector(impulse);
        six(
            &self.angular_velocity(rotation, &angular),
            &(linear / self.mass),
        )
    }

    /// Mean radius of gyration (m) about the origin of the body frame, or 0 for a massless body.
    pub(in crate::dynamics) fn radius_of_gyration_about_origin(&self) -> f64 {
        if self.mass <= 0.0 {
            return 0.0;
        }
        let offset = self.center_of_mass.norm_squared();
        (self.principal.moments.mean().max(0.0) + offset).sqrt()
    }

    /// Speed (m/s) of velocities. The spin is multiplied by the radius of gyration.
    pub(in crate::dynamics) fn speed(&self, velocities: &Vector6<f64>) -> f64 {
        let Twist { angular, linear } = Twist::from_vector(velocities);
        let gyration_squared = self.principal.moments.mean().max(0.0);
        (angular.norm_squared() * gyration_squared + linear.norm_squared()).sqrt()
    }
}

/// Adjoint of [`Inertia::displaced`]. The argument `by_pose` is the gradient with respect to the pose after a displacement. The result is
/// the gradient with respect to the pose before it, and with respect to the displacement. Gradients with respect to poses are in
/// displacements about the center of mass.
pub(in crate::dynamics) fn displaced_back(
    displacement: &Vector6<f64>,
    by_pose: &Vector6<f64>,
) -> [Vector6<f64>; 2] {
    let angular = Twist::from_vector(displacement).angular;
    let Twist {
        angular: by_turn,
        linear,
    } = Twist::from_vector(by_pose);
    // exp[v + δv]·(1 + [θ])·R turns by J_l(v)·δv + exp[v]·θ.
    [rotation_from_vector(&angular), left_jacobian(&angular)]
        .map(|turned| six(&turned.tr_mul(&by_turn), &linear))
}

/// Displacement of a body from one pose to another.
pub(in crate::dynamics) fn displacement(inertia: &Inertia, from: &Pose, to: &Pose) -> Vector6<f64> {
    let [before, after] = [from, to].map(|pose| pose.transformed_point(&inertia.center_of_mass));
    six(
        &turn_between(from.rotation(), to.rotation()),
        &(after - before),
    )
}

/// 6-vector of an angular and a linear part.
pub(in crate::dynamics) fn six<T: Scalar>(angular: &Vector3<T>, linear: &Vector3<T>) -> Vector6<T> {
    let (a, l) = (angular, linear);
    Vector6::new(a.x, a.y, a.z, l.x, l.y, l.z)
}

/// Zero 6-vector.
pub(in crate::dynamics) fn zero6<T: Scalar>() -> Vector6<T> {
    Vector6::from_element(lift(0.0))
}

/// Rotation vector (rad, at most half a turn) from one rotation to another.
pub(crate) fn turn_between(from: &Matrix3<f64>, to: &Matrix3<f64>) -> Vector3<f64> {
    let turn = Rotation3::from_matrix_unchecked(to * from.transpose());
    let quaternion = UnitQuaternion::from_rotation_matrix(&turn);
    quaternion.axis().map_or_else(Vector3::zeros, |axis| {
        let half_angle = atan2(quaternion.imag().norm(), quaternion.w.abs());
        axis.into_inner() * (2.0 * half_angle)
    })
}
