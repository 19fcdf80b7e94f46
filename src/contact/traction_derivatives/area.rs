//! Contribution of dissipation and friction over the area of polygons, one in each lane.

use super::wrenches::{minus, negated, plus, times, wrench_of, wrenches};
use crate::contact::SurfaceLaw;
use crate::contact::motion::RelativeMotion;
use crate::contact::plane_motion::PlaneMotion;
use crate::contact::polygon_fields::{Columns, PolygonFields, Six};
use crate::friction::{SlipAndLoad, SlipMoments};
use crate::lanes::space::scaled;
use crate::lanes::{Lanes, Linear, Numbers};

/// The surface law on the plane of a polygon. Pressure, damping ψ and `excess` are affine functions c₀ + c₁y₁ + c₂y₂.
pub(super) struct LawOnPlane<N> {
    pub zero: N,
    /// 1 if ψ is positive, and 0 if ψ is clamped to zero. If it is 0, `damping`, `friction` and `dissipation` are zero, and `excess` is −1.
    pub pressed_factor: N,
    pub friction: N,
    pub dissipation: N,
    /// Slip, pressure, and the damping: ψ = 1 − d v₃, or 0 if ψ is clamped. `pressure` is p, not pψ.
    pub load: SlipAndLoad<N>,
    /// ψ − 1.
    pub excess: [N; 3],
    pub motion: PlaneMotion<N>,
}

impl<N: Numbers> LawOnPlane<N> {
    /// Evaluates the law on the planes of polygons, one in each lane.
    #[inline(always)]
    pub fn on<L: Lanes<Numbers = N>>(
        lanes: L,
        planes: &PolygonFields<N>,
        pressed_factor: N,
        (law, motion): (&SurfaceLaw, &RelativeMotion<f64>),
    ) -> Self {
        let motion = PlaneMotion::in_lanes(lanes, motion, &planes.axes, planes.origin);
        let (zero, one) = (lanes.splat(0.0), lanes.splat(1.0));
        let dissipation = lanes.splat(law.dissipation) * pressed_factor;
        let [excess, by_y1, by_y2] = times(&motion.separating(), -dissipation);
        Self {
            zero,
            pressed_factor,
            friction: lanes.splat(law.friction) * pressed_factor,
            dissipation,
            load: SlipAndLoad {
                slip: motion.slip(),
                tolerance_squared: lanes.splat(law.slip_tolerance * law.slip_tolerance),
                pressure: planes.pressure,
                damping: motion.damping(dissipation, pressed_factor),
                one,
            },
            excess: [excess + (pressed_factor - one), by_y1, by_y2],
            motion,
        }
    }
}

/// The moments of a vector's components along e₁, e₂ and n, weighted by the monomials 1, y₁, y₂, y₁², y₁y₂ and y₂².
type VectorMoments<N> = [[N; 6]; 3];

/// The wrenches of ∂t/∂vᵢ times 1, y₁ and y₂, for i = 1, 2, 3.
type ByVelocity<N> = [[Six<N>; 3]; 3];

/// Moments over the area of a polygon.
pub(super) struct AreaMoments<N> {
    /// Moments of t along each axis, weighted by 1, y₁ and y₂.
    traction: [[N; 3]; 3],
    /// Moments of ∂t/∂p.
    by_pressure: VectorMoments<N>,
    /// Moments of the columns of T.
    by_velocity: [VectorMoments<N>; 3],
    /// Moments of ∂t/∂d and ∂t/∂μ along each axis, weighted by 1, y₁ and y₂.
    by_dissipation: [[N; 3]; 3],
    by_friction: [[N; 3]; 3],
}

/// The wrench of a polygon and its derivatives, about the polygon's origin along its axes.
pub(super) struct Rates<N> {
    pub wrench: Six<N>,
    /// K₀, K₁ and K₂.
    pub by_speed: [Six<N>; 3],
    pub by_motion: Columns<N>,
    pub by_twist: Columns<N>,
    pub by_dissipation: Six<N>,
    pub by_friction: Six<N>,
    /// The wrenches of ∂t/∂p, y₁∂t/∂p and y₂∂t/∂p.
    pub by_pressure: [Six<N>; 3],
}

