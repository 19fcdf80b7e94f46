//! Loaded triangles of contact polygons as a structure of arrays, and integrals of the surface law over the triangles.

use super::SurfaceLaw;
use super::slip_fields::SlipFields;
use crate::friction::TriangleRule;
use crate::lanes::space::loaded;
use crate::lanes::{Lanes, Numbers, ROW, Row};
use crate::narrow_phase::Octet;

/// Up to eight triangles that are integrated by one rule, each with a corner at the origin of its plane.
pub(super) struct Triangles {
    /// The other two corners (m).
    corners: [[Row; 2]; 2],
    pressure: [Row; 3],
    damping: [Row; 3],
    /// The slip at the origin, and the spin.
    slip: [Row; 3],
    /// Octet and index of each triangle's polygon.
    pub indices: [[usize; 2]; ROW],
    pub len: usize,
    /// The highest level of quadrature rules that a triangle needs.
    pub level: usize,
}

impl Triangles {
    pub const NONE: Self = Self {
        corners: [[[0.0; ROW]; 2]; 2],
        pressure: [[0.0; ROW]; 3],
        damping: [[0.0; ROW]; 3],
        slip: [[0.0; ROW]; 3],
        indices: [[0; 2]; ROW],
        len: 0,
        level: 0,
    };

    /// Adds the triangle of the origin and the edge in a slot. The polygon is at this index in the octet with this number.
    #[inline]
    pub fn push(
        &mut self,
        (octet, fields): (&Octet, &SlipFields),
        [number, index]: [usize; 2],
        slot: usize,
    ) {
        let free = self.len;
        for (rows, of_slots) in self.corners.iter_mut().zip([&octet.corners, &octet.ends]) {
            rows[0][free] = of_slots[slot][0][index];
            rows[1][free] = of_slots[slot][1][index];
        }
        for k in 0..3 {
            self.pressure[k][free] = fields.pressure[k][index];
            self.damping[k][free] = fields.damping[k][index];
            self.slip[k][free] = fields.slip[k][index];
        }
        self.indices[free] = [number, index];
        self.len += 1;
        self.level = self.level.max(fields.level(index));
    }

    /// Fills the free slots with triangles without an area.
    pub fn fill_up(&mut self) {
        for row in self.corners.iter_mut().flatten() {
            row[self.len..].fill(0.0);
        }
        let first = self.indices[0];
        self.indices[self.len..].fill(first);
    }
}

/// Returns ∫ g, ∫ g y₁, ∫ g y₂, ∫ g u₁, ∫ g u₂ and ∫ g (y₁u₂ − y₂u₁) dA. The load g is the damped pressure, and u is the regularized
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
    let [b, c] = [corner(0), corner(1)];
    let [v1, v2, spin] = vector(&triangles.slip);
    let pressure = along(vector(&triangles.pressure), b, c);
    let damping = along(vector(&triangles.damping), b, c);
    let tolerance = lanes.splat(law.slip_tolerance * law.slip_tolerance);
    let mut sums = [lanes.splat(0.0); 6];
    for [shares_b, shares_c, weights] in rule.pairs() {
        for point in 0..2 {
            let shares = [lanes.splat(shares_b[point]), lanes.splat(shares_c[point])];
            let weight = lanes.splat(weights[point]);
            let [y1, y2] = [mixed(b[0], c[0], shares), mixed(b[1], c[1], shares)];
            let [s1, s2] = [v1 - spin * y2, v2 + spin * y1];
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

/// Converts an affine function of y to one of the shares of b and c: its value at the origin, and its increases to b and c.
#[inline(always)]
fn along<N: Numbers>([f0, f1, f2]: [N; 3], b: [N; 2], c: [N; 2]) -> [N; 3] {
    [f0, f1 * b[0] + f2 * b[1], f1 * c[0] + f2 * c[1]]
}

#[inline(always)]
fn at<N: Numbers>([at_origin, to_b, to_c]: [N; 3], shares: [N; 2]) -> N {
    at_origin + mixed(to_b, to_c, shares)
}

#[inline(always)]
fn mixed<N: Numbers>(b: N, c: N, [share_b, share_c]: [N; 2]) -> N {
    b * share_b + c * share_c
}
