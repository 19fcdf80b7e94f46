//! Spatial vectors in world axes about a fixed point, angular before linear.

use crate::dynamics::Inertia;
use crate::dynamics::rigid_motion::six;
use crate::scalar::Scalar;
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
pub(super) fn cross_force(velocity: &Vector6<f64>, wrench: &Vector6<f64>) -> Vector6<f64> {
    let (w, v) = (angular(velocity), linear(velocity));
    let (torque, force) = (angular(wrench), linear(wrench));
    six(&(w.cross(&torque) + v.cross(&force)), &w.cross(&force))
}

/// Rotational and translational inertia about a point.
#[derive(Debug, Clone, Copy)]
pub(super) struct SpatialInertia {
    /// Mass (kg).
    mass: f64,
    /// Mass times the position of the center of mass (kg m).
    first_moment: Vector3<f64>,
    /// Inertia tensor (kg m²).
    tensor: Matrix3<f64>,
}

impl SpatialInertia {
    /// Inertia of a body with a given orientation and position of the center of mass.
    pub fn of(inertia: &Inertia, rotation: &Matrix3<f64>, center: &Vector3<f64>) -> Self {
        let arm = skew(center);
        Self {
            mass: inertia.mass,
            first_moment: center * inertia.mass,
            tensor: inertia.in_world(rotation) - arm * arm * inertia.mass,
        }
    }

    /// Momentum at a spatial velocity.
    pub fn times(&self, velocity: &Vector6<f64>) -> Vector6<f64> {
        let (w, v) = (angular(velocity), linear(velocity));
        six(
            &(self.tensor * w + self.first_moment.cross(&v)),
            &(v * self.mass - self.first_moment.cross(&w)),
        )
    }
}

impl Add for SpatialInertia {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            mass: self.mass + other.mass,
            first_moment: self.first_moment + other.first_moment,
            tensor: self.tensor + other.tensor,
        }
    }
}
