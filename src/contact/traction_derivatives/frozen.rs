//! What dissipation and friction add on contact polygons that stay as they are, while velocities and pressures change.

use super::area::AreaMoments;
use super::in_lanes::FrozenInLanes;
use super::traction::Traction;
use crate::contact::SurfaceLaw;
use crate::contact::motion::RelativeMotion;
use crate::contact::outline::Outline;
use crate::contact::plane_polygon::PlanePolygon;
use crate::contact::polygon_fields::PolygonFields;
use crate::lanes;
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
    polygon: PlanePolygon<f64>,
    /// The changes of the pressure's coefficients by a motion of B.
    pub(super) pressure_by_motion: [Vector6<f64>; 3],
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
    pub fn of(polygon: PlanePolygon<f64>) -> Self {
        let plane = &polygon.plane;
        let [_, slope_b] = plane.slopes.map(Vector3::from);
        let share = -plane.slope_along_normal();
        let by_motion = |arm: [f64; 3], force: Vector3<f64>| {
            let torque = Vector3::from(arm).cross(&slope_b) * share;
            Wrench { torque, force }.to_vector()
        };
        let [e1, e2, _] = plane.axes;
        Self {
            pressure_by_motion: [
                by_motion(plane.origin, slope_b * share),
                by_motion(e1, Vector3::zeros()),
                by_motion(e2, Vector3::zeros()),
            ],
            polygon,
        }
    }

    /// Computes what dissipation and friction add over frozen polygons after a motion of B with a velocity of A relative to B.
    pub fn added(
        polygons: &[Self],
        law: &SurfaceLaw,
        (motion, velocity): (&Vector6<f64>, &RelativeMotion<f64>),
    ) -> AddedByLaw {
        let (mut sum, left) = lanes::run(FrozenInLanes {
            polygons,
            law,
            motion,
            velocity,
        });
        for polygon in left {
            polygons[polygon].add_to(&mut sum, law, (motion, velocity));
        }
        sum
    }

    pub(super) fn plane(&self) -> &PolygonFields<f64> {
        &self.polygon.plane
    }

    pub(super) fn outline(&self) -> &Outline<f64> {
        &self.polygon.outline
    }

    pub(super) fn weight(&self) -> f64 {
        self.polygon.weights.still.area()
    }

    /// The coefficients of the pressure after a motion of B.
    pub(super) fn pressure_after(&self, motion: &Vector6<f64>) -> [f64; 3] {
        let mut pressure = self.polygon.plane.pressure;
        for (coefficient, by_motion) in pressure.iter_mut().zip(&self.pressure_by_motion) {
            *coefficient += by_motion.dot(motion);
        }
        pressure
    }

    /// Adds the contribution of this polygon, computed without lanes.
    pub fn add_to(
        &self,
        sum: &mut AddedByLaw,
        law: &SurfaceLaw,
        (motion, velocity): (&Vector6<f64>, &RelativeMotion<f64>),
    ) {
        let mut polygon = self.polygon.clone();
        polygon.plane.pressure = self.pressure_after(motion);
        if let Some(under_pressure) = polygon.outline.cut(&polygon.plane.pressure) {
            polygon.set_outline(under_pressure);
        }
        let area = Traction::on(&polygon, (law, velocity), AreaMoments::on);
        let (plane, weight) = (&polygon.plane, self.weight());
        let in_a = |wrench: &[f64; 6]| Vector6::from(plane.in_a(wrench)) * weight;
        sum.wrench += in_a(&area.wrench());
        sum.by_twist += Matrix6::from(plane.matrix_in_a(&area.by_twist())) * weight;
        let by_coefficients = area.by_pressure().each_ref().map(in_a);
        for (by_coefficient, by_motion) in by_coefficients.iter().zip(&self.pressure_by_motion) {
            sum.by_motion += by_coefficient * by_motion.transpose();
        }
    }
}
