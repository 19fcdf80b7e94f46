//! Regularized Coulomb friction over a plane convex polygon, exact to round-off.
//!
//! A rigid motion makes the surfaces slip by an affine velocity s, and friction pulls along u = s/√(s·s + v_s²).
//! Where u hardly changes over the polygon, quadrature of a high degree is exact; where the center of rotation is near
//! and u turns quickly, the integrals have a closed form.

#![expect(dead_code, reason = "the surface law does not use it yet")]

mod closed_form;
mod closed_moments;
mod edge;
mod quadrature;
mod rules;

use crate::geometry::POLYGON_CAPACITY;
use crate::scalar::{Scalar, carries_derivatives, real_part};
use rules::{EdgeRule, TriangleRule};

/// Room for the corners of a clipped polygon in the plane.
pub(super) const PLANE_CAPACITY: usize = POLYGON_CAPACITY + 1;

/// An affine function in the plane, c₀ + c₁y₁ + c₂y₂.
pub(super) type Affine<T> = [T; 3];

/// The coefficients of 1, y₁, y₂, y₁², y₁y₂, y₂².
type Quadratic<T> = [T; 6];

/// The velocity (m/s) by which two surfaces slip along a plane, s(y) = at_origin + spin·(−y₂, y₁), and the slip
/// tolerance v_s > 0 (m/s). The origin is a point near the polygon.
///
/// The regularized direction of slip is u = s/σ with σ = √(s·s + v_s²).
#[derive(Debug, Clone, Copy)]
pub(super) struct Slip<T> {
    pub at_origin: [T; 2],
    pub spin: T,
    pub tolerance: f64,
}

/// Integrals of the regularized direction of slip u, in plane coordinates, with the load g = pressure·damping.
pub(super) struct SlipMoments {
    /// ∫ m·u dA for the monomials m = 1, y₁, y₂, y₁², y₁y₂, y₂², y₁³, y₁²y₂, y₁y₂², y₂³.
    pub direction: [[f64; 2]; 10],
    /// ∫ g·m·(u uᵀ − 1)/σ dA for the first six monomials: entries 11, 12 and 22. Minus the derivative by the slip of
    /// ∫ g·m·u dA.
    pub by_slip: [[f64; 3]; 6],
    /// ∫ g·m·u dl for the first six monomials, along the edge from each corner to the next.
    pub edges: [[[f64; 2]; 6]; PLANE_CAPACITY],
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

/// What integrates a slip that changes by less than a fraction of σ.
struct Rung {
    /// Where θ = |w|·L/σ is below: w the spin, σ at the mean of the corners, L the distance of the farthest from it.
    below: f64,
    /// For values.
    value: &'static TriangleRule,
    /// For derivatives, which converge one order later.
    slopes: &'static TriangleRule,
    edge: &'static EdgeRule,
}

const LADDER: [Rung; 4] = [
    Rung {
        below: 1e-3,
        value: &rules::TRIANGLE_5,
        slopes: &rules::TRIANGLE_6,
        edge: &rules::EDGE_4,
    },
    Rung {
        below: 0.03,
        value: &rules::TRIANGLE_8,
        slopes: &rules::TRIANGLE_8,
        edge: &rules::EDGE_5,
    },
    Rung {
        below: 0.2,
        value: &rules::TRIANGLE_12,
        slopes: &rules::TRIANGLE_12,
        edge: &rules::EDGE_8,
    },
    Rung {
        below: 0.5,
        value: &rules::TRIANGLE_17,
        slopes: &rules::TRIANGLE_17,
        edge: &rules::EDGE_10,
    },
];

/// How the integrals over a polygon are taken.
enum Method {
    Rule(&'static Rung),
    /// With the size of the polygon (m).
    ClosedForm(f64),
}

impl<T: Scalar> Slip<T> {
    /// ∫ g·u dA, and ∫ g·(y₁u₂ − y₂u₁) dA, with g = pressure·damping; corners counter-clockwise.
    pub fn resultant(
        &self,
        corners: &[[T; 2]],
        pressure: &Affine<T>,
        damping: &Affine<T>,
    ) -> [T; 3] {
        let load = Load { pressure, damping };
        match self.method(corners) {
            Method::Rule(rung) => {
                let rule = if carries_derivatives::<T>() {
                    rung.slopes
                } else {
                    rung.value
                };
                quadrature::resultant(self, corners, &load, rule)
            }
            Method::ClosedForm(size) => closed_form::resultant(self, corners, &load, size),
        }
    }

