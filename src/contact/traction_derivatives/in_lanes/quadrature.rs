//! The integrals of slip and load over polygons side by side, one in each lane.

use super::corners::Corners;
use crate::contact::traction_derivatives::area::LawOnPlane;
use crate::contact::traction_derivatives::flux::THREE_POINTS;
use crate::friction::{EdgeRule, SlipMoments, TriangleRule};
use crate::geometry::{PER_TRIANGLE, add_triangle};
use crate::lanes::{Lanes, Numbers};

/// Where the monomials up to cubic ones times y₁, and times y₂, are among those up to quartic ones (see [`add_up_to_quartic`]).
const TIMES_Y1: [usize; 10] = [1, 3, 4, 6, 7, 8, 10, 11, 12, 13];
const TIMES_Y2: [usize; 10] = [2, 4, 5, 7, 8, 9, 11, 12, 13, 14];

/// What slips and presses on a polygon, as affine functions c₀ + c₁y₁ + c₂y₂ on its plane, and the rules by which that is
/// integrated.
pub(super) struct Field<N> {
    /// The slip at the origin, and the spin.
    pub slip: [N; 2],
    pub spin: N,
    /// v_s².
    pub tolerance_squared: N,
    pub pressure: [N; 3],
    pub damping: [N; 3],
    pub one: N,
}

/// An edge of each polygon.
pub(super) struct Edge<N> {
    pub from: [N; 2],
    /// To its end.
    pub way: [N; 2],
    pub length: N,
}

impl<N: Numbers> Field<N> {
    #[inline(always)]
    pub fn of<L: Lanes<Numbers = N>>(lanes: L, law: &LawOnPlane<N>, slip_tolerance: f64) -> Self {
        let (slip, spin) = law.motion.slip();
        Self {
            slip,
            spin,
            tolerance_squared: lanes.splat(slip_tolerance * slip_tolerance),
            pressure: law.pressure,
            damping: law.damping,
            one: lanes.splat(1.0),
        }
    }

    /// u, 1/σ and g.
    #[inline(always)]
    fn at(&self, [y1, y2]: [N; 2]) -> ([N; 2], N, N) {
        let s1 = self.slip[0] - self.spin * y2;
        let s2 = self.slip[1] + self.spin * y1;
        let inverse = self.one / (s1 * s1 + s2 * s2 + self.tolerance_squared).sqrt();
        let g = at(&self.pressure, [y1, y2]) * at(&self.damping, [y1, y2]);
        ([s1 * inverse, s2 * inverse], inverse, g)
    }

