//! Integrals of slip and load by quadrature, over several polygons or edges at a time, one in each lane.

use super::SlipMoments;
use super::rules::{EdgeRule, TriangleRule};
use crate::lanes::{Lanes, Numbers};

/// Indices of y₁·m and y₂·m among the monomials up to degree 4, for each monomial m up to degree 3 (see [`add_up_to_quartic`]).
const TIMES_Y1: [usize; 10] = [1, 3, 4, 6, 7, 8, 10, 11, 12, 13];
const TIMES_Y2: [usize; 10] = [2, 4, 5, 7, 8, 9, 11, 12, 13, 14];

/// Slip, pressure and damping as affine functions c₀ + c₁y₁ + c₂y₂ on the plane of a polygon.
pub(crate) struct SlipAndLoad<N> {
    /// The slip (m/s) at the origin, and the spin (rad/s).
    pub slip: ([N; 2], N),
    /// v_s².
    pub tolerance_squared: N,
    pub pressure: [N; 3],
    pub damping: [N; 3],
    pub one: N,
}

/// One edge of each polygon.
pub(crate) struct Edge<N> {
    pub from: [N; 2],
    /// The vector from the start of the edge to its end.
    pub span: [N; 2],
    pub length: N,
}

impl<N: Numbers> SlipAndLoad<N> {
    /// Returns u, 1/σ and g at a point.
    #[inline(always)]
    fn at(&self, [y1, y2]: [N; 2]) -> ([N; 2], N, N) {
        let ([v1, v2], spin) = self.slip;
        let (s1, s2) = (v1 - spin * y2, v2 + spin * y1);
        let inverse = self.one / (s1 * s1 + s2 * s2 + self.tolerance_squared).sqrt();
        let g = at(&self.pressure, [y1, y2]) * at(&self.damping, [y1, y2]);
        ([s1 * inverse, s2 * inverse], inverse, g)
    }

    /// Integrates over polygons, given their corners in counter-clockwise order. The first corner of a polygon with fewer corners than the
    /// others is repeated after its last one.
    ///
    /// Because u = s/σ and s is affine, ∫ m u dA for monomials up to degree 3 follows from ∫ m/σ dA for monomials up to degree 4.
    #[inline(always)]
    pub fn over_area<L: Lanes<Numbers = N>>(
        &self,
        lanes: L,
        corners: &[[N; 2]],
        rule: &TriangleRule,
    ) -> SlipMoments<N> {
        let (zero, half) = (lanes.splat(0.0), lanes.splat(0.5));
        let mut by_inverse = [zero; 15];
        let mut by_slip = [[zero; 6]; 3];
        let from = if corners.is_empty() {
            [zero; 2]
        } else {
            corners[0]
        };
        for last in 2..corners.len() {
            let b = difference(corners[last - 1], from);
            let c = difference(corners[last], from);
            let area = (b[0] * c[1] - b[1] * c[0]) * half;
            for [shares_b, shares_c, weights] in rule.pairs() {
                for point in 0..2 {
                    // If the number of points is odd, the second point of the last pair has a weight of zero.
                    if weights[point] == 0.0 {
                        continue;
                    }
                    let shares = [lanes.splat(shares_b[point]), lanes.splat(shares_c[point])];
                    let y = [
                        from[0] + b[0] * shares[0] + c[0] * shares[1],
                        from[1] + b[1] * shares[0] + c[1] * shares[1],
                    ];
                    let ([u1, u2], inverse, g) = self.at(y);
                    let density = area * lanes.splat(weights[point]) * inverse;
                    add_up_to_quartic(&mut by_inverse, density, y);
                    let factor = density * g;
                    let one = self.one;
                    add_up_to_quadratic(&mut by_slip[0], (u1 * u1 - one) * factor, y);
                    add_up_to_quadratic(&mut by_slip[1], u1 * u2 * factor, y);
                    add_up_to_quadratic(&mut by_slip[2], (u2 * u2 - one) * factor, y);
                }
            }
        }
        SlipMoments {
            direction: self.times_slip(&by_inverse),
            by_slip,
        }
    }