    fn method(&self, corners: &[[T; 2]]) -> Method {
        let real = |y: &[T; 2]| y.map(real_part);
        let sum = corners
            .iter()
            .map(real)
            .fold([0.0; 2], |sum, y| [sum[0] + y[0], sum[1] + y[1]]);
        let mean = sum.map(|component| component / corners.len().max(1) as f64);
        let squared = |y: [f64; 2]| (y[0] - mean[0]).powi(2) + (y[1] - mean[1]).powi(2);
        let size_squared = corners.iter().map(|y| squared(real(y))).fold(0.0, f64::max);
        let spin = real_part(self.spin);
        let slip = [
            real_part(self.at_origin[0]) - spin * mean[1],
            real_part(self.at_origin[1]) + spin * mean[0],
        ];
        let speed_squared = slip[0].powi(2) + slip[1].powi(2) + self.tolerance.powi(2);
        let change_squared = spin * spin * size_squared;
        let is_above = |rung: &&Rung| change_squared < rung.below.powi(2) * speed_squared;
        match LADDER.iter().find(is_above) {
            Some(rung) => Method::Rule(rung),
            None => Method::ClosedForm(size_squared.sqrt()),
        }
    }
}

impl Slip<f64> {
    /// What the derivatives of [`Self::resultant`] are made of. Corners counter-clockwise.
    pub fn moments(
        &self,
        corners: &[[f64; 2]],
        pressure: &Affine<f64>,
        damping: &Affine<f64>,
    ) -> SlipMoments {
        let load = Load { pressure, damping };
        match self.method(corners) {
            Method::Rule(rung) => quadrature::moments(self, corners, &load, rung),
            Method::ClosedForm(size) => closed_moments::moments(self, corners, &load, size),
        }
    }
}

impl SlipMoments {
    fn zero() -> Self {
        Self {
            direction: [[0.0; 2]; 10],
            by_slip: [[0.0; 3]; 6],
            edges: [[[0.0; 2]; 6]; PLANE_CAPACITY],
        }
    }
}

/// The product of two affine functions: the coefficients of 1, y₁, y₂, y₁², y₁y₂, y₂².
fn quadratic<T: Scalar>(f: &Affine<T>, g: &Affine<T>) -> Quadratic<T> {
    [
        f[0] * g[0],
        f[0] * g[1] + f[1] * g[0],
        f[0] * g[2] + f[2] * g[0],
        f[1] * g[1],
        f[1] * g[2] + f[2] * g[1],
        f[2] * g[2],
    ]
}

/// Entries side by side for each monomial, from monomials side by side for each entry.
fn transposed<const M: usize, const N: usize>(rows: &[[f64; N]; M], factor: f64) -> [[f64; M]; N] {
    let mut columns = [[0.0; M]; N];
    for (i, row) in rows.iter().enumerate() {
        for (column, entry) in columns.iter_mut().zip(row) {
            column[i] = entry * factor;
        }
    }
    columns
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::rngs::StdRng;
    use rand::{RngExt, SeedableRng};
    use std::array;
    use std::f64::consts::{PI, TAU};

    /// Resultant 3, direction 20, by_slip 18, and the integrals of the magnitudes that errors are compared with:
    /// |g|·|y|ᵏ (k = 0, 1), |y|ᵏ (k = 0..3), |g|·|y|ᵏ/σ (k = 0..2).
    type Integrals = [f64; 50];
    type Triangle = [[f64; 2]; 3];

    /// A slip over a loaded polygon.
    #[derive(Debug, Clone)]
    struct Case {
        corners: Vec<[f64; 2]>,
        slip: Slip<f64>,
        pressure: Affine<f64>,
        damping: Affine<f64>,
    }

    const DEGREES: [i32; 10] = [0, 1, 1, 2, 2, 2, 3, 3, 3, 3];

    /// Gauss–Legendre nodes and weights on [0, 1], by Newton's method.
    fn gauss(count: usize) -> Vec<[f64; 2]> {
        let legendre = |x: f64| {
            let (mut before, mut value) = (1.0, x);
            for k in 1..count {
                let k = k as f64;
                (before, value) = (
                    value,
                    ((2.0 * k + 1.0) * x * value - k * before) / (k + 1.0),
                );
            }
            (value, count as f64 * (x * value - before) / (x * x - 1.0))
        };
        let node = |i: usize| {
            let mut x = (PI * (i as f64 + 0.75) / (count as f64 + 0.5)).cos();
            for _ in 0..6 {
                let (value, slope) = legendre(x);
                x -= value / slope;
            }
            let slope = legendre(x).1;
            [0.5 + 0.5 * x, 1.0 / ((1.0 - x * x) * slope * slope)]
        };
        (0..count).map(node).collect()
    }

    impl Case {
        fn field(&self, y: [f64; 2]) -> (f64, [f64; 2], f64) {
            let value = |f: &Affine<f64>| f[0] + f[1] * y[0] + f[2] * y[1];
            let s = [
                self.slip.at_origin[0] - self.slip.spin * y[1],
                self.slip.at_origin[1] + self.slip.spin * y[0],
            ];
            let sigma = s[0].hypot(s[1]).hypot(self.slip.tolerance);
            (
                value(&self.pressure) * value(&self.damping),
                s.map(|x| x / sigma),
                sigma,
            )
        }

        fn integrand(&self, y: [f64; 2]) -> Integrals {
            let (g, u, sigma) = self.field(y);
            let m = [
                1.0,
                y[0],
                y[1],
                y[0] * y[0],
                y[0] * y[1],
                y[1] * y[1],
                y[0].powi(3),
                y[0] * y[0] * y[1],
                y[0] * y[1] * y[1],
                y[1].powi(3),
            ];
            let mut all = [0.0; 50];
            all[..3].copy_from_slice(&[g * u[0], g * u[1], g * (y[0] * u[1] - y[1] * u[0])]);
            for k in 0..10 {
                for j in 0..2 {
                    all[3 + 2 * k + j] = m[k] * u[j];
                }
            }
            let slopes = [u[0] * u[0] - 1.0, u[0] * u[1], u[1] * u[1] - 1.0];
            for k in 0..6 {
                for j in 0..3 {
                    all[23 + 3 * k + j] = g * m[k] * slopes[j] / sigma;
                }
            }
            let size = y[0].hypot(y[1]);
            for k in 0..4i32 {
                let place = usize::try_from(k).unwrap();
                let power = size.powi(k);
                all[43 + place] = power;
                if k < 2 {
                    all[41 + place] = g.abs() * power;
                }
                if k < 3 {
                    all[47 + place] = g.abs() * power / sigma;
                }
            }
            all
        }

        /// A triangle with the points of a product rule, quartered until the slip hardly changes in the parts.
        fn triangle_integrals(&self, t: &Triangle, rule: &[[f64; 2]], depth: u32) -> Integrals {
            let half = |i: usize, j: usize| array::from_fn(|k| 0.5 * (t[i][k] + t[j][k]));
            let middle: [f64; 2] = array::from_fn(|k| (t[0][k] + t[1][k] + t[2][k]) / 3.0);
            let side = |i: usize, j: usize| (t[i][0] - t[j][0]).hypot(t[i][1] - t[j][1]);
            let diameter = side(0, 1).max(side(1, 2)).max(side(2, 0));
            if depth > 0 && (self.slip.spin * diameter).abs() > 0.4 * self.field(middle).2 {
                let (ab, bc, ca) = (half(0, 1), half(1, 2), half(2, 0));
                let parts = [[t[0], ab, ca], [ab, t[1], bc], [ca, bc, t[2]], [ab, bc, ca]];
                let parts = parts.map(|part| self.triangle_integrals(&part, rule, depth - 1));
                return array::from_fn(|k| parts.iter().map(|part| part[k]).sum());
            }
            let [to_b, to_c] = [1, 2].map(|i| [t[i][0] - t[0][0], t[i][1] - t[0][1]]);
            let twice_area = to_b[0] * to_c[1] - to_b[1] * to_c[0];
            let mut sum = [0.0; 50];
            for [x, weight_x] in rule {
                for [z, weight_z] in rule {
                    let (b, c) = (x * (1.0 - z), x * z);
                    let y = array::from_fn(|k| t[0][k] + b * to_b[k] + c * to_c[k]);
                    let weight = twice_area * x * weight_x * weight_z;
                    for (sum, value) in sum.iter_mut().zip(self.integrand(y)) {
                        *sum += weight * value;
                    }
                }
            }
            sum
        }

        fn integrals(&self) -> Integrals {
            let rule = gauss(11);
            let mut sum = [0.0; 50];
            for i in 1..self.corners.len() - 1 {
                let triangle = [self.corners[0], self.corners[i], self.corners[i + 1]];
                let part = self.triangle_integrals(&triangle, &rule, 40);
                sum = array::from_fn(|k| sum[k] + part[k]);
            }
            sum
        }

        fn edge_integrals(
            &self,
            a: [f64; 2],
            b: [f64; 2],
            depth: u32,
        ) -> ([[f64; 2]; 6], [f64; 3]) {
            let middle: [f64; 2] = array::from_fn(|k| 0.5 * (a[k] + b[k]));
            let length = (b[0] - a[0]).hypot(b[1] - a[1]);
            if depth > 0 && (self.slip.spin * length).abs() > 0.4 * self.field(middle).2 {
                let (one, other) = (
                    self.edge_integrals(a, middle, depth - 1),
                    self.edge_integrals(middle, b, depth - 1),
                );
                return (
                    array::from_fn(|m| array::from_fn(|j| one.0[m][j] + other.0[m][j])),
                    array::from_fn(|k| one.1[k] + other.1[k]),
                );
            }
            let (mut sums, mut scales) = ([[0.0; 2]; 6], [0.0; 3]);
            for [x, weight] in gauss(11) {
                let y: [f64; 2] = array::from_fn(|k| a[k] + x * (b[k] - a[k]));
                let (g, u, _) = self.field(y);
                let m = [1.0, y[0], y[1], y[0] * y[0], y[0] * y[1], y[1] * y[1]];
                for k in 0..6 {
                    for j in 0..2 {
                        sums[k][j] += length * weight * g * m[k] * u[j];
                    }
                }
                for (k, scale) in scales.iter_mut().enumerate() {
                    *scale += length * weight * g.abs() * y[0].hypot(y[1]).powi(k as i32);
                }
            }
            (sums, scales)
        }

        /// Worst errors of resultant, direction, by_slip and edges.
        fn errors(&self) -> [f64; 4] {
            let exact = self.integrals();
            let resultant = self
                .slip
                .resultant(&self.corners, &self.pressure, &self.damping);
            let moments = self
                .slip
                .moments(&self.corners, &self.pressure, &self.damping);
            let mut errors = [0.0f64; 4];
            let mut note = |kind: usize, value: f64, exact: f64, scale: f64| {
                let error = (value - exact).abs() / scale;
                errors[kind] = if error.is_nan() {
                    f64::NAN
                } else {
                    errors[kind].max(error)
                };
            };
            for k in 0..3 {
                note(0, resultant[k], exact[k], exact[41 + k / 2]);
            }
            for k in 0..10 {
                let degree = usize::try_from(DEGREES[k]).unwrap();
                for j in 0..2 {
                    note(
                        1,
                        moments.direction[k][j],
                        exact[3 + 2 * k + j],
                        exact[43 + degree],
                    );
                }
                for j in 0..3 {
                    if k < 6 {
                        note(
                            2,
                            moments.by_slip[k][j],
                            exact[23 + 3 * k + j],
                            exact[47 + degree],
                        );
                    }
                }
            }
            let edges: Vec<_> = (0..self.corners.len())
                .map(|i| {
                    self.edge_integrals(
                        self.corners[i],
                        self.corners[(i + 1) % self.corners.len()],
                        40,
                    )
                })
                .collect();
            let scales: [f64; 3] = array::from_fn(|k| edges.iter().map(|edge| edge.1[k]).sum());
            for (i, (edge, _)) in edges.iter().enumerate() {
                for k in 0..6 {
                    for j in 0..2 {
                        note(
                            3,
                            moments.edges[i][k][j],
                            edge[k][j],
                            scales[usize::try_from(DEGREES[k]).unwrap()],
                        );
                    }
                }
            }
            errors
        }
    }

    fn random_polygon(rng: &mut StdRng, size: f64) -> Vec<[f64; 2]> {
        let count = rng.random_range(3..9);
        let angles = loop {
            let mut angles: Vec<f64> = (0..count).map(|_| rng.random_range(0.0..TAU)).collect();
            angles.sort_by(f64::total_cmp);
            let gaps = (0..count).map(|i| {
                if i == 0 {
                    angles[0] + TAU - angles[count - 1]
                } else {
                    angles[i] - angles[i - 1]
                }
            });
            if gaps.clone().all(|gap| gap < 2.8 && gap > 0.05) {
                break angles;
            }
        };
        let aspect = 10f64.powf(rng.random_range(-1.0..0.0));
        let (sin, cos) = rng.random_range(0.0..TAU).sin_cos();
        let corners: Vec<[f64; 2]> = angles
            .iter()
            .map(|angle| {
                let (y, x) = angle.sin_cos();
                [
                    size * (cos * x - sin * aspect * y),
                    size * (sin * x + cos * aspect * y),
                ]
            })
            .collect();
        let mean: [f64; 2] =
            array::from_fn(|k| corners.iter().map(|y| y[k]).sum::<f64>() / count as f64);
        corners
            .iter()
            .map(|y| array::from_fn(|k| y[k] - mean[k]))
            .collect()
    }

    /// Not negative on the polygon, zero at a corner half the time.
    fn random_load(rng: &mut StdRng, corners: &[[f64; 2]], size: f64) -> Affine<f64> {
        let slope: [f64; 2] = array::from_fn(|_| rng.random_range(-1.0..1.0) / size);
        let least = corners
            .iter()
            .map(|y| slope[0] * y[0] + slope[1] * y[1])
            .fold(f64::MAX, f64::min);
        let above = if rng.random_bool(0.5) {
            rng.random_range(0.0..1.0)
        } else {
            0.0
        };
        [above - least, slope[0], slope[1]]
    }

    /// With θ as wished, the slip of the center by translation or by the tolerance alone, or both.
    fn random_case(rng: &mut StdRng, theta: f64, size: f64) -> Case {
        let corners = random_polygon(rng, size);
        let farthest = corners.iter().map(|y| y[0].hypot(y[1])).fold(0.0, f64::max);
        let (sin, cos) = rng.random_range(0.0..TAU).sin_cos();
        let small = 10f64.powf(rng.random_range(-6.0..-1.0));
        let share = match rng.random_range(0..3) {
            0 => rng.random_range(0.0..PI / 2.0),
            1 => small,
            _ => PI / 2.0 - small,
        };
        let spin =
            10f64.powf(rng.random_range(-1.0..1.0)) * if rng.random_bool(0.5) { 1.0 } else { -1.0 };
        let total = spin.abs() * farthest / theta;
        let (tolerance, speed) = (total * share.sin(), total * share.cos());
        Case {
            slip: Slip {
                at_origin: [speed * cos, speed * sin],
                spin,
                tolerance,
            },
            pressure: random_load(rng, &corners, size),
            damping: random_load(rng, &corners, size),
            corners,
        }
    }

    #[test]
    fn survey() {
        let mut rng = StdRng::seed_from_u64(1);
        let n: usize = std::env::var("N").map_or(60, |n| n.parse().unwrap());
        for theta in [
            1e-6, 1e-5, 1e-4, 9.9e-4, 1.1e-3, 3e-3, 4e-3, 0.01, 0.02, 0.03, 0.05, 0.1, 0.19, 0.2,
            0.22, 0.3, 0.4, 0.45, 0.499, 0.501, 0.6, 0.8, 1.0, 2.0, 10.0, 1e3, 1e6,
        ] {
            let mut all: Vec<[f64; 4]> = (0..n)
                .map(|_| random_case(&mut rng, theta, 1.0).errors())
                .collect();
            print!("{theta:8.1e}: ");
            for k in 0..4 {
                all.sort_by(|a, b| a[k].total_cmp(&b[k]));
                print!(" {:7.0e} {:7.0e} |", all[n / 2][k], all[n - 1][k]);
            }
            println!();
        }
    }
}
