//! Spatial vectors in world axes about a fixed point, angular before linear.

use crate::dynamics::Inertia;
use crate::dynamics::rigid_motion::six;
use crate::scalar::{Scalar, lift, real_part};
use crate::spatial::{Wrench, skew};
use nalgebra::{Matrix3, Vector3, Vector6};
use std::ops::Add;

pub(super) fn angular<T: Scalar>(screw: &Vector6<T>) -> Vector3<T> {
    Vector3::new(screw[0], screw[1], screw[2])
}

pub(super) fn linear<T: Scalar>(screw: &Vector6<T>) -> Vector3<T> {
    Vector3::new(screw[3], screw[4], screw[5])
}

/// Momentum or wrench about the reference point, from the momentum or wrench about a center.
pub(super) fn about_reference<T: Scalar>(
    about_center: &Vector6<T>,
    center: &Vector3<T>,
) -> Vector6<T> {
    let Wrench { torque, force } = Wrench::from_vector(about_center);
    six(&(torque + center.cross(&force)), &force)
}

/// Product v × m of two motions: the rate of a motion m that moves with the velocity v.
pub(super) fn cross_motion<T: Scalar>(velocity: &Vector6<T>, motion: &Vector6<T>) -> Vector6<T> {
    let (w, v) = (angular(velocity), linear(velocity));
    let (a, l) = (angular(motion), linear(motion));
    six(&w.cross(&a), &(w.cross(&l) + v.cross(&a)))
}

/// Product v ×* f of a motion and a wrench, with mᵀ(v ×* f) = −(v × m)ᵀf for all motions m.
pub(super) fn cross_force<T: Scalar>(velocity: &Vector6<T>, wrench: &Vector6<T>) -> Vector6<T> {
    let (w, v) = (angular(velocity), linear(velocity));
    let (torque, force) = (angular(wrench), linear(wrench));
    six(&(w.cross(&torque) + v.cross(&force)), &w.cross(&force))
}

/// Scalar product of a motion and a wrench.
pub(super) fn dot<T: Scalar>(one: &Vector6<T>, other: &Vector6<T>) -> T {
    let products = one.iter().zip(other).map(|(a, b)| *a * *b);
    products.fold(lift(0.0), |sum, product| sum + product)
}

/// Motion with the linear velocity of another point.
pub(super) fn at_point<T: Scalar>(motion: &Vector6<T>, point: &Vector3<T>) -> Vector6<T> {
    let (angular, linear) = (angular(motion), linear(motion));
    six(&angular, &(linear + angular.cross(point)))
}

/// Rotational and translational inertia about a point.
#[derive(Debug, Clone, Copy)]
pub(super) struct SpatialInertia<T = f64> {
    /// Mass (kg).
    mass: T,
    /// Mass times the position of the center of mass (kg m).
    first_moment: Vector3<T>,
    /// Inertia tensor (kg m²).
    tensor: Matrix3<T>,
}

impl<T: Scalar> SpatialInertia<T> {
    /// Inertia of a body with a given orientation and position of the center of mass.
    pub fn of(inertia: &Inertia<T>, rotation: &Matrix3<T>, center: &Vector3<T>) -> Self {
        let arm = skew(center);
        Self {
            mass: inertia.mass,
            first_moment: center * inertia.mass,
            tensor: inertia.in_world(rotation) - arm * arm * inertia.mass,
        }
    }

    /// Momentum at a spatial velocity.
    pub fn times(&self, velocity: &Vector6<T>) -> Vector6<T> {
        let (w, v) = (angular(velocity), linear(velocity));
        six(
            &(self.tensor * w + self.first_moment.cross(&v)),
            &(v * self.mass - self.first_moment.cross(&w)),
        )
    }

    /// Upper bound of the terms of mᵀ·I·m for a motion m. Round-off is relative to this bound.
    pub fn scale(&self, motion: &Vector6<T>) -> f64 {
        let [angular, linear] = [angular(motion), linear(motion)].map(|v| v.map(real_part).norm());
        let tensor = self.tensor.map(real_part).norm();
        let first_moment = self.first_moment.map(real_part).norm();
        tensor * angular * angular
            + 2.0 * first_moment * angular * linear
            + real_part(self.mass) * linear * linear
    }
}

impl<T: Scalar> Add for SpatialInertia<T> {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            mass: self.mass + other.mass,
            first_moment: self.first_moment + other.first_moment,
            tensor: self.tensor + other.tensor,
        }
    }
}