    /// Returns ∫ m s/σ dA, from ∫ m/σ dA.
    #[inline(always)]
    fn times_slip(&self, m: &[N; 15]) -> [[N; 10]; 2] {
        let ([v1, v2], spin) = self.slip;
        let mut products = [[m[0]; 10]; 2];
        for monomial in 0..10 {
            let (by_y1, by_y2) = (m[TIMES_Y1[monomial]], m[TIMES_Y2[monomial]]);
            products[0][monomial] = v1 * m[monomial] - spin * by_y2;
            products[1][monomial] = v2 * m[monomial] + spin * by_y1;
        }
        products
    }

    /// Returns ∫ g m u₁ dl and ∫ g m u₂ dl along an edge, for the monomials m = 1, y₁, y₂, y₁², y₁y₂, y₂².
    #[inline(always)]
    pub fn along<L: Lanes<Numbers = N>>(
        &self,
        lanes: L,
        edge: &Edge<N>,
        rule: &EdgeRule,
    ) -> [[N; 6]; 2] {
        let half = lanes.splat(0.5);
        let half_span = [edge.span[0] * half, edge.span[1] * half];
        let middle = [edge.from[0] + half_span[0], edge.from[1] + half_span[1]];
        let mut sums = [[lanes.splat(0.0); 6]; 2];
        for [nodes, weights] in rule.pairs() {
            for point in 0..2 {
                let node = lanes.splat(nodes[point]);
                let y = [
                    middle[0] + half_span[0] * node,
                    middle[1] + half_span[1] * node,
                ];
                let ([u1, u2], _, g) = self.at(y);
                let weight = edge.length * lanes.splat(weights[point]) * g;
                add_up_to_quadratic(&mut sums[0], u1 * weight, y);
                add_up_to_quadratic(&mut sums[1], u2 * weight, y);
            }
        }
        sums
    }
}

impl<N: Numbers> Edge<N> {
    #[inline(always)]
    pub fn between(from: [N; 2], to: [N; 2]) -> Self {
        let span = difference(to, from);
        Self {
            from,
            span,
            length: (span[0] * span[0] + span[1] * span[1]).sqrt(),
        }
    }
}

#[inline(always)]
fn difference<N: Numbers>(a: [N; 2], b: [N; 2]) -> [N; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

/// Returns the value of an affine function.
#[inline(always)]
pub(crate) fn at<N: Numbers>(f: &[N; 3], [y1, y2]: [N; 2]) -> N {
    f[0] + f[1] * y1 + f[2] * y2
}

/// Adds a number times 1, y₁, y₂, y₁², y₁y₂ and y₂² to the first six sums. Returns the last three products.
#[inline(always)]
pub(crate) fn add_up_to_quadratic<N: Numbers, const M: usize>(
    sums: &mut [N; M],
    value: N,
    [y1, y2]: [N; 2],
) -> [N; 3] {
    let (first, second) = (value * y1, value * y2);
    let quadratic = [first * y1, first * y2, second * y2];
    sums[0] = sums[0] + value;
    sums[1] = sums[1] + first;
    sums[2] = sums[2] + second;
    for (monomial, value) in quadratic.into_iter().enumerate() {
        sums[3 + monomial] = sums[3 + monomial] + value;
    }
    quadratic
}

/// Adds a number times the monomials up to degree 4: those of [`add_up_to_quadratic`], then y₁³, y₁²y₂, y₁y₂², y₂³, y₁⁴, y₁³y₂ and so on.
#[inline(always)]
fn add_up_to_quartic<N: Numbers>(sums: &mut [N; 15], value: N, [y1, y2]: [N; 2]) {
    let [squared, mixed, y22] = add_up_to_quadratic(sums, value, [y1, y2]);
    let cubic = [squared * y1, squared * y2, mixed * y2, y22 * y2];
    let [c1, c2, c3, c4] = cubic;
    let quartic = [c1 * y1, c1 * y2, c2 * y2, c3 * y2, c4 * y2];
    for (monomial, value) in cubic.into_iter().enumerate() {
        sums[6 + monomial] = sums[6 + monomial] + value;
    }
    for (monomial, value) in quartic.into_iter().enumerate() {
        sums[10 + monomial] = sums[10 + monomial] + value;
    }
}
