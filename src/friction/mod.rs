//! Regularized Coulomb friction over a plane convex polygon, exact to round-off.
//!
//! In a rigid motion the velocity s of slip is affine, and friction acts along −u with u = s/√(s·s + v_s²). If u hardly changes over the
//! polygon, quadrature of a high degree is exact to round-off. If the center of rotation is near and u varies rapidly, the integrals have a
//! closed form.

mod closed_form;
mod closed_moments;
mod edge;
mod in_lanes;
mod quadrature;
mod rules;
#[cfg(test)]
mod tests;

use crate::lanes::Linear;
use crate::scalar::{Scalar, carries_derivatives, real_part};
pub(crate) use in_lanes::{Edge, SlipAndLoad, add_up_to_quadratic, at as at_in_lanes};
pub(crate) use rules::{EdgeRule, TriangleRule};
use std::ops::Div;

/// An affine function in the plane, c₀ + c₁y₁ + c₂y₂.
pub(crate) type Affine<T> = [T; 3];

/// The coefficients of 1, y₁, y₂, y₁², y₁y₂, y₂².
pub(crate) type Quadratic<T> = [T; 6];

/// The velocity (m/s) at which two surfaces slip along a plane, s(y) = at_origin + spin·(−y₂, y₁), and the slip tolerance v_s > 0 (m/s).
/// The origin is a point near the polygon.
///
/// The regularized direction of slip is u = s/σ with σ = √(s·s + v_s²).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Slip<T> {
    pub at_origin: [T; 2],
    pub spin: T,
    pub tolerance: f64,
}

/// The closed form for a slip direction that varies rapidly over a loaded polygon. It computes the integrals from which the derivatives of
/// [`Slip::resultant`] follow.
pub(crate) struct ClosedForm<'a> {
    slip: Slip<f64>,
    load: Load<'a, f64>,
    corners: &'a [[f64; 2]],
    /// The distance of the farthest corner from the mean of the corners (m).
    size: f64,
}

/// Integrals over the area, in plane coordinates, of the regularized direction of slip u and the load g = pressure·damping.
pub(crate) struct SlipMoments<N = f64> {
    /// ∫ m·u dA for the monomials m = 1, y₁, y₂, y₁², y₁y₂, y₂², y₁³, y₁²y₂, y₁y₂², y₂³.
    pub direction: [[N; 10]; 2],
    /// ∫ g·m·(u uᵀ − 1)/σ dA for the first six monomials, with the entries 11, 12 and 22 of the symmetric matrix. This is minus the
    /// derivative of ∫ g·m·u dA with respect to the slip.
    pub by_slip: [[N; 6]; 3],
}

/// The load g = pressure·damping.
struct Load<'a, T> {
    pressure: &'a Affine<T>,
    damping: &'a Affine<T>,
}

impl<T: Scalar> Load<'_, T> {
    #[inline]
    fn at(&self, [y1, y2]: [T; 2]) -> T {
        let [p, d] = [self.pressure, self.damping].map(|f| f[0] + f[1] * y1 + f[2] * y2);
        p * d
    }
}

/// Quadrature rules for a slip that changes by less than a fraction of σ over the polygon.
struct QuadratureLevel {
    /// Upper bound of θ = |w|·L/σ. Here w is the spin, σ is the value at the mean of the corners, and L is the distance of the farthest
    /// corner from this mean.
    below: f64,
    /// Rule for values.
    value: &'static TriangleRule,
    /// Rule for derivatives, whose errors are larger by a factor of 1/θ.
    slopes: &'static TriangleRule,
    edge: &'static EdgeRule,
}

