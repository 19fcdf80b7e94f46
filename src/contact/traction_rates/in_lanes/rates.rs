//! [`Rates`](super::super::Rates) of polygons side by side, one in each lane: by the formulas of `area.rs` and `edges.rs`, for
//! polygons that count as a whole and edges that lie in one face each.

use super::quadrature::AreaSums;
use crate::contact::plane_motion::PlaneMotion;
use crate::lanes::Numbers;
use crate::lanes::space::{cross, scaled, sum};

/// A wrench or a motion: torque or turn, then force or shift.
pub(super) type Six<N> = [N; 6];

/// Columns.
pub(super) type Matrix<N> = [Six<N>; 6];

/// The derivatives of a polygon's wrench, about its origin along its axes.
pub(super) struct Rates<N> {
    pub wrench: Six<N>,
    /// K₀, K₁ and K₂.
    pub by_speed: [Six<N>; 3],
    pub by_motion: Matrix<N>,
    pub by_twist: Matrix<N>,
    pub by_dissipation: Six<N>,
    pub by_friction: Six<N>,
    /// Of ∂t/∂p, y₁∂t/∂p and y₂∂t/∂p.
    pub by_pressure: [Six<N>; 3],
}

/// What the law makes of slip and pressure on a polygon.
pub(super) struct Traction<N> {
    pub zero: N,
    pub friction: N,
    pub dissipation: N,
    pub pressure: [N; 3],
    pub damping: [N; 3],
    /// −d v₃.
    pub excess: [N; 3],
    pub motion: PlaneMotion<N>,
    /// ∇p_A·n.
    pub along_normal: N,
}

/// The wrenches of ∂t/∂vᵢ times 1, y₁ and y₂.
type ByVelocity<N> = [[Six<N>; 3]; 3];

impl<N: Numbers> Rates<N> {
    /// All but what the edges contribute.
    #[inline(always)]
    pub fn of_area(sums: &AreaSums<N>, traction: &Traction<N>) -> Self {
        let (mu, d) = (traction.friction, traction.dissipation);
        let (pressure, damping) = (&traction.pressure, &traction.damping);
        let excess = &traction.excess;
        let [u1, u2] = &sums.direction;
        // ∫ p m u and ∫ p m dA; ∫ pψ m u dA.
        let (p1, p2) = (up_to_quadratic(pressure, u1), up_to_quadratic(pressure, u2));
        let p3 = up_to_quadratic(pressure, &sums.one);
        let (loaded1, loaded2) = (up_to_affine(damping, &p1), up_to_affine(damping, &p2));
        let t = [
            times(&loaded1, -mu),
            times(&loaded2, -mu),
            up_to_affine(excess, &p3),
        ];
        let by_pressure = wrenches([
            times(&up_to_quadratic(damping, u1), -mu),
            times(&up_to_quadratic(damping, u2), -mu),
            up_to_quadratic(excess, &sums.one),
        ]);
        let none = [traction.zero; 6];
        let [s11, s12, s22] = &sums.by_slip;
        let (t11, t12, t22) = (times(s11, mu), times(s12, mu), times(s22, mu));
        let by_velocity = [
            wrenches([t11, t12, none]),
            wrenches([t12, t22, none]),
            wrenches([times(&p1, d * mu), times(&p2, d * mu), times(&p3, -d)]),
        ];
        let [by_v1, by_v2, by_v3] = &by_velocity;
        let by_twist = [
            by_v3[2],
            negated(&by_v3[1]),
            less(&by_v2[1], &by_v1[2]),
            by_v1[0],
            by_v2[0],
            by_v3[0],
        ];
        let parting = &traction.motion.separating();
        Self {
            wrench: wrench_of(t),
            by_speed: by_speed(traction, &t, &by_pressure, &by_velocity),
            by_motion: [none; 6],
            by_twist,
            by_dissipation: wrench_of([
                times(&up_to_affine(parting, &p1), mu),
                times(&up_to_affine(parting, &p2), mu),
                negated(&up_to_affine(parting, &p3)),
            ]),
            by_friction: wrench_of([negated(&loaded1), negated(&loaded2), [traction.zero; 3]]),
            by_pressure,
        }
    }

    /// Adds what the motion of an edge contributes: the wrenches of the flux as the edge's face moves outwards, that face's normal
    /// along the axes, and 1 for a face of B, 0 for one of A.
    #[inline(always)]
    pub fn add_flux(&mut self, fluxes: &[Six<N>; 3], normal: [N; 3], of_b: N) {
        for (k, flux) in self.by_speed.iter_mut().zip(fluxes) {
            *k = less(k, &times(flux, normal[2]));
        }
        self.add_along_normal(scaled(normal, of_b), fluxes);
    }

    /// Adds what the plane contributes as B moves: the slopes of p_B over that of p_A − p_B, along the axes.
    #[inline(always)]
    pub fn add_motion_of_plane(&mut self, slope_b: [N; 3]) {
        let by_speed = self.by_speed;
        self.add_along_normal([-slope_b[0], -slope_b[1], -slope_b[2]], &by_speed);
    }

