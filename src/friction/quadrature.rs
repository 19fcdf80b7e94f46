//! The resultant by quadrature, for a slip that turns slowly over the polygon.

use super::edge::Vector;
use super::rules::TriangleRule;
use super::{Load, Slip};
use crate::scalar::{Scalar, lift};

/// A triangle of the fan about the first corner of a polygon. `to` are the vectors from this corner to the other two.
struct Triangle<T> {
    from: Vector<T>,
    to: [Vector<T>; 2],
    /// Signed area.
    area: T,
}

impl<T: Scalar> Triangle<T> {
    /// Returns the triangles of the first corner and each edge that does not contain it. Their areas are signed, so they add up to the area
    /// of the polygon even if round-off displaces its corners.
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
    /// Returns s at a point, and 1/σ.
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

/// Computes [`Slip::resultant`] by a quadrature rule.
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