/// Levels of quadrature, in ascending order. The comment of each level lists the largest errors for θ just below the upper bound of the
/// level. The sample has 400 random polygons with 3 to 8 corners, whose length is at most ten times their width. The four numbers are the
/// errors of
///
/// 1. the resultant, relative to ∫ |g| dA and ∫ |g|·|y| dA,
/// 2. `direction`, relative to ∫ |y|ᵏ dA for monomials of degree k,
/// 3. `by_slip`, relative to ∫ |g|·|y|ᵏ/σ dA,
/// 4. the fluxes through the edges, relative to ∮ |g|·|y|ᵏ dl.
///
/// The test `errors_at_the_upper_ends_of_the_levels_are_those_noted` prints them.
///
/// Just above the last level, the errors of the closed form are 1e-12, 1e-11, 1e-10 and 9e-14. At θ = 2 they are 2e-14, 5e-14, 3e-13 and
/// 3e-15. For smaller θ they grow like θ⁻⁵.
const QUADRATURE: [QuadratureLevel; 6] = [
    // 7e-13, 1e-15, 6e-12, 5e-16: for an almost constant slip, which is the common case.
    QuadratureLevel {
        below: 1e-5,
        value: &rules::TRIANGLE_4,
        slopes: &rules::TRIANGLE_5,
        edge: &rules::EDGE_4,
    },
    // 1e-15, 1e-15, 1e-12, 2e-13.
    QuadratureLevel {
        below: 3e-3,
        value: &rules::TRIANGLE_7,
        slopes: &rules::TRIANGLE_7,
        edge: &rules::EDGE_4,
    },
    // 3e-13, 9e-13, 3e-10, 4e-16.
    QuadratureLevel {
        below: 0.012,
        value: &rules::TRIANGLE_7,
        slopes: &rules::TRIANGLE_7,
        edge: &rules::EDGE_6,
    },
    // 5e-13, 2e-12, 1e-10, 1e-15.
    QuadratureLevel {
        below: 0.04,
        value: &rules::TRIANGLE_8,
        slopes: &rules::TRIANGLE_8,
        edge: &rules::EDGE_6,
    },
    // 2e-13, 5e-13, 1e-11, 2e-14.
    QuadratureLevel {
        below: 0.2,
        value: &rules::TRIANGLE_12,
        slopes: &rules::TRIANGLE_12,
        edge: &rules::EDGE_8,
    },
    // 2e-12, 5e-12, 1e-10, 3e-12.
    QuadratureLevel {
        below: 0.48,
        value: &rules::TRIANGLE_17,
        slopes: &rules::TRIANGLE_17,
        edge: &rules::EDGE_10,
    },
];

/// Number of levels.
pub(crate) const LEVELS: usize = QUADRATURE.len();

/// Returns the value of θ below which each level is accurate enough.
pub(crate) fn level_bounds() -> [f64; LEVELS] {
    QUADRATURE.each_ref().map(|level| level.below)
}

/// Returns θ² (see [`QuadratureLevel`]) of one polygon, or of one polygon in each lane. The first argument has the slip at the origin, the
/// spin and the slip tolerance. `mean` is the mean of the corners. `size_squared` is the squared distance of the farthest corner from this
/// mean.
#[inline(always)]
pub(crate) fn theta_squared<N: Linear + Div<Output = N>>(
    (at_origin, spin, tolerance): ([N; 2], N, N),
    mean: [N; 2],
    size_squared: N,
) -> N {
    let [s1, s2] = [at_origin[0] - spin * mean[1], at_origin[1] + spin * mean[0]];
    spin * spin * size_squared / (s1 * s1 + s2 * s2 + tolerance * tolerance)
}

/// Returns the rule of a level for values.
pub(crate) fn value_rule(level: usize) -> &'static TriangleRule {
    QUADRATURE[level].value
}

/// Returns the rules of a level for derivatives: over the area, and along edges.
pub(crate) fn slope_rules(level: usize) -> (&'static TriangleRule, &'static EdgeRule) {
    (QUADRATURE[level].slopes, QUADRATURE[level].edge)
}