    /// See [`add_along_normal`](super::super::add_along_normal).
    #[inline(always)]
    fn add_along_normal(&mut self, [m1, m2, m3]: [N; 3], [f0, f1, f2]: &[Six<N>; 3]) {
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

/// K₀, K₁ and K₂ without the edges.
#[inline(always)]
fn by_speed<N: Numbers>(
    traction: &Traction<N>,
    t: &[[N; 3]; 3],
    by_pressure: &[Six<N>; 3],
    [by_v1, by_v2, by_v3]: &ByVelocity<N>,
) -> [Six<N>; 3] {
    let PlaneMotion {
        velocity: [v1, v2, v3],
        angular: [w1, w2, w3],
    } = traction.motion;
    let zero = traction.zero;
    let mut by_speed = [[zero; 6]; 3];
    for k in 0..3 {
        by_speed[k] = plus(
            &times(&by_pressure[k], traction.along_normal),
            &less(&times(&by_v1[k], w2), &times(&by_v2[k], w1)),
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

/// A plane's origin and axes, e₁, e₂ and n.
pub(super) struct Frame<N> {
    pub origin: [N; 3],
    pub axes: [[N; 3]; 3],
}

impl<N: Numbers> Frame<N> {
    /// A wrench about the origin along the axes, about A's origin in A's axes; and the same way motions.
    #[inline(always)]
    pub fn turned(&self, [t1, t2, t3, f1, f2, f3]: &Six<N>) -> Six<N> {
        let [e1, e2, n] = self.axes;
        let force = sum(sum(scaled(e1, *f1), scaled(e2, *f2)), scaled(n, *f3));
        let torque = sum(sum(scaled(e1, *t1), scaled(e2, *t2)), scaled(n, *t3));
        let [t1, t2, t3] = sum(torque, cross(self.origin, force));
        let [f1, f2, f3] = force;
        [t1, t2, t3, f1, f2, f3]
    }

    /// A matrix of wrenches by motions or velocities, in A's axes about A's origin.
    #[inline(always)]
    pub fn turned_matrix(&self, matrix: &Matrix<N>) -> Matrix<N> {
        let mut turned = *matrix;
        for column in &mut turned {
            *column = self.turned(column);
        }
        for row in 0..6 {
            let [c0, c1, c2, c3, c4, c5] = &turned;
            let across = self.turned(&[c0[row], c1[row], c2[row], c3[row], c4[row], c5[row]]);
            for column in 0..6 {
                turned[column][row] = across[column];
            }
        }
        turned
    }
}

/// The wrench of a traction from its moments by 1, y₁ and y₂ along each axis.
#[inline(always)]
fn wrench_of<N: Numbers>([t1, t2, t3]: [[N; 3]; 3]) -> Six<N> {
    [t3[2], -t3[1], t2[1] - t1[2], t1[0], t2[0], t3[0]]
}

/// The wrenches of a traction times 1, y₁ and y₂.
#[inline(always)]
pub(super) fn wrenches<N: Numbers>([t1, t2, t3]: [[N; 6]; 3]) -> [Six<N>; 3] {
    [
        wrench_of([
            [t1[0], t1[1], t1[2]],
            [t2[0], t2[1], t2[2]],
            [t3[0], t3[1], t3[2]],
        ]),
        wrench_of([
            [t1[1], t1[3], t1[4]],
            [t2[1], t2[3], t2[4]],
            [t3[1], t3[3], t3[4]],
        ]),
        wrench_of([
            [t1[2], t1[4], t1[5]],
            [t2[2], t2[4], t2[5]],
            [t3[2], t3[4], t3[5]],
        ]),
    ]
}

/// ∫ f m for an affine f and the monomials up to quadratic ones, from the moments by those up to cubic ones.
#[inline(always)]
fn up_to_quadratic<N: Numbers>(f: &[N; 3], m: &[N; 10]) -> [N; 6] {
    [
        combined(f, [m[0], m[1], m[2]]),
        combined(f, [m[1], m[3], m[4]]),
        combined(f, [m[2], m[4], m[5]]),
        combined(f, [m[3], m[6], m[7]]),
        combined(f, [m[4], m[7], m[8]]),
        combined(f, [m[5], m[8], m[9]]),
    ]
}

/// The same for the monomials 1, y₁ and y₂.
#[inline(always)]
fn up_to_affine<N: Numbers>(f: &[N; 3], m: &[N; 6]) -> [N; 3] {
    [
        combined(f, [m[0], m[1], m[2]]),
        combined(f, [m[1], m[3], m[4]]),
        combined(f, [m[2], m[4], m[5]]),
    ]
}

/// ∫ f from the moments by 1, y₁ and y₂.
#[inline(always)]
fn combined<N: Numbers>(f: &[N; 3], [one, y1, y2]: [N; 3]) -> N {
    f[0] * one + f[1] * y1 + f[2] * y2
}

#[inline(always)]
pub(super) fn times<N: Numbers, const K: usize>(numbers: &[N; K], factor: N) -> [N; K] {
    let mut products = *numbers;
    for product in &mut products {
        *product = *product * factor;
    }
    products
}

#[inline(always)]
fn negated<N: Numbers, const K: usize>(numbers: &[N; K]) -> [N; K] {
    let mut negated = *numbers;
    for number in &mut negated {
        *number = -*number;
    }
    negated
}

#[inline(always)]
pub(super) fn plus<N: Numbers, const K: usize>(numbers: &[N; K], others: &[N; K]) -> [N; K] {
    let mut sums = *numbers;
    for (sum, other) in sums.iter_mut().zip(others) {
        *sum = *sum + *other;
    }
    sums
}

#[inline(always)]
fn less<N: Numbers, const K: usize>(numbers: &[N; K], others: &[N; K]) -> [N; K] {
    let mut differences = *numbers;
    for (difference, other) in differences.iter_mut().zip(others) {
        *difference = *difference - *other;
    }
    differences
}
