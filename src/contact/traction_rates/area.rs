use super::{Rates, Traction, VectorMoments, wrench_of, wrenches};
use crate::contact::friction::product;
use crate::contact::plane::{affine_moments, quadratic_moments};
use crate::contact::polygon::CutPolygon;
use nalgebra::{Matrix6, Vector6};

impl Rates {
    /// Adds the integrals over the area: velocities, law, and K without the edges.
    pub fn add_area(&mut self, traction: &Traction, polygon: &CutPolygon<f64>) {
        let area = AreaMoments::of(traction);
        let [first, second, third] = area.by_velocity.each_ref().map(wrenches);
        let columns = |k: usize| [first[k], second[k], third[k]];
        let [by_velocity, by_y1, by_y2] = [0, 1, 2].map(columns);
        self.by_twist = Matrix6::from_columns(&[
            by_y2[2],
            -by_y1[2],
            by_y1[1] - by_y2[0],
            by_velocity[0],
            by_velocity[1],
            by_velocity[2],
        ]);
        self.wrench = wrench_of(area.traction);
        self.by_dissipation = wrench_of(area.by_dissipation);
        self.by_friction = wrench_of(area.by_friction);
        let t = area.traction;
        let q = wrenches(&area.by_pressure);
        let along_normal = polygon.pressure_a.gradient.dot(&polygon.plane.normal);
        let [v1, v2, v3] = traction.plane.velocity;
        let [w1, w2, w3] = traction.plane.angular;
        for (k, by) in [by_velocity, by_y1, by_y2].iter().enumerate() {
            let lifted = Vector6::new(-t[1][k], t[0][k], 0.0, 0.0, 0.0, 0.0);
            self.by_speed[k] += q[k] * along_normal + by[0] * w2 - by[1] * w1 + lifted;
        }
        // The wrench of v_i times column j of T.
        let times_v1 = |j: usize| by_velocity[j] * v1 - by_y2[j] * w3;
        let times_v2 = |j: usize| by_velocity[j] * v2 + by_y1[j] * w3;
        let times_v3 = |j: usize| by_velocity[j] * v3 - by_y1[j] * w2 + by_y2[j] * w1;
        let (none, less) = ([0.0; 3], t[2].map(|moment| -moment));
        self.by_speed[1] += wrench_of([less, none, t[0]]) + times_v3(0) - times_v1(2);
        self.by_speed[2] += wrench_of([none, less, t[1]]) + times_v3(1) - times_v2(2);
    }
}

/// Moments over the area of a polygon.
struct AreaMoments {
    /// Of t along each axis, by 1, y₁ and y₂.
    traction: [[f64; 3]; 3],
    /// Of ∂t/∂p.
    by_pressure: VectorMoments,
    /// Of the columns of T.
    by_velocity: [VectorMoments; 3],
    /// Of ∂t/∂d and ∂t/∂μ along each axis, by 1, y₁ and y₂.
    by_dissipation: [[f64; 3]; 3],
    by_friction: [[f64; 3]; 3],
}

impl AreaMoments {
    /// With ψ, u and σ as in [`Traction`] and [`SlipMoments`], on the part where ψ > 0
    ///
    /// t = p(−μψu₁, −μψu₂, ψ − 1),  ∂t/∂(v₁, v₂) = μpψ(u uᵀ − 1)/σ,  ∂t/∂v₃ = −dp(−μu₁, −μu₂, 1),
    ///
    /// and ∂t/∂d the same as ∂t/∂v₃ with v₃ in place of d. Beyond, t = −p n.
    #[inline]
    fn of(traction: &Traction) -> Self {
        let (plane, slip) = (traction.plane, traction.slip);
        let (mu, d) = (traction.friction, traction.dissipation);
        let moments = traction.pressed.moments();
        let [u1, u2] = &slip.direction;
        // Of (−μu₁, −μu₂, 1).
        let pushed = [u1.map(|u| -mu * u), u2.map(|u| -mu * u), moments];
        let by_pressure = traction.by_pressure(&pushed);
        let [t11, t12, t22] = slip
            .by_slip
            .map(|moments| moments.map(|moment| mu * moment));
        let damped = plane.pressure.map(|p| -d * p);
        let parting = product(&plane.pressure, &plane.separating()).map(|c| -c);
        let load = product(&plane.pressure, &traction.damping).map(|c| -c);
        Self {
            traction: by_pressure
                .each_ref()
                .map(|q| affine_moments(&plane.pressure, q)),
            by_pressure,
            by_velocity: [
                [t11, t12, [0.0; 6]],
                [t12, t22, [0.0; 6]],
                pushed.each_ref().map(|of| affine_moments(&damped, of)),
            ],
            by_dissipation: pushed.each_ref().map(|of| quadratic_moments(&parting, of)),
            by_friction: [
                quadratic_moments(&load, u1),
                quadratic_moments(&load, u2),
                [0.0; 3],
            ],
        }
    }
}

impl Traction<'_> {
    /// Moments of ∂t/∂p, from those of (−μu₁, −μu₂, 1).
    #[inline]
    fn by_pressure(&self, pushed: &[[f64; 10]; 3]) -> VectorMoments {
        let [q1, q2, q3] = pushed
            .each_ref()
            .map(|of| affine_moments(&self.damping, of));
        let normal = if self.is_clamped {
            let whole = self.plane.outline.moments();
            std::array::from_fn(|m| q3[m] - whole[m])
        } else {
            affine_moments(&self.excess, &pushed[2])
        };
        [q1, q2, normal]
    }
}