/// Method of integration over a polygon.
enum Method {
    Rule(&'static QuadratureLevel),
    /// The closed form, with the size of the polygon (see [`ClosedForm::size`]).
    ClosedForm(f64),
}

impl<T: Scalar> Slip<T> {
    /// Returns ∫ g·u dA and ∫ g·(y₁u₂ − y₂u₁) dA, with g = pressure·damping. The corners are in counter-clockwise order.
    pub fn resultant(
        &self,
        corners: &[[T; 2]],
        pressure: &Affine<T>,
        damping: &Affine<T>,
    ) -> [T; 3] {
        let load = Load { pressure, damping };
        match self.method(corners) {
            Method::Rule(level) => {
                let rule = if carries_derivatives::<T>() {
                    level.slopes
                } else {
                    level.value
                };
                quadrature::resultant(self, corners, &load, rule)
            }
            Method::ClosedForm(size) => closed_form::resultant(self, corners, &load, size),
        }
    }

    /// Returns the lowest level that is accurate enough, or `None` if no level is.
    pub fn level(&self, corners: &[[T; 2]]) -> Option<usize> {
        SlipVariation::of(self, corners).level()
    }

    fn method(&self, corners: &[[T; 2]]) -> Method {
        let variation = SlipVariation::of(self, corners);
        match variation.level() {
            Some(level) => Method::Rule(&QUADRATURE[level]),
            None => Method::ClosedForm(variation.size_squared.sqrt()),
        }
    }
}

/// Variation of a slip over a polygon (see [`QuadratureLevel`]).
struct SlipVariation {
    /// The squared distance of the farthest corner from the mean of the corners (m²).
    size_squared: f64,
    /// θ².
    theta_squared: f64,
}

impl SlipVariation {
    fn of<T: Scalar>(slip: &Slip<T>, corners: &[[T; 2]]) -> Self {
        let real = |y: &[T; 2]| y.map(real_part);
        let sum = corners
            .iter()
            .map(real)
            .fold([0.0; 2], |sum, y| [sum[0] + y[0], sum[1] + y[1]]);
        let mean = sum.map(|component| component / corners.len().max(1) as f64);
        let squared = |y: [f64; 2]| (y[0] - mean[0]).powi(2) + (y[1] - mean[1]).powi(2);
        let size_squared = corners.iter().map(|y| squared(real(y))).fold(0.0, f64::max);
        let spin = real_part(slip.spin);
        let at_origin = slip.at_origin.map(real_part);
        Self {
            size_squared,
            theta_squared: theta_squared((at_origin, spin, slip.tolerance), mean, size_squared),
        }
    }

    fn level(&self) -> Option<usize> {
        let is_within = |level: &QuadratureLevel| self.theta_squared < level.below.powi(2);
        QUADRATURE.iter().position(is_within)
    }
}

impl<'a> ClosedForm<'a> {
    /// Creates the closed form for the polygon with these corners, in counter-clockwise order. The spin of the slip must not be zero.
    pub fn on(
        corners: &'a [[f64; 2]],
        slip: Slip<f64>,
        pressure: &'a Affine<f64>,
        damping: &'a Affine<f64>,
    ) -> Self {
        Self {
            slip,
            load: Load { pressure, damping },
            corners,
            size: SlipVariation::of(&slip, corners).size_squared.sqrt(),
        }
    }
}

/// Returns the corners that an edge joins: the corner with the index of the edge, and the next one. The first corner follows the last one.
#[inline]
pub(crate) fn ends<C: Copy>(corners: &[C], edge: usize) -> [C; 2] {
    let next = edge + 1;
    [
        corners[edge],
        corners[if next == corners.len() { 0 } else { next }],
    ]
}

/// Returns the product of two affine functions: the coefficients of 1, y₁, y₂, y₁², y₁y₂, y₂².
pub(crate) fn product<T: Scalar>(f: &Affine<T>, g: &Affine<T>) -> Quadratic<T> {
    [
        f[0] * g[0],
        f[0] * g[1] + f[1] * g[0],
        f[0] * g[2] + f[2] * g[0],
        f[1] * g[1],
        f[1] * g[2] + f[2] * g[1],
        f[2] * g[2],
    ]
}
