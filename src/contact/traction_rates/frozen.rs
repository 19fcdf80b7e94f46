//! What dissipation and friction add on contact polygons that stay as they are, while velocities and pressures change.

use super::area::AreaMoments;
use super::frame::Frame;
use super::traction::Traction;
use crate::contact::SurfaceLaw;
use crate::contact::motion::RelativeMotion;
use crate::contact::plane::PlanePolygon;
use crate::contact::polygon::CutPolygon;
use crate::spatial::Wrench;
use nalgebra::{Matrix6, Vector3, Vector6};

/// What dissipation and friction add to the wrench on A, in A's axes about A's origin.
#[derive(Debug, Clone, Copy)]
pub(crate) struct AddedByLaw {
    pub wrench: Vector6<f64>,
    /// By a motion of B (angular, linear, of the point at A's origin), as far as it changes the pressure.
    pub by_motion: Matrix6<f64>,
    /// By the velocity of A relative to B (angular, linear at A's origin).
    pub by_twist: Matrix6<f64>,
}

/// A contact polygon that stays as it is.
#[derive(Clone)]
pub(in crate::contact) struct FrozenPolygon {
    plane: PlanePolygon<f64>,
    weight: f64,
    /// The changes of the pressure's coefficients by a motion of B.
    pressure_by_motion: [Vector6<f64>; 3],
}

impl AddedByLaw {
    pub fn nothing() -> Self {
        Self {
            wrench: Vector6::zeros(),
            by_motion: Matrix6::zeros(),
            by_twist: Matrix6::zeros(),
        }
    }
}

impl FrozenPolygon {
    /// With the plane of equal pressure, p_A changes by −(∇p_A·n)/|g| of what B's motion (θ, u) takes from p_B at a fixed
    /// point x, ∇p_B·(u + θ × x).
    pub fn of(polygon: &CutPolygon<f64>, motion: &RelativeMotion<f64>) -> Option<Self> {
        let plane = PlanePolygon::of(polygon, motion)?;
        let slope_b = polygon.plane.slopes[1];
        let share = -polygon.pressure_a.gradient.dot(&polygon.plane.normal);
        let by_motion = |arm: &Vector3<f64>, force: Vector3<f64>| {
            let torque = arm.cross(&slope_b) * share;
            Wrench { torque, force }.to_vector()
        };
        let [e1, e2] = [0, 1].map(|axis| plane.axes.column(axis).into_owned());
        Some(Self {
            pressure_by_motion: [
                by_motion(&plane.center, slope_b * share),
                by_motion(&e1, Vector3::zeros()),
                by_motion(&e2, Vector3::zeros()),
            ],
            weight: polygon.weights.still.area(),
            plane,
        })
    }

    /// Adds what the law adds after a motion of B with a velocity of A relative to B.
    pub fn add_to(
        &self,
        sum: &mut AddedByLaw,
        law: &SurfaceLaw,
        (motion, velocity): (&Vector6<f64>, &RelativeMotion<f64>),
    ) {
        let mut plane = self.plane.clone();
        plane.move_with(velocity);
        for (coefficient, by_motion) in plane.pressure.iter_mut().zip(&self.pressure_by_motion) {
            *coefficient += by_motion.dot(motion);
        }
        if let Some(under_pressure) = plane.outline.cut(&plane.pressure) {
            plane.outline = under_pressure;
        }
        let area = Traction::on(&plane, law, AreaMoments::on);
        let frame = Frame::of(&plane);
        let in_a = |wrench: &[f64; 6]| Vector6::from(frame.turned(wrench)) * self.weight;
        sum.wrench += in_a(&area.wrench());
        sum.by_twist += Matrix6::from(frame.turned_matrix(&area.by_twist())) * self.weight;
        let by_coefficients = area.by_pressure().each_ref().map(in_a);
        for (by_coefficient, by_motion) in by_coefficients.iter().zip(&self.pressure_by_motion) {
            sum.by_motion += by_coefficient * by_motion.transpose();
        }
    }
}
