//! The integrals by quadrature, for a slip that hardly changes over the polygon.

use super::edge::Vector;
use super::rules::{EdgeRule, PointPair, TriangleRule};
use super::{Affine, FrictionIntegrand, Load, Slip, SlipMoments};
use crate::scalar::{Scalar, lift};
use wide::f64x2;

const ONE: f64x2 = f64x2::ONE;

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

/// [`FrictionIntegrand::moments`] by a rule.
pub(super) fn moments(loaded: &FrictionIntegrand, rule: &TriangleRule) -> SlipMoments {
    let mut sums = AreaSums::default();
    let field = Field::of(loaded);
    for triangle in Triangle::fan(loaded.corners) {
        for points in rule.pairs() {
            sums.add(&field, &triangle, points);
        }
    }
    let [u1, u2] = &sums.direction;
    let [t11, t12, t22] = &sums.by_slip;
    SlipMoments {
        direction: [totals(u1), totals(u2)],
        by_slip: [totals(t11), totals(t12), totals(t22)],
    }
}

fn totals<const N: usize>(sums: &[f64x2; N]) -> [f64; N] {
    sums.map(f64x2::reduce_add)
}

/// Two points, whose numbers a processor's instruction takes together.
type Points = [f64x2; 2];

/// What is integrated, with all numbers twice.
struct Field {
    at_origin: Points,
    spin: f64x2,
    tolerance_squared: f64x2,
    pressure: Affine<f64x2>,
    damping: Affine<f64x2>,
}

impl Field {
    fn of(loaded: &FrictionIntegrand) -> Self {
        let FrictionIntegrand { slip, load, .. } = loaded;
        Self {
            at_origin: slip.at_origin.map(f64x2::splat),
            spin: f64x2::splat(slip.spin),
            tolerance_squared: f64x2::splat(slip.tolerance * slip.tolerance),
            pressure: load.pressure.map(f64x2::splat),
            damping: load.damping.map(f64x2::splat),
        }
    }

    /// u, 1/σ and g: [`Slip::at`] and [`Load::at`] for two points at a time.
    #[inline]
    fn at(&self, [y1, y2]: Points) -> (Points, f64x2, f64x2) {
        let s1 = self.at_origin[0] - self.spin * y2;
        let s2 = self.at_origin[1] + self.spin * y1;
        let inverse = ONE / (s1 * s1 + s2 * s2 + self.tolerance_squared).sqrt();
        let [p, d] = [&self.pressure, &self.damping].map(|f| f[0] + f[1] * y1 + f[2] * y2);
        ([s1 * inverse, s2 * inverse], inverse, p * d)
    }
}

/// The sums over an area rule: ∫ m·u dA, and ∫ g·m·(u uᵀ − 1)/σ dA.
#[derive(Default)]
struct AreaSums {
    direction: [[f64x2; 10]; 2],
    by_slip: [[f64x2; 6]; 3],
}

impl AreaSums {
    #[inline]
    fn add(&mut self, field: &Field, triangle: &Triangle<f64>, [b, c, weight]: &PointPair) {
        let [b, c] = [*b, *c].map(f64x2::new);
        let y = [0, 1].map(|i| b * triangle.to[0][i] + c * triangle.to[1][i] + triangle.from[i]);
        let ([u1, u2], inverse, g) = field.at(y);
        let weight = f64x2::new(*weight) * triangle.area;
        add_up_to_cubic(&mut self.direction[0], u1 * weight, y);
        add_up_to_cubic(&mut self.direction[1], u2 * weight, y);
        let factor = weight * g * inverse;
        add_up_to_quadratic(&mut self.by_slip[0], (u1 * u1 - ONE) * factor, y);
        add_up_to_quadratic(&mut self.by_slip[1], u1 * u2 * factor, y);
        add_up_to_quadratic(&mut self.by_slip[2], (u2 * u2 - ONE) * factor, y);
    }
}

/// Adds a number times 1, y₁, y₂, y₁², y₁y₂ and y₂², and gives back the last three.
#[inline]
fn add_up_to_quadratic(sums: &mut [f64x2], value: f64x2, [y1, y2]: Points) -> [f64x2; 3] {
    let (first, second) = (value * y1, value * y2);
    let quadratic = [first * y1, first * y2, second * y2];
    sums[0] += value;
    sums[1] += first;
    sums[2] += second;
    for (sum, value) in sums[3..].iter_mut().zip(quadratic) {
        *sum += value;
    }
    quadratic
}

/// Adds a number times the ten monomials: those above, and the cubic ones.
#[inline]
fn add_up_to_cubic(sums: &mut [f64x2; 10], value: f64x2, y: Points) {
    let (low, cubic) = sums.split_at_mut(6);
    let [squared, mixed, other] = add_up_to_quadratic(low, value, y);
    let [y1, y2] = y;
    cubic[0] += squared * y1;
    cubic[1] += squared * y2;
    cubic[2] += mixed * y2;
    cubic[3] += other * y2;
}

/// [`FrictionIntegrand::flux`] by a rule.
pub(super) fn flux(
    loaded: &FrictionIntegrand,
    [from, to]: [Vector<f64>; 2],
    rule: &EdgeRule,
    factor: f64,
) -> [[f64; 6]; 2] {
    let field = Field::of(loaded);
    let half = [0, 1].map(|i| (to[i] - from[i]) * 0.5);
    let middle = [0, 1].map(|i| from[i] + half[i]);
    let scale = 2.0 * factor * (half[0] * half[0] + half[1] * half[1]).sqrt();
    let mut sums = [[f64x2::ZERO; 6]; 2];
    for [node, weight] in rule.pairs() {
        let node = f64x2::new(*node);
        let y = [0, 1].map(|i| node * half[i] + middle[i]);
        let ([u1, u2], _, load) = field.at(y);
        let weight = f64x2::new(*weight) * scale * load;
        add_up_to_quadratic(&mut sums[0], u1 * weight, y);
        add_up_to_quadratic(&mut sums[1], u2 * weight, y);
    }
    [totals(&sums[0]), totals(&sums[1])]
}
