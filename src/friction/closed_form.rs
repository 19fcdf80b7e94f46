//! Integrals in closed form, computed from integrals along the edges.
//!
//! Let y* be the center of rotation, r = y − y*, ε = v_s/|w| and R = √(r·r + ε²). The slip is w·(−r₂, r₁), and its regularized direction is
//! u = sgn(w)·(−r₂, r₁)/R. For f homogeneous of degree d let I\[f\] = ∫ f/R dA and M\[f\] = ∫ f·R dA. Because ∂R/∂rᵢ = rᵢ/R, the
//! divergences of f·R·eᵢ and of r·f·R give, with the outward normal n,
//!
//!   I\[rᵢf\] = ∮ nᵢ·f·R dl − M\[∂ᵢf\]        (d + 3)·M\[f\] = ∮ (r·n)·f·R dl + ε²·I\[f\]
//!
//! The recursion starts with I\[1\] = ∮ (r·n)/R dl − ε·Ω. The divergence of r/R is 1/R + ε²/R³, and Ω = ∫ ε/R³ dA is the solid angle of the
//! polygon seen from the height ε above y*.

use super::edge::{Corner, EdgeMeans, Vector, cross, dot};
use super::{Affine, Load, Quadratic, Slip, product};
use crate::scalar::portable::atan2;
use crate::scalar::{Scalar, lift, real_part};

/// Smallest ε, as a fraction of the polygon's size. A smaller ε is replaced by this one, so that its powers do not underflow. The integrals
/// change by less than round-off.
const LEAST_EPSILON: f64 = 1e-50;

/// The slip as a rotation about a center with a sense (±1), regularized at the distance ε = v_s/|w|.
pub(super) struct Rotation<T> {
    pub center: Vector<T>,
    pub epsilon: T,
    pub sense: f64,
}

impl<T: Scalar> Rotation<T> {
    pub fn new(slip: &Slip<T>, size: f64) -> Self {
        let per_spin = slip.spin.recip();
        let sense = real_part(slip.spin).signum();
        let epsilon = per_spin * (sense * slip.tolerance);
        let least = LEAST_EPSILON * size;
        Self {
            center: [-slip.at_origin[1] * per_spin, slip.at_origin[0] * per_spin],
            epsilon: if real_part(epsilon) > least {
                epsilon
            } else {
                lift(least)
            },
            sense,
        }
    }

    /// Converts an affine function of y to one of r.
    fn about_center(&self, function: &Affine<T>) -> Affine<T> {
        let at_center = function[0] + dot([function[1], function[2]], self.center);
        [at_center, function[1], function[2]]
    }

    pub fn corner(&self, y: &Vector<T>) -> Corner<T> {
        let position = [y[0] - self.center[0], y[1] - self.center[1]];
        Corner::new(position, self.epsilon * self.epsilon)
    }

    /// Visits the edge from each corner to the next.
    pub fn visit_edges(
        &self,
        corners: &[Vector<T>],
        mut visit: impl FnMut(&Corner<T>, &Corner<T>),
    ) {
        let mut corners = corners.iter().map(|y| self.corner(y));
        let Some(first) = corners.next() else {
            return;
        };
        let mut before = first;
        for after in corners {
            visit(&before, &after);
            before = after;
        }
        visit(&before, &first);
    }
}

/// Half the solid angle of a polygon seen from the height ε: the argument of a product of complex numbers, with one factor for each edge.
///
/// The triangle of the foot of the height, a and b has the solid angle Ω with tan(Ω/2) = a×b / ((R_a+ε)(R_b+ε) + a·b) \[A. Van Oosterom, J.
/// Strackee, "The solid angle of a plane triangle", IEEE Trans. Biomed. Eng. 30, 1983\]. Half the solid angle of a convex polygon is less
/// than π, so full turns of the argument need not be counted. If a·b cancels R_a·R_b, ε is so small that Ω is negligible, because Ω is
/// always multiplied by ε³.
pub(super) struct HalfSolidAngle<T>(Vector<T>);

impl<T: Scalar> HalfSolidAngle<T> {
    pub fn new() -> Self {
        Self([lift(1.0), lift(0.0)])
    }

    #[inline]
    pub fn turn(&mut self, a: &Corner<T>, b: &Corner<T>, epsilon: T) {
        let real = (a.distance + epsilon) * (b.distance + epsilon) + dot(a.position, b.position);
        let imaginary = cross(a.position, b.position);
        let size = real_part(real).abs() + real_part(imaginary).abs();
        if size > 0.0 {
            let by = [real * size.recip(), imaginary * size.recip()];
            self.0 = [
                self.0[0] * by[0] - self.0[1] * by[1],
                self.0[0] * by[1] + self.0[1] * by[0],
            ];
        }
    }

    pub fn solid_angle(&self) -> T {
        atan2(self.0[1], self.0[0]) * 2.0
    }
}