    /// By a rule. As the slip is affine, ∫ m u dA follows from ∫ m/σ dA by monomials of one degree more.
    #[inline(always)]
    pub fn over_area<L: Lanes<Numbers = N>>(
        &self,
        lanes: L,
        (corners, first): (&Corners, usize),
        rule: &TriangleRule,
    ) -> SlipMoments<N> {
        let (zero, half) = (lanes.splat(0.0), lanes.splat(0.5));
        let mut by_inverse = [zero; 15];
        let mut by_slip = [[zero; 6]; 3];
        let from = corners.at(lanes, 0, first);
        let mut next = Edge::between(from, corners.at(lanes, 1, first)).way;
        for last in 2..corners.most::<L>(first) {
            let [b, c] = [
                next,
                Edge::between(from, corners.at(lanes, last, first)).way,
            ];
            next = c;
            let area = (b[0] * c[1] - b[1] * c[0]) * half;
            for [shares_b, shares_c, weights] in rule.pairs() {
                for point in 0..2 {
                    // The place that an odd number of points leaves.
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

    /// ∫ m s/σ dA from ∫ m/σ dA.
    #[inline(always)]
    fn times_slip(&self, m: &[N; 15]) -> [[N; 10]; 2] {
        let mut products = [[m[0]; 10]; 2];
        for place in 0..10 {
            let (by_y1, by_y2) = (m[TIMES_Y1[place]], m[TIMES_Y2[place]]);
            products[0][place] = self.slip[0] * m[place] - self.spin * by_y2;
            products[1][place] = self.slip[1] * m[place] + self.spin * by_y1;
        }
        products
    }

    /// ∫ g m u₁ dl and ∫ g m u₂ dl along an edge for the monomials m = 1, y₁, y₂, y₁², y₁y₂, y₂².
    #[inline(always)]
    pub fn along<L: Lanes<Numbers = N>>(
        &self,
        lanes: L,
        edge: &Edge<N>,
        rule: &EdgeRule,
    ) -> [[N; 6]; 2] {
        let half = lanes.splat(0.5);
        let half_way = [edge.way[0] * half, edge.way[1] * half];
        let middle = [edge.from[0] + half_way[0], edge.from[1] + half_way[1]];
        let mut sums = [[lanes.splat(0.0); 6]; 2];
        for [nodes, weights] in rule.pairs() {
            for point in 0..2 {
                let node = lanes.splat(nodes[point]);
                let y = [
                    middle[0] + half_way[0] * node,
                    middle[1] + half_way[1] * node,
                ];
                let ([u1, u2], _, g) = self.at(y);
                let weight = edge.length * lanes.splat(weights[point]) * g;
                add_up_to_quadratic(&mut sums[0], u1 * weight, y);
                add_up_to_quadratic(&mut sums[1], u2 * weight, y);
            }
        }
        sums
    }

    /// ∫ p f m dl along an edge for an affine f and the same monomials.
    #[inline(always)]
    pub fn pressed_along<L: Lanes<Numbers = N>>(
        &self,
        lanes: L,
        edge: &Edge<N>,
        f: &[N; 3],
    ) -> [N; 6] {
        let mut sums = [lanes.splat(0.0); 6];
        for (share, weight) in THREE_POINTS {
            let share = lanes.splat(share);
            let y = [
                edge.from[0] + edge.way[0] * share,
                edge.from[1] + edge.way[1] * share,
            ];
            let value = at(&self.pressure, y) * at(f, y) * (edge.length * lanes.splat(weight));
            add_up_to_quadratic(&mut sums, value, y);
        }
        sums
    }
}

impl<N: Numbers> Edge<N> {
    #[inline(always)]
    fn between(from: [N; 2], to: [N; 2]) -> Self {
        let way = [to[0] - from[0], to[1] - from[1]];
        Self {
            from,
            way,
            length: (way[0] * way[0] + way[1] * way[1]).sqrt(),
        }
    }

    /// The edge from a corner to the next.
    #[inline(always)]
    pub fn of<L: Lanes<Numbers = N>>(
        lanes: L,
        corners: &Corners,
        edge: usize,
        first: usize,
    ) -> Self {
        let end = corners.at(lanes, edge + 1, first);
        Self::between(corners.at(lanes, edge, first), end)
    }
}

/// The value of an affine function.
#[inline(always)]
fn at<N: Numbers>(f: &[N; 3], [y1, y2]: [N; 2]) -> N {
    f[0] + f[1] * y1 + f[2] * y2
}

/// Adds a number times 1, y₁, y₂, y₁², y₁y₂ and y₂², and gives back the last three.
#[inline(always)]
fn add_up_to_quadratic<N: Numbers, const M: usize>(
    sums: &mut [N; M],
    value: N,
    [y1, y2]: [N; 2],
) -> [N; 3] {
    let (first, second) = (value * y1, value * y2);
    let quadratic = [first * y1, first * y2, second * y2];
    sums[0] = sums[0] + value;
    sums[1] = sums[1] + first;
    sums[2] = sums[2] + second;
    for (place, value) in quadratic.into_iter().enumerate() {
        sums[3 + place] = sums[3 + place] + value;
    }
    quadratic
}

/// Adds a number times the monomials up to quartic ones: those above, then y₁³, y₁²y₂, y₁y₂², y₂³, y₁⁴, y₁³y₂ and so on.
#[inline(always)]
fn add_up_to_quartic<N: Numbers>(sums: &mut [N; 15], value: N, [y1, y2]: [N; 2]) {
    let [squared, mixed, other] = add_up_to_quadratic(sums, value, [y1, y2]);
    let cubic = [squared * y1, squared * y2, mixed * y2, other * y2];
    let [c1, c2, c3, c4] = cubic;
    let quartic = [c1 * y1, c1 * y2, c2 * y2, c3 * y2, c4 * y2];
    for (place, value) in cubic.into_iter().enumerate() {
        sums[6 + place] = sums[6 + place] + value;
    }
    for (place, value) in quartic.into_iter().enumerate() {
        sums[10 + place] = sums[10 + place] + value;
    }
}

/// The moments of polygons by the ten monomials up to cubic ones: sums over the triangles of the origin and each edge, exactly 0
/// where an edge is a point.
#[inline(always)]
pub(super) fn moments<L: Lanes>(lanes: L, (corners, first): (&Corners, usize)) -> [L::Numbers; 10] {
    let mut sums = [lanes.splat(0.0); 10];
    let constants = [lanes.splat(0.5), lanes.splat(1.0 / 3.0)];
    let mut next = corners.at(lanes, 0, first);
    for end in 1..=corners.most::<L>(first) {
        let (from, to) = (next, corners.at(lanes, end, first));
        next = to;
        add_triangle(&mut sums, from, to, constants);
    }
    for (sum, factor) in sums.iter_mut().zip(PER_TRIANGLE) {
        *sum = *sum * lanes.splat(factor);
    }
    sums
}
