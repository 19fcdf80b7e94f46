use super::{Rates, Traction, VectorMoments, wrench_of, wrenches};
use crate::contact::plane::affine_moments;
use crate::contact::polygon::CutPolygon;
use crate::narrow_phase::Weights;
use nalgebra::{Matrix6, Vector6};

/// The moments of a component that is zero.
const ZERO: [f64; 6] = [0.0; 6];

impl Rates {
    /// Sets the integrals over the area: velocities, law, and K without the edges.
    pub fn set_area(&mut self, traction: &Traction, polygon: &CutPolygon<f64>) {
        let area = AreaMoments::of(traction);
        let by_velocities = area.by_velocities();
        self.by_twist = by_twist(&by_velocities);
        let [by_velocity, by_y1, by_y2] = by_velocities;
        let t = &area.traction;
        self.wrench = wrench_of(t);
        self.by_dissipation = wrench_of(&area.by_dissipation);
        self.by_friction = wrench_of(&area.by_friction);
        let [q1, q2, q3] = &area.by_pressure;
        let by_pressure = wrenches([q1, q2, q3]);
        let along_normal = polygon.pressure_a.gradient.dot(&polygon.plane.normal);
        let [v1, v2, v3] = traction.plane.motion.velocity;
        let [w1, w2, w3] = traction.plane.motion.angular;
        let by_speed = |k: usize, [first, second, _]: &[Vector6<f64>; 3]| {
            let lifted = Vector6::new(-t[1][k], t[0][k], 0.0, 0.0, 0.0, 0.0);
            by_pressure[k] * along_normal + first * w2 - second * w1 + lifted
        };
        // The wrench of v_i times column j of T.
        let times_v1 = |j: usize| by_velocity[j] * v1 - by_y2[j] * w3;
        let times_v2 = |j: usize| by_velocity[j] * v2 + by_y1[j] * w3;
        let times_v3 = |j: usize| by_velocity[j] * v3 - by_y1[j] * w2 + by_y2[j] * w1;
        let (none, less) = ([0.0; 3], [-t[2][0], -t[2][1], -t[2][2]]);
        let turned1 = wrench_of(&[less, none, t[0]]) + times_v3(0) - times_v1(2);
        let turned2 = wrench_of(&[none, less, t[1]]) + times_v3(1) - times_v2(2);
        self.by_speed = [
            by_speed(0, &by_velocity),
            by_speed(1, &by_y1) + turned1,
            by_speed(2, &by_y2) + turned2,
        ];
        self.by_pressure = by_pressure;
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
}

/// Moments over the area of a polygon.
pub(super) struct AreaMoments {
    /// Of t along each axis, by 1, y₁ and y₂.
    pub traction: [[f64; 3]; 3],
    /// Of ∂t/∂p.
    pub by_pressure: VectorMoments,
    /// Of the entries 11, 12 and 22 of T, whose other entries in the first two columns are zero.
    by_slip: [[f64; 6]; 3],
    /// Of ∂t/∂v₃, the third column of T.
    by_parting: VectorMoments,
    /// Of ∂t/∂d and ∂t/∂μ along each axis, by 1, y₁ and y₂.
    by_dissipation: [[f64; 3]; 3],
    by_friction: [[f64; 3]; 3],
}

impl AreaMoments {
    /// With ψ, u and σ as in [`Traction`] and [`LoadedSlip`], on the part where ψ > 0
    ///
    /// t = p(−μψu₁, −μψu₂, ψ − 1),  ∂t/∂(v₁, v₂) = μpψ(u uᵀ − 1)/σ,  ∂t/∂v₃ = −dp(−μu₁, −μu₂, 1),
    ///
    /// and ∂t/∂d the same as ∂t/∂v₃ with v₃ in place of d. Beyond, t = −p n.
    ///
    /// [`LoadedSlip`]: crate::contact::friction::LoadedSlip
    pub fn of(traction: &Traction) -> Self {
        let (plane, pressure, damping) =
            (traction.plane, &traction.plane.pressure, &traction.damping);
        let (mu, d) = (traction.friction, traction.dissipation);
        let slip = traction.slip.moments();
        let [u1, u2] = &slip.direction;
        let one = traction.pressed.moments();
        // ∫ p m u and ∫ p m dA.
        let p1: [f64; 6] = affine_moments(pressure, u1);
        let p2: [f64; 6] = affine_moments(pressure, u2);
        let p3: [f64; 6] = affine_moments(pressure, &one);
        // ∫ pψ m u dA.
        let loaded: [[f64; 3]; 2] = [affine_moments(damping, &p1), affine_moments(damping, &p2)];
        let (normal, normal_by_pressure) = if traction.is_clamped {
            let whole = plane.outline.moments();
            let all: [f64; 6] = affine_moments(pressure, &whole);
            (
                less(affine_moments(damping, &p3), &all),
                less(affine_moments(damping, &one), &whole),
            )
        } else {
            let excess = &traction.excess;
            (affine_moments(excess, &p3), affine_moments(excess, &one))
        };
        let parting = plane.motion.separating();
        Self {
            traction: [scaled(&loaded[0], -mu), scaled(&loaded[1], -mu), normal],
            by_pressure: [
                scaled(&affine_moments(damping, u1), -mu),
                scaled(&affine_moments(damping, u2), -mu),
                normal_by_pressure,
            ],
            by_slip: [0, 1, 2].map(|entry| scaled(&slip.by_slip[entry], mu)),
            by_parting: [scaled(&p1, d * mu), scaled(&p2, d * mu), scaled(&p3, -d)],
            by_dissipation: [
                scaled(&affine_moments(&parting, &p1), mu),
                scaled(&affine_moments(&parting, &p2), mu),
                scaled(&affine_moments(&parting, &p3), -1.0),
            ],
            by_friction: [scaled(&loaded[0], -1.0), scaled(&loaded[1], -1.0), [0.0; 3]],
        }
    }
}

impl AreaMoments {
    /// The wrenches of the columns of T, times 1, y₁ and y₂.
    fn by_velocities(&self) -> [[Vector6<f64>; 3]; 3] {
        let [t11, t12, t22] = &self.by_slip;
        let first = wrenches([t11, t12, &ZERO]);
        let second = wrenches([t12, t22, &ZERO]);
        let [p1, p2, p3] = &self.by_parting;
        let third = wrenches([p1, p2, p3]);
        [0, 1, 2].map(|times| [first[times], second[times], third[times]])
    }

    /// The derivative of the wrench by the velocity (angular, linear at the center).
    pub fn by_twist(&self) -> Matrix6<f64> {
        by_twist(&self.by_velocities())
    }
}

fn by_twist([by_velocity, by_y1, by_y2]: &[[Vector6<f64>; 3]; 3]) -> Matrix6<f64> {
    Matrix6::from_columns(&[
        by_y2[2],
        -by_y1[2],
        by_y1[1] - by_y2[0],
        by_velocity[0],
        by_velocity[1],
        by_velocity[2],
    ])
}

#[inline]
fn scaled<const N: usize>(moments: &[f64; N], factor: f64) -> [f64; N] {
    let mut scaled = *moments;
    for moment in &mut scaled {
        *moment *= factor;
    }
    scaled
}

#[inline]
fn less<const N: usize>(mut moments: [f64; N], others: &[f64]) -> [f64; N] {
    for (moment, other) in moments.iter_mut().zip(others) {
        *moment -= other;
    }
    moments
}