impl<N: Linear> AreaMoments<N> {
    /// Computes the moments from the moments of the slip and the moments `area_moments` of the area. ψ is defined in [`LawOnPlane`], and u
    /// and σ in [`Slip`](crate::friction::Slip). If ψ > 0,
    ///
    /// t = p(−μψu₁, −μψu₂, ψ − 1),  ∂t/∂(v₁, v₂) = μpψ(u uᵀ − 1)/σ,  ∂t/∂v₃ = −dp(−μu₁, −μu₂, 1),
    ///
    /// and ∂t/∂d is ∂t/∂v₃ with v₃ in place of d. If the pressure is clamped, t = −p n.
    #[inline(always)]
    pub fn of(law: &LawOnPlane<N>, slip: &SlipMoments<N>, area_moments: &[N; 10]) -> Self {
        let (mu, d) = (law.friction, law.dissipation);
        let (pressure, damping) = (&law.load.pressure, &law.load.damping);
        let [u1, u2] = &slip.direction;
        // `p1` and `p2` are ∫ p m u dA, `p3` is ∫ p m dA, and `loaded1` and `loaded2` are ∫ pψ m u dA.
        let (p1, p2) = (up_to_quadratic(pressure, u1), up_to_quadratic(pressure, u2));
        let p3 = up_to_quadratic(pressure, area_moments);
        let (loaded1, loaded2) = (up_to_affine(damping, &p1), up_to_affine(damping, &p2));
        let normal = up_to_affine(&law.excess, &p3);
        let normal_by_pressure = up_to_quadratic(&law.excess, area_moments);
        let zeros = [law.zero; 6];
        let [s11, s12, s22] = &slip.by_slip;
        let (t11, t12, t22) = (times(s11, mu), times(s12, mu), times(s22, mu));
        let parting = &law.motion.separating();
        Self {
            traction: [times(&loaded1, -mu), times(&loaded2, -mu), normal],
            by_pressure: [
                times(&up_to_quadratic(damping, u1), -mu),
                times(&up_to_quadratic(damping, u2), -mu),
                normal_by_pressure,
            ],
            by_velocity: [
                [t11, t12, zeros],
                [t12, t22, zeros],
                [times(&p1, d * mu), times(&p2, d * mu), times(&p3, -d)],
            ],
            by_dissipation: [
                times(&up_to_affine(parting, &p1), mu),
                times(&up_to_affine(parting, &p2), mu),
                times(&up_to_affine(parting, &p3), -law.pressed_factor),
            ],
            by_friction: [negated(&loaded1), negated(&loaded2), [law.zero; 3]],
        }
    }

    #[inline(always)]
    pub fn wrench(&self) -> Six<N> {
        wrench_of(&self.traction)
    }

    /// Returns the wrenches of ∂t/∂p, y₁∂t/∂p and y₂∂t/∂p.
    #[inline(always)]
    pub fn by_pressure(&self) -> [Six<N>; 3] {
        wrenches(&self.by_pressure)
    }

    /// Returns the derivative of the wrench with respect to the velocity (angular, linear at the origin).
    #[inline(always)]
    pub fn by_twist(&self) -> Columns<N> {
        by_twist(&self.by_velocities())
    }

    #[inline(always)]
    fn by_velocities(&self) -> ByVelocity<N> {
        let [first, second, third] = &self.by_velocity;
        [wrenches(first), wrenches(second), wrenches(third)]
    }
}

impl<N: Linear> Rates<N> {
    /// Computes the derivatives without the contributions of edges, given ∇p_A·n.
    #[inline(always)]
    pub fn of_area(moments: &AreaMoments<N>, law: &LawOnPlane<N>, along_normal: N) -> Self {
        let by_velocities = moments.by_velocities();
        let by_pressure = moments.by_pressure();
        Self {
            wrench: moments.wrench(),
            by_speed: by_speed(
                law,
                &moments.traction,
                (&by_pressure, along_normal),
                &by_velocities,
            ),
            by_motion: [[law.zero; 6]; 6],
            by_twist: by_twist(&by_velocities),
            by_dissipation: wrench_of(&moments.by_dissipation),
            by_friction: wrench_of(&moments.by_friction),
            by_pressure,
        }
    }

    /// Adds the contribution of a moving edge. `fluxes` are the wrenches of the flux if the edge's face moves outwards at the speeds 1, y₁
    /// and y₂. `normal` is the outward normal of this face along the axes. `of_b` is 1 for a face of B and 0 for a face of A.
    #[inline(always)]
    pub fn add_flux(&mut self, fluxes: &[Six<N>; 3], normal: [N; 3], b_factor: N) {
        for (k, flux) in self.by_speed.iter_mut().zip(fluxes) {
            *k = minus(k, &times(flux, normal[2]));
        }
        self.add_along_normal(scaled(normal, b_factor), fluxes);
    }

    /// Multiplies the contributions of the area to K₀, K₁ and K₂ by `moving`, and all other contributions by `still`. Derivatives with
    /// respect to the pressure are not multiplied.
    #[inline(always)]
    pub fn weight(&mut self, still: N, moving: N) {
        for by_speed in &mut self.by_speed {
            *by_speed = times(by_speed, moving);
        }
        for column in &mut self.by_twist {
            *column = times(column, still);
        }
        for moments in [
            &mut self.wrench,
            &mut self.by_dissipation,
            &mut self.by_friction,
        ] {
            *moments = times(moments, still);
        }
    }

