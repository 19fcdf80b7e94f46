use super::Traction;
use super::area::{AreaMoments, Rates};
use super::frame::Frame;
use crate::contact::linearised::RelativeLinearisation;
use crate::contact::plane::PlanePolygon;
use crate::contact::polygon::CutPolygon;
use crate::narrow_phase::{EquilibriumPlane, Weights};
use nalgebra::{Matrix6, Matrix6x2, Vector3, Vector6};

/// The derivatives of one polygon's wrench, about its center along its axes, with what its edges and weights make of them.
#[derive(Default)]
pub(super) struct PolygonRates {
    pub wrench: Vector6<f64>,
    /// K₀, K₁ and K₂ as bodies move.
    pub by_speed: [Vector6<f64>; 3],
    /// What to add to `by_speed` as the modulus of B grows: zero unless the polygon or an edge has another weight then (see
    /// [`Weights`]).
    pub more_by_growth: [Vector6<f64>; 3],
    pub by_motion: Matrix6<f64>,
    pub by_twist: Matrix6<f64>,
    pub by_dissipation: Vector6<f64>,
    pub by_friction: Vector6<f64>,
    /// Of ∂t/∂p, y₁∂t/∂p and y₂∂t/∂p, all of the polygon counted.
    pub by_pressure: [Vector6<f64>; 3],
}

impl PolygonRates {
    /// Sets the integrals over the area: velocities, law, and K without the edges.
    pub fn set_area(&mut self, traction: &Traction, polygon: &CutPolygon<f64>) {
        let along_normal = polygon.pressure_a.gradient.dot(&polygon.plane.normal);
        let area = Rates::of_area(&AreaMoments::on(traction), &traction.law, along_normal);
        self.wrench = area.wrench.into();
        self.by_speed = area.by_speed.map(Vector6::from);
        self.by_twist = area.by_twist.into();
        self.by_dissipation = area.by_dissipation.into();
        self.by_friction = area.by_friction.into();
        self.by_pressure = area.by_pressure.map(Vector6::from);
        if !polygon.weights.are_whole() {
            self.scale(polygon.weights);
        }
    }

    /// As far as the polygon counts.
    fn scale(&mut self, Weights { still, moving }: Weights) {
        let more = still.area() - moving.area();
        self.more_by_growth = self.by_speed.map(|k| k * more);
        self.by_speed = self.by_speed.map(|k| k * moving.area());
        self.wrench *= still.area();
        self.by_twist *= still.area();
        self.by_dissipation *= still.area();
        self.by_friction *= still.area();
    }

    /// Adds the rates to those in A's axes about A's origin.
    pub fn add_to(
        mut self,
        plane: &PlanePolygon<f64>,
        polygon: &CutPolygon<f64>,
        sum: &mut RelativeLinearisation<f64>,
    ) {
        // h = −s_B·ξ/|g| for a motion ξ of B, and p/|g| for δE_B/E_B.
        let EquilibriumPlane {
            slopes, yielding, ..
        } = &polygon.plane;
        let slope_b = -plane.axes.tr_mul(&slopes[1]);
        add_along_normal(&slope_b, &self.by_speed, &mut self.by_motion);
        let [p0, p1, p2] = plane.pressure.map(|p| p * yielding);
        let [k0, k1, k2] = [0, 1, 2].map(|k| self.by_speed[k] + self.more_by_growth[k]);
        let frame = Frame::of(plane);
        let by_modulus_b = k0 * p0 + k1 * p1 + k2 * p2;
        sum.by_motion += frame.of_matrix(&self.by_motion);
        sum.by_twist += frame.of_matrix(&self.by_twist);
        sum.wrench += frame.of_wrench(&self.wrench);
        let none = Vector6::zeros();
        let in_a = |wrench: &Vector6<f64>| frame.of_wrench(wrench);
        sum.by_moduli += Matrix6x2::from_columns(&[none, in_a(&by_modulus_b)]);
        let by_law = [&self.by_dissipation, &self.by_friction].map(in_a);
        sum.by_law += Matrix6x2::from_columns(&by_law);
    }
}

/// Adds what the motion (θ, u) about the center contributes by moving points y with the speed m·(u + θ × y), from what
/// speeds of 1, y₁ and y₂ contribute.
#[inline]
pub(super) fn add_along_normal(
    m: &Vector3<f64>,
    [f0, f1, f2]: &[Vector6<f64>; 3],
    sum: &mut Matrix6<f64>,
) {
    // m·(θ × y) = θ·(y × m), y × m = (y₂m₃, −y₁m₃, y₁m₂ − y₂m₁).
    let mut add = |column: usize, value: Vector6<f64>| {
        let mut own = sum.column_mut(column);
        own += value;
    };
    add(0, f2 * m.z);
    add(1, f1 * -m.z);
    add(2, f1 * m.y - f2 * m.x);
    add(3, f0 * m.x);
    add(4, f0 * m.y);
    add(5, f0 * m.z);
}
