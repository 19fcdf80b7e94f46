//! Triangles of contact polygons under a load, side by side, and the surface law over them.

use super::SurfaceLaw;
use super::friction::TriangleRule;
use super::loads::LoadedPolygon;
use crate::lanes::space::loaded;
use crate::lanes::{Lanes, Numbers, ROW, Row};

/// Up to eight triangles that are integrated by one rule.
pub(super) struct Triangles {
    /// The first corner, and the ways from there to the others (m).
    corners: [[Row; 2]; 3],
    pressure: [Row; 3],
    damping: [Row; 3],
    /// The slip at the origin, and the spin.
    slip: [Row; 3],
    /// Octet and place of the polygon of each.
    pub places: [[usize; 2]; ROW],
    pub len: usize,
    /// The highest rung of the ladder of rules that one of them needs.
    pub rung: usize,
}

impl Triangles {
    pub const NONE: Self = Self {
        corners: [[[0.0; ROW]; 2]; 3],
        pressure: [[0.0; ROW]; 3],
        damping: [[0.0; ROW]; 3],
        slip: [[0.0; ROW]; 3],
        places: [[0; 2]; ROW],
        len: 0,
        rung: 0,
    };

    /// Adds a triangle of a polygon, with these corners.
    #[inline]
    pub fn push(&mut self, [from, b, c]: [[f64; 2]; 3], polygon: &LoadedPolygon) {
        let place = self.len;
        let (loads, [_, of]) = (polygon.loads, polygon.place);
        let ways = [from, difference(b, from), difference(c, from)];
        for (rows, way) in self.corners.iter_mut().zip(ways) {
            rows[0][place] = way[0];
            rows[1][place] = way[1];
        }
        for k in 0..3 {
            self.pressure[k][place] = loads.pressure[k][of];
            self.damping[k][place] = loads.damping[k][of];
            self.slip[k][place] = loads.slip[k][of];
        }
        self.places[place] = polygon.place;
        self.len += 1;
        self.rung = self.rung.max(polygon.rung);
    }

    /// Makes triangles without an area of the places that are free.
    pub fn fill_up(&mut self) {
        for row in self.corners.iter_mut().flatten() {
            row[self.len..].fill(0.0);
        }
        let first = self.places[0];
        self.places[self.len..].fill(first);
    }
}

fn difference([a1, a2]: [f64; 2], [b1, b2]: [f64; 2]) -> [f64; 2] {
    [a1 - b1, a2 - b2]
}

/// ∫ g, ∫ g y₁, ∫ g y₂, ∫ g u₁, ∫ g u₂ and ∫ g (y₁u₂ − y₂u₁) dA, the load g being the damped pressure, and u the regularized
/// direction of slip.
#[inline(always)]
pub(super) fn integrals<L: Lanes>(
    lanes: L,
    triangles: &Triangles,
    first: usize,
    rule: &TriangleRule,
    law: &SurfaceLaw,
) -> [L::Numbers; 6] {
    let load = |row: &Row| lanes.load(row, first);
    let vector = |rows: &[Row; 3]| loaded(lanes, rows, first);
    let corner = |corner: usize| {
        let [y1, y2] = &triangles.corners[corner];
        [load(y1), load(y2)]
    };
    let [from, b, c] = [corner(0), corner(1), corner(2)];
    let [v1, v2, spin] = vector(&triangles.slip);
    let pressure = along(vector(&triangles.pressure), from, b, c);
    let damping = along(vector(&triangles.damping), from, b, c);
    let slip = [
        [v1 - spin * from[1], -(spin * b[1]), -(spin * c[1])],
        [v2 + spin * from[0], spin * b[0], spin * c[0]],
    ];
    let y = [[from[0], b[0], c[0]], [from[1], b[1], c[1]]];
    let tolerance = lanes.splat(law.slip_tolerance * law.slip_tolerance);
    let mut sums = [lanes.splat(0.0); 6];
    for [shares_b, shares_c, weights] in rule.pairs() {
        for point in 0..2 {
            let shares = [lanes.splat(shares_b[point]), lanes.splat(shares_c[point])];
            let weight = lanes.splat(weights[point]);
            let [y1, y2] = [at(y[0], shares), at(y[1], shares)];
            let [s1, s2] = [at(slip[0], shares), at(slip[1], shares)];
            let g = at(pressure, shares) * at(damping, shares) * weight;
            let density = g / (s1 * s1 + s2 * s2 + tolerance).sqrt();
            let (g1, g2) = (density * s1, density * s2);
            let parts = [g, g * y1, g * y2, g1, g2, y1 * g2 - y2 * g1];
            for k in 0..6 {
                sums[k] = sums[k] + parts[k];
            }
        }
    }
    let area = (b[0] * c[1] - b[1] * c[0]) * lanes.splat(0.5);
    for sum in &mut sums {
        *sum = *sum * area;
    }
    sums
}

/// An affine function of y as one of the shares of b and c: at the first corner, and what it gains.
#[inline(always)]
fn along<N: Numbers>([f0, f1, f2]: [N; 3], from: [N; 2], b: [N; 2], c: [N; 2]) -> [N; 3] {
    [
        f0 + f1 * from[0] + f2 * from[1],
        f1 * b[0] + f2 * b[1],
        f1 * c[0] + f2 * c[1],
    ]
}

#[inline(always)]
fn at<N: Numbers>([from, to_b, to_c]: [N; 3], [share_b, share_c]: [N; 2]) -> N {
    from + (to_b * share_b + to_c * share_c)
}
