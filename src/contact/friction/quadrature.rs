//! The integrals by quadrature, for a slip that hardly changes over the polygon.

use super::edge::Vector;
use super::rules::{EdgeRule, PointPair, TriangleRule};
use super::{Load, Rung, Slip, SlipMoments};
use crate::scalar::{Scalar, lift};
use std::ops::AddAssign;

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
        for points in rung.slopes.pairs() {
            area.add(slip, load, &triangle, points);
        }
    }
    let mut moments = SlipMoments::zero();
    for (moments, sums) in moments.direction.iter_mut().zip(&area.direction) {
        for (moment, sum) in moments.iter_mut().zip(sums) {
            *moment = sum.sum();
        }
    }
    for (moments, sums) in moments.by_slip.iter_mut().zip(&area.by_slip) {
        for (moment, sum) in moments.iter_mut().zip(sums) {
            *moment = sum.sum();
        }
    }
    let following = corners.iter().cycle().skip(1);
    for ((edge, a), b) in moments.edges.iter_mut().zip(corners).zip(following) {
        *edge = edge_flux(slip, load, [*a, *b], rung.edge);
    }
    moments
}

/// The same number at two points of a rule, which a processor's instruction takes together.
#[derive(Debug, Clone, Copy, Default)]
struct Lanes([f64; 2]);

impl Lanes {
    #[inline]
    fn of(value: impl Fn(usize) -> f64) -> Self {
        Self([value(0), value(1)])
    }

    #[inline]
    fn times(self, other: Self) -> Self {
        Self::of(|lane| self.0[lane] * other.0[lane])
    }

    #[inline]
    fn sum(self) -> f64 {
        self.0[0] + self.0[1]
    }
}

impl AddAssign for Lanes {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        *self = Self::of(|lane| self.0[lane] + other.0[lane]);
    }
}

/// The sums over an area rule: ∫ m·u dA, and ∫ g·m·(u uᵀ − 1)/σ dA.
#[derive(Default)]
struct AreaSums {
    direction: [[Lanes; 10]; 2],
    by_slip: [[Lanes; 6]; 3],
}

impl AreaSums {
    #[inline]
    fn add(
        &mut self,
        slip: &Slip<f64>,
        load: &Load<f64>,
        triangle: &Triangle<f64>,
        [b, c, weight]: &PointPair,
    ) {
        let y = [0, 1].map(|lane| triangle.at(b[lane], c[lane]));
        let at = [0, 1].map(|lane| slip.at(y[lane]));
        let u = [0, 1].map(|axis| Lanes::of(|lane| at[lane].0[axis] * at[lane].1));
        let weight = Lanes::of(|lane| weight[lane] * triangle.area);
        let factor = Lanes::of(|lane| weight.0[lane] * load.at(y[lane]) * at[lane].1);
        let y = [0, 1].map(|axis| Lanes::of(|lane| y[lane][axis]));
        for (sums, u) in self.direction.iter_mut().zip(&u) {
            add_up(sums, &up_to_cubic(u.times(weight), y));
        }
        let less_one = |square: Lanes| Lanes::of(|lane| square.0[lane] - 1.0);
        let bent = [
            less_one(u[0].times(u[0])),
            u[0].times(u[1]),
            less_one(u[1].times(u[1])),
        ];
        for (sums, bent) in self.by_slip.iter_mut().zip(&bent) {
            add_up(sums, &up_to_quadratic(bent.times(factor), y));
        }
    }
}

#[inline]
fn add_up<const N: usize>(sums: &mut [Lanes; N], values: &[Lanes; N]) {
    for (sum, value) in sums.iter_mut().zip(values) {
        *sum += *value;
    }
}

/// A number times 1, y₁, y₂, y₁², y₁y₂ and y₂².
#[inline]
fn up_to_quadratic(value: Lanes, [y1, y2]: [Lanes; 2]) -> [Lanes; 6] {
    let (first, second) = (value.times(y1), value.times(y2));
    [
        value,
        first,
        second,
        first.times(y1),
        first.times(y2),
        second.times(y2),
    ]
}

/// A number times the ten monomials.
#[inline]
fn up_to_cubic(value: Lanes, y: [Lanes; 2]) -> [Lanes; 10] {
    let [y1, y2] = y;
    let [value, first, second, a, b, c] = up_to_quadratic(value, y);
    [
        value,
        first,
        second,
        a,
        b,
        c,
        a.times(y1),
        a.times(y2),
        b.times(y2),
        c.times(y2),
    ]
}

/// ∫ g·m·u dl for the first six monomials along the edge between two corners.
#[inline]
fn edge_flux(
    slip: &Slip<f64>,
    load: &Load<f64>,
    [a, b]: [Vector<f64>; 2],
    rule: &EdgeRule,
) -> [[f64; 6]; 2] {
    let half = [0, 1].map(|i| (b[i] - a[i]) * 0.5);
    let middle = [0, 1].map(|i| a[i] + half[i]);
    let mut sums = [[Lanes::default(); 6]; 2];
    for [t, weight] in rule.pairs() {
        let y = [0, 1].map(|lane| [0, 1].map(|i| middle[i] + half[i] * t[lane]));
        let at = [0, 1].map(|lane| slip.at(y[lane]));
        let factor = Lanes::of(|lane| weight[lane] * load.at(y[lane]) * at[lane].1);
        let axes = [0, 1].map(|axis| Lanes::of(|lane| y[lane][axis]));
        for (axis, sums) in sums.iter_mut().enumerate() {
            let component = Lanes::of(|lane| at[lane].0[axis]).times(factor);
            add_up(sums, &up_to_quadratic(component, axes));
        }
    }
    let length = 2.0 * (half[0] * half[0] + half[1] * half[1]).sqrt();
    sums.map(|sums| sums.map(|sum| sum.sum() * length))
}
