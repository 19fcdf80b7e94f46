use super::frame::PlaneFrame;
use crate::contact::linearised::RelativeLinearisation;
use crate::contact::plane::PlanePolygon;
use crate::contact::polygon::CutPolygon;
use crate::narrow_phase::EquilibriumPlane;
use nalgebra::{Matrix6, Vector3, Vector6};

/// The derivatives of one polygon's wrench, about its center along its axes.
#[derive(Default)]
pub(super) struct Rates {
    pub wrench: Vector6<f64>,
    /// K₀, K₁ and K₂ as bodies move.
    pub by_speed: [Vector6<f64>; 3],
    /// What to add to `by_speed` as the modulus of B grows: zero unless the polygon or an edge has another weight then (see
    /// [`Weights`](crate::narrow_phase::Weights)).
    pub more_by_growth: [Vector6<f64>; 3],
    pub by_motion: Matrix6<f64>,
    pub by_twist: Matrix6<f64>,
    pub by_dissipation: Vector6<f64>,
    pub by_friction: Vector6<f64>,
    /// Of ∂t/∂p, y₁∂t/∂p and y₂∂t/∂p, all of the polygon counted.
    pub by_pressure: [Vector6<f64>; 3],
}

/// The wrench of a traction from its moments by 1, y₁ and y₂ along each axis.
#[inline]
pub(super) fn wrench_of([t1, t2, t3]: &[[f64; 3]; 3]) -> Vector6<f64> {
    Vector6::new(t3[2], -t3[1], t2[1] - t1[2], t1[0], t2[0], t3[0])
}

/// The wrenches of a traction times 1, y₁ and y₂.
#[inline]
pub(super) fn wrenches(traction: [&[f64; 6]; 3]) -> [Vector6<f64>; 3] {
    let times = |[one, y1, y2]: [usize; 3]| wrench_of(&traction.map(|t| [t[one], t[y1], t[y2]]));
    [times([0, 1, 2]), times([1, 3, 4]), times([2, 4, 5])]
}

impl Rates {
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
        let frame = PlaneFrame::of(plane);
        frame.add_matrix(&self.by_motion, &mut sum.by_motion);
        frame.add_matrix(&self.by_twist, &mut sum.by_twist);
        let by_modulus_b = k0 * p0 + k1 * p1 + k2 * p2;
        let [wrench, by_modulus_b] = frame.of_wrenches([&self.wrench, &by_modulus_b]);
        let by_law = frame.of_wrenches([&self.by_dissipation, &self.by_friction]);
        sum.wrench += wrench;
        let mut of_modulus_b = sum.by_moduli.column_mut(1);
        of_modulus_b += by_modulus_b;
        for (column, rate) in by_law.iter().enumerate() {
            let mut own = sum.by_law.column_mut(column);
            own += rate;
        }
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
