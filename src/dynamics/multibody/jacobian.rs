//! Jacobians and accelerations of points of the links.

use super::inverse_dynamics::Accelerations;
use super::screw::{angular, at_point, linear};
use super::{Kinematics, Multibody};
use crate::dynamics::rigid_motion::six;
use crate::scalar::{Scalar, lift, lift_vector};
use nalgebra::{Matrix6xX, Vector3, Vector6};

impl<T: Scalar> Multibody<T> {
    /// Jacobian of the velocity of a point of a link, angular before linear. The point is in the body frame.
    pub fn jacobian(
        &self,
        kinematics: &Kinematics<T>,
        link: usize,
        point: &Vector3<T>,
    ) -> Matrix6xX<T> {
        let point = kinematics.frames[link].pose.transformed_point(point);
        let mut jacobian = Matrix6xX::from_element(self.width(), lift(0.0));
        for &column in &self.links[link].moving_columns {
            let velocity = at_point(&kinematics.columns[column].axis, &point);
            jacobian.set_column(column, &velocity);
        }
        jacobian
    }
}

impl<T: Scalar> Kinematics<T> {
    /// Angular acceleration of a link, then the acceleration of a point of the link. `accelerations` must not include gravity.
    pub fn point_acceleration(
        &self,
        accelerations: &Accelerations<T>,
        link: usize,
        point: &Vector3<T>,
    ) -> Vector6<T> {
        let frame = &self.frames[link];
        let point = frame.pose.transformed_point(point);
        let velocity = at_point(&frame.velocity, &point);
        at_point(&accelerations.links[link], &point) + convective(&velocity)
    }
}

/// Acceleration of a point of a body without spatial acceleration, from the angular velocity and the velocity of the point.
pub(in crate::dynamics) fn convective<T: Scalar>(velocity: &Vector6<T>) -> Vector6<T> {
    let [angular, linear] = [angular(velocity), linear(velocity)];
    six(&lift_vector(&Vector3::zeros()), &angular.cross(&linear))
}