/// Sums over the edges for the resultant: ∮ nᵢ·f·R dl and ∮ (r·n)·f·R dl.
struct ResultantSums<T> {
    /// nᵢ with f = g.
    load: Vector<T>,
    /// nᵢ with f = 1.
    constant: Vector<T>,
    /// n₁ with f = r₁, n₂ with r₁, n₂ with r₂.
    linear: [T; 3],
    /// r·n with f = 1, r₁, r₂, and the quadratic part of g.
    radial: [T; 4],
    /// ∮ (r·n)/R dl.
    radial_over_r: T,
}

impl<T: Scalar> ResultantSums<T> {
    fn zero() -> Self {
        let zero = lift(0.0);
        Self {
            load: [zero; 2],
            constant: [zero; 2],
            linear: [zero; 3],
            radial: [zero; 4],
            radial_over_r: zero,
        }
    }

    /// Adds the edge from a to b: n dl = (span₂, −span₁) and r·n dl = a×b, times means.
    #[inline]
    fn add(&mut self, a: &Corner<T>, b: &Corner<T>, means: &EdgeMeans<T>, load: &Quadratic<T>) {
        let ([o1, o2], [e1, e2]) = (means.base, means.direction);
        let [m0, m1, m2, _] = means.by_r;
        let (first, second) = (o1 * m0 + e1 * m1, o2 * m0 + e2 * m1);
        let (moved1, moved2) = (o1 * m1 + e1 * m2, o2 * m1 + e2 * m2);
        let quadratic = load[3] * (o1 * first + e1 * moved1)
            + load[4] * (o1 * second + e1 * moved2)
            + load[5] * (o2 * second + e2 * moved2);
        let all = load[0] * m0 + load[1] * first + load[2] * second + quadratic;
        let normal = [b.position[1] - a.position[1], a.position[0] - b.position[0]];
        let radial = cross(a.position, b.position);
        for (i, component) in normal.into_iter().enumerate() {
            self.load[i] += component * all;
            self.constant[i] += component * m0;
        }
        self.linear[0] += normal[0] * first;
        self.linear[1] += normal[1] * first;
        self.linear[2] += normal[1] * second;
        self.radial[0] += radial * m0;
        self.radial[1] += radial * first;
        self.radial[2] += radial * second;
        self.radial[3] += radial * quadratic;
        self.radial_over_r += radial * means.over_r[0];
    }

    /// Returns ∫ g·r₁/R dA, ∫ g·r₂/R dA, and ∫ g·r·r/R dA = M\[g\] − ε²·I\[g\].
    fn integrals(&self, solid_angle: T, epsilon: T, g: &Quadratic<T>) -> [T; 3] {
        let squared = epsilon * epsilon;
        let i0 = self.radial_over_r - epsilon * solid_angle;
        let [i1, i2] = self.constant;
        let m0 = (self.radial[0] + squared * i0) * (1.0 / 3.0);
        let m1 = (self.radial[1] + squared * i1) * 0.25;
        let m2 = (self.radial[2] + squared * i2) * 0.25;
        let (i11, i12, i22) = (self.linear[0] - m0, self.linear[1], self.linear[2] - m0);
        let over_r = squared * (g[3] * i11 + g[4] * i12 + g[5] * i22);
        let quadratic = (self.radial[3] + over_r) * 0.2 - over_r;
        [
            self.load[0] - (g[1] * m0 + g[3] * m1 * 2.0 + g[4] * m2),
            self.load[1] - (g[2] * m0 + g[4] * m1 + g[5] * m2 * 2.0),
            g[0] * (m0 - squared * i0)
                + g[1] * (m1 - squared * i1)
                + g[2] * (m2 - squared * i2)
                + quadratic,
        ]
    }
}

/// Computes [`Slip::resultant`] of a slip with a spin. The corners must be within about `size` of the origin.
pub(super) fn resultant<T: Scalar>(
    slip: &Slip<T>,
    corners: &[Vector<T>],
    load: &Load<T>,
    size: f64,
) -> [T; 3] {
    let rotation = Rotation::new(slip, size);
    let epsilon = rotation.epsilon;
    let pressure = rotation.about_center(load.pressure);
    let g = product(&pressure, &rotation.about_center(load.damping));
    let (mut sums, mut angle) = (ResultantSums::zero(), HalfSolidAngle::new());
    rotation.visit_edges(corners, |a, b| {
        angle.turn(a, b, epsilon);
        let means = EdgeMeans::new(a, b, epsilon * epsilon);
        sums.add(a, b, &means, &g);
    });
    let [first, second, polar] = sums.integrals(angle.solid_angle(), epsilon, &g);
    let turning = dot(rotation.center, [first, second]) + polar;
    [-second, first, turning].map(|component| component * rotation.sense)
}
