//! The integrals of slip and load over polygons side by side, one in each lane.

use super::edges::{CORNERS, Edges};
use crate::contact::friction::{EdgeRule, TriangleRule};
use crate::contact::traction_rates::flux::THREE_POINTS;
use crate::lanes::{Lanes, Numbers};

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

/// Integrals over the area of a polygon: those of [`SlipMoments`](crate::contact::friction::SlipMoments), and its moments.
pub(super) struct AreaSums<N> {
    pub one: [N; 10],
    pub direction: [[N; 10]; 2],
    pub by_slip: [[N; 6]; 3],
}

/// An edge of each polygon.
pub(super) struct Edge<N> {
    pub from: [N; 2],
    /// To its end.
    pub way: [N; 2],
    pub length: N,
}

impl<N: Numbers> Field<N> {
    /// u, 1/σ and g.
    #[inline(always)]
    fn at(&self, [y1, y2]: [N; 2]) -> ([N; 2], N, N) {
        let s1 = self.slip[0] - self.spin * y2;
        let s2 = self.slip[1] + self.spin * y1;
        let inverse = self.one / (s1 * s1 + s2 * s2 + self.tolerance_squared).sqrt();
        let g = at(&self.pressure, [y1, y2]) * at(&self.damping, [y1, y2]);
        ([s1 * inverse, s2 * inverse], inverse, g)
    }

    #[inline(always)]
    pub fn over_area<L: Lanes<Numbers = N>>(
        &self,
        lanes: L,
        (edges, first): (&Edges, usize),
        rule: &TriangleRule,
    ) -> AreaSums<N> {
        let zero = lanes.splat(0.0);
        let half = lanes.splat(0.5);
        let mut sums = AreaSums {
            one: [zero; 10],
            direction: [[zero; 10]; 2],
            by_slip: [[zero; 6]; 3],
        };
        let from = corner(lanes, edges, 0, first);
        let mut next = Edge::between(from, corner(lanes, edges, 1, first)).way;
        for last in 2..edges.most(first, L::COUNT) {
            let [b, c] = [
                next,
                Edge::between(from, corner(lanes, edges, last, first)).way,
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
                    let weight = area * lanes.splat(weights[point]);
                    self.add(&mut sums, y, weight);
                }
            }
        }
        sums
    }

    #[inline(always)]
    fn add(&self, sums: &mut AreaSums<N>, y: [N; 2], weight: N) {
        let ([u1, u2], inverse, g) = self.at(y);
        add_up_to_cubic(&mut sums.one, weight, y);
        add_up_to_cubic(&mut sums.direction[0], u1 * weight, y);
        add_up_to_cubic(&mut sums.direction[1], u2 * weight, y);
        let factor = weight * g * inverse;
        add_up_to_quadratic(&mut sums.by_slip[0], (u1 * u1 - self.one) * factor, y);
        add_up_to_quadratic(&mut sums.by_slip[1], u1 * u2 * factor, y);
        add_up_to_quadratic(&mut sums.by_slip[2], (u2 * u2 - self.one) * factor, y);
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
    pub fn of<L: Lanes<Numbers = N>>(lanes: L, edges: &Edges, edge: usize, first: usize) -> Self {
        let end = corner(lanes, edges, edge + 1, first);
        Self::between(corner(lanes, edges, edge, first), end)
    }
}

#[inline(always)]
fn corner<L: Lanes>(lanes: L, edges: &Edges, corner: usize, first: usize) -> [L::Numbers; 2] {
    let [y1, y2] = &edges.corners[corner.min(CORNERS)];
    [lanes.load(y1, first), lanes.load(y2, first)]
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

/// Adds a number times the ten monomials: those above, and the cubic ones.
#[inline(always)]
fn add_up_to_cubic<N: Numbers>(sums: &mut [N; 10], value: N, [y1, y2]: [N; 2]) {
    let [squared, mixed, other] = add_up_to_quadratic(sums, value, [y1, y2]);
    sums[6] = sums[6] + squared * y1;
    sums[7] = sums[7] + squared * y2;
    sums[8] = sums[8] + mixed * y2;
    sums[9] = sums[9] + other * y2;
}