    /// Adds the contribution of the plane, which moves if B moves. `slope_b` is ∇p_B/|∇p_A − ∇p_B| along the axes.
    #[inline(always)]
    pub fn add_motion_of_plane(&mut self, slope_b: [N; 3]) {
        let by_speed = self.by_speed;
        self.add_along_normal([-slope_b[0], -slope_b[1], -slope_b[2]], &by_speed);
    }

    /// Adds a contribution to `by_motion`. A motion (θ, u) about the origin moves a point y with the normal speed m·(u + θ × y). The
    /// arguments are m, and the contributions of motions with the normal speeds 1, y₁ and y₂. The columns follow from
    ///
    /// m·(θ × y) = θ·(y × m),  y × m = (y₂m₃, −y₁m₃, y₁m₂ − y₂m₁).
    #[inline(always)]
    pub fn add_along_normal(&mut self, [m1, m2, m3]: [N; 3], [f0, f1, f2]: &[Six<N>; 3]) {
        for row in 0..6 {
            let (f0, f1, f2) = (f0[row], f1[row], f2[row]);
            let [c0, c1, c2, c3, c4, c5] = &mut self.by_motion;
            c0[row] = c0[row] + f2 * m3;
            c1[row] = c1[row] - f1 * m3;
            c2[row] = c2[row] + (f1 * m2 - f2 * m1);
            c3[row] = c3[row] + f0 * m1;
            c4[row] = c4[row] + f0 * m2;
            c5[row] = c5[row] + f0 * m3;
        }
    }
}

#[inline(always)]
fn by_twist<N: Linear>([by_v1, by_v2, by_v3]: &ByVelocity<N>) -> Columns<N> {
    [
        by_v3[2],
        negated(&by_v3[1]),
        minus(&by_v2[1], &by_v1[2]),
        by_v1[0],
        by_v2[0],
        by_v3[0],
    ]
}

/// Returns K₀, K₁ and K₂ without the contributions of the edges.
#[inline(always)]
fn by_speed<N: Linear>(
    law: &LawOnPlane<N>,
    t: &[[N; 3]; 3],
    (by_pressure, along_normal): (&[Six<N>; 3], N),
    [by_v1, by_v2, by_v3]: &ByVelocity<N>,
) -> [Six<N>; 3] {
    let PlaneMotion {
        velocity: [v1, v2, v3],
        angular: [w1, w2, w3],
    } = law.motion;
    let zero = law.zero;
    let mut by_speed = [[zero; 6]; 3];
    for k in 0..3 {
        by_speed[k] = plus(
            &times(&by_pressure[k], along_normal),
            &minus(&times(&by_v1[k], w2), &times(&by_v2[k], w1)),
        );
        by_speed[k][0] = by_speed[k][0] - t[1][k];
        by_speed[k][1] = by_speed[k][1] + t[0][k];
    }
    let [t1, t2, t3] = t;
    let turned1 = [t1[2], -t1[1], t3[2], -t3[0], zero, t1[0]];
    let turned2 = [t2[2], -t2[1], -t3[1], zero, -t3[0], t2[0]];
    for row in 0..6 {
        let times_v3 = by_v1[0][row] * v3 - by_v1[1][row] * w2 + by_v1[2][row] * w1;
        let times_v1 = by_v3[0][row] * v1 - by_v3[2][row] * w3;
        by_speed[1][row] = by_speed[1][row] + (turned1[row] + times_v3 - times_v1);
        let times_v3 = by_v2[0][row] * v3 - by_v2[1][row] * w2 + by_v2[2][row] * w1;
        let times_v2 = by_v3[0][row] * v2 + by_v3[1][row] * w3;
        by_speed[2][row] = by_speed[2][row] + (turned2[row] + times_v3 - times_v2);
    }
    by_speed
}

/// Returns ∫ f m for an affine f and the monomials up to quadratic ones, from the moments by monomials up to cubic ones.
#[inline(always)]
fn up_to_quadratic<N: Linear>(f: &[N; 3], m: &[N; 10]) -> [N; 6] {
    [
        combined(f, [m[0], m[1], m[2]]),
        combined(f, [m[1], m[3], m[4]]),
        combined(f, [m[2], m[4], m[5]]),
        combined(f, [m[3], m[6], m[7]]),
        combined(f, [m[4], m[7], m[8]]),
        combined(f, [m[5], m[8], m[9]]),
    ]
}

/// Returns ∫ f m for an affine f and the monomials 1, y₁ and y₂.
#[inline(always)]
fn up_to_affine<N: Linear>(f: &[N; 3], m: &[N; 6]) -> [N; 3] {
    [
        combined(f, [m[0], m[1], m[2]]),
        combined(f, [m[1], m[3], m[4]]),
        combined(f, [m[2], m[4], m[5]]),
    ]
}

/// Returns ∫ f·m of an affine function f, from ∫ m, ∫ y₁·m and ∫ y₂·m.
#[inline(always)]
fn combined<N: Linear>(f: &[N; 3], [one, y1, y2]: [N; 3]) -> N {
    f[0] * one + f[1] * y1 + f[2] * y2
}
