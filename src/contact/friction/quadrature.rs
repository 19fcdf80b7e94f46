//! The integrals by quadrature, for a slip that hardly changes over the polygon.

use super::edge::Vector;
use super::rules::{EdgeRule, TriangleRule};
use super::{Load, Rung, Slip, SlipMoments, transposed};
use crate::scalar::{Scalar, lift};

/// A triangle of the fan from the polygon's first corner.
struct Triangle<T> {
    from: Vector<T>,
    to: [Vector<T>; 2],
    /// Its area, signed.
    area: T,
}

impl<T: Scalar> Triangle<T> {
    /// The triangles from the first corner to all edges. With signed areas they add up to the polygon wherever round-off
    /// put its corners.
    fn fan(corners: &[Vector<T>]) -> impl Iterator<Item = Self> {
        corners.windows(2).skip(1).map(|pair| {
            let from = corners[0];
            let to = [pair[0], pair[1]].map(|y| [y[0] - from[0], y[1] - from[1]]);
            let area = (to[0][0] * to[1][1] - to[0][1] * to[1][0]) * 0.5;
            Self { from, to, area }
        })
    }

    #[inline]
    fn at(&self, b: f64, c: f64) -> Vector<T> {
        [0, 1].map(|i| self.from[i] + self.to[0][i] * b + self.to[1][i] * c)
    }
}

impl<T: Scalar> Slip<T> {
    /// s at a point, and 1/σ.
    #[inline]
    fn at(&self, [y1, y2]: Vector<T>) -> (Vector<T>, T) {
        let s = [
            self.at_origin[0] - self.spin * y2,
            self.at_origin[1] + self.spin * y1,
        ];
        let squared = s[0] * s[0] + s[1] * s[1] + self.tolerance * self.tolerance;
        (s, squared.sqrt().recip())
    }
}

/// [`Slip::resultant`] by a rule.
pub(super) fn resultant<T: Scalar>(
    slip: &Slip<T>,
    corners: &[Vector<T>],
    load: &Load<T>,
    rule: &TriangleRule,
) -> [T; 3] {
    let mut total = [lift::<T>(0.0); 3];
    for triangle in Triangle::fan(corners) {
        let mut sums = [[lift::<T>(0.0); 2]; 3];
        for [b, c, weight] in rule.pairs() {
            for lane in 0..2 {
                let y = triangle.at(b[lane], c[lane]);
                let (s, inverse) = slip.at(y);
                let density = load.at(y) * inverse * weight[lane];
                sums[0][lane] += density * s[0];
                sums[1][lane] += density * s[1];
                sums[2][lane] += density * (y[0] * s[1] - y[1] * s[0]);
            }
        }
        for (total, sum) in total.iter_mut().zip(sums) {
            *total += (sum[0] + sum[1]) * triangle.area;
        }
    }
    total
}

/// [`Slip::moments`] by the rules of a rung.
pub(super) fn moments(
    slip: &Slip<f64>,
    corners: &[Vector<f64>],
    load: &Load<f64>,
    rung: &Rung,
) -> SlipMoments {
    let mut area = AreaSums::default();
    for triangle in Triangle::fan(corners) {
        for [b, c, weight] in rung.slopes.pairs() {
            let points = [0, 1].map(|lane| {
                let y = triangle.at(b[lane], c[lane]);
                PointValues::new(slip, load, y, weight[lane] * triangle.area)
            });
            area.add(&points);
        }
    }
    let mut moments = SlipMoments::zero();
    moments.direction = transposed(&area.direction, 1.0);
    moments.by_slip = transposed(&area.by_slip, 1.0);
    let following = corners.iter().cycle().skip(1);
    for ((edge, a), b) in moments.edges.iter_mut().zip(corners).zip(following) {
        *edge = edge_flux(slip, load, [*a, *b], rung.edge);
    }
    moments
}

/// The sums over an area rule: ∫ m·u dA, and ∫ g·m·(u uᵀ − 1)/σ dA.
#[derive(Default)]
struct AreaSums {
    direction: [[f64; 10]; 2],
    by_slip: [[f64; 6]; 3],
}

/// What a point of a rule contributes, without the monomials.
struct PointValues {
    monomials: [f64; 10],
    direction: [f64; 2],
    by_slip: [f64; 3],
}

impl PointValues {
    #[inline]
    fn new(slip: &Slip<f64>, load: &Load<f64>, y: Vector<f64>, weight: f64) -> Self {
        let (s, inverse) = slip.at(y);
        let u = s.map(|component| component * inverse);
        let factor = weight * load.at(y) * inverse;
        Self {
            monomials: monomials(y),
            direction: u.map(|component| weight * component),
            by_slip: [
                (u[0] * u[0] - 1.0) * factor,
                u[0] * u[1] * factor,
                (u[1] * u[1] - 1.0) * factor,
            ],
        }
    }
}

impl AreaSums {
    #[inline]
    fn add(&mut self, [first, second]: &[PointValues; 2]) {
        for (j, sums) in self.direction.iter_mut().enumerate() {
            for (k, sum) in sums.iter_mut().enumerate() {
                *sum += first.direction[j] * first.monomials[k]
                    + second.direction[j] * second.monomials[k];
            }
        }
        for (j, sums) in self.by_slip.iter_mut().enumerate() {
            for (k, sum) in sums.iter_mut().enumerate() {
                *sum +=
                    first.by_slip[j] * first.monomials[k] + second.by_slip[j] * second.monomials[k];
            }
        }
    }
}

/// ∫ g·m·u dl for the first six monomials along the edge between two corners.
fn edge_flux(
    slip: &Slip<f64>,
    load: &Load<f64>,
    [a, b]: [Vector<f64>; 2],
    rule: &EdgeRule,
) -> [[f64; 2]; 6] {
    let half = [0, 1].map(|i| (b[i] - a[i]) * 0.5);
    let middle = [0, 1].map(|i| a[i] + half[i]);
    let mut sums = [[0.0; 6]; 2];
    for [t, weight] in rule.points() {
        let y = [0, 1].map(|i| middle[i] + half[i] * t);
        let (s, inverse) = slip.at(y);
        let factor = weight * load.at(y) * inverse;
        let monomials = monomials(y);
        for (sums, component) in sums.iter_mut().zip(s) {
            for (sum, monomial) in sums.iter_mut().zip(monomials) {
                *sum += factor * component * monomial;
            }
        }
    }
    transposed(&sums, 2.0 * half[0].hypot(half[1]))
}

/// 1, y₁, y₂, y₁², y₁y₂, y₂², y₁³, y₁²y₂, y₁y₂², y₂³.
#[inline]
fn monomials([y1, y2]: Vector<f64>) -> [f64; 10] {
    let (y11, y12, y22) = (y1 * y1, y1 * y2, y2 * y2);
    [
        1.0,
        y1,
        y2,
        y11,
        y12,
        y22,
        y11 * y1,
        y11 * y2,
        y1 * y22,
        y22 * y2,
    ]
}
