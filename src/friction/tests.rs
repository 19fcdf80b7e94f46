use super::*;
use crate::lanes::{self, InLanes, Lanes, Numbers, ROW};
use crate::scalar::{DenseDual, lift};
use num_dual::Dual2_64;
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use std::array;
use std::f64::consts::{PI, TAU};

/// The resultant (3 numbers), direction (20), by_slip (18), and the integrals of the magnitudes to which errors are relative: |g|·|y|ᵏ (k =
/// 0, 1), |y|ᵏ (k = 0..3), |g|·|y|ᵏ/σ (k = 0..2).
type Integrals = [f64; 50];
type EdgeIntegrals = [f64; 15];
type Triangle = [[f64; 2]; 3];

/// A slip over a loaded polygon.
#[derive(Debug, Clone)]
struct Case {
    corners: Vec<[f64; 2]>,
    slip: Slip<f64>,
    pressure: Affine<f64>,
    damping: Affine<f64>,
}

/// Degrees of the ten monomials.
const DEGREES: [usize; 10] = [0, 1, 1, 2, 2, 2, 3, 3, 3, 3];

/// Returns Gauss–Legendre nodes and weights on [0, 1], computed by Newton's method.
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

/// The integrals of a case by the rules of a level, in the first lane.
struct ByRules<'c> {
    case: &'c Case,
    level: usize,
}

impl InLanes for ByRules<'_> {
    type Output = (SlipMoments, Vec<[[f64; 6]; 2]>);

    fn run<L: Lanes>(self, lanes: L) -> Self::Output {
        let Case {
            corners,
            slip,
            pressure,
            damping,
        } = self.case;
        let load = SlipAndLoad {
            slip: (
                slip.at_origin.map(|v| lanes.splat(v)),
                lanes.splat(slip.spin),
            ),
            tolerance_squared: lanes.splat(slip.tolerance * slip.tolerance),
            pressure: pressure.map(|c| lanes.splat(c)),
            damping: damping.map(|c| lanes.splat(c)),
            one: lanes.splat(1.0),
        };
        let first = |number: L::Numbers| {
            let mut row = [0.0; ROW];
            number.store(&mut row, 0);
            row[0]
        };
        let corners: Vec<_> = corners.iter().map(|y| y.map(|c| lanes.splat(c))).collect();
        let (over_area, along_edges) = slope_rules(self.level);
        let moments = load.over_area(lanes, &corners, over_area);
        let fluxes = (0..corners.len()).map(|edge| {
            let [from, to] = ends(&corners, edge);
            let flux = load.along(lanes, &Edge::between(from, to), along_edges);
            flux.map(|flux| flux.map(first))
        });
        (
            SlipMoments {
                direction: moments.direction.map(|u| u.map(first)),
                by_slip: moments.by_slip.map(|t| t.map(first)),
            },
            fluxes.collect(),
        )
    }
}

impl Case {
    /// Returns the same case with another origin.
    fn seen_from(mut self, [o1, o2]: [f64; 2]) -> Self {
        for y in &mut self.corners {
            *y = [y[0] - o1, y[1] - o2];
        }
        for f in [&mut self.pressure, &mut self.damping] {
            f[0] += f[1] * o1 + f[2] * o2;
        }
        self.slip.at_origin[0] -= self.slip.spin * o2;
        self.slip.at_origin[1] += self.slip.spin * o1;
        self
    }

    /// Computes the integrals by rules or in closed form, like a contact.
    fn moments_and_fluxes(&self) -> (SlipMoments, Vec<[[f64; 6]; 2]>) {
        if let Some(level) = self.slip.level(&self.corners) {
            return lanes::run(ByRules { case: self, level });
        }
        let closed = ClosedForm::on(&self.corners, self.slip, &self.pressure, &self.damping);
        let count = self.corners.len();
        let fluxes = (0..count).map(|edge| closed.along(ends(&self.corners, edge)));
        (closed.moments(), fluxes.collect())
    }

    fn fluxes(&self) -> Vec<[[f64; 6]; 2]> {
        self.moments_and_fluxes().1
    }

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
        let powers = [1.0, size, size * size, size.powi(3)];
        all[41..43].copy_from_slice(&[g.abs(), g.abs() * size]);
        all[43..47].copy_from_slice(&powers);
        for (scale, power) in all[47..].iter_mut().zip(powers) {
            *scale = g.abs() * power / sigma;
        }
        all
    }

    /// Integrates over a triangle with a product rule. The triangle is quartered until the slip hardly changes in the parts.
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

    /// Returns ∫ g·m·u dl from a to b, and ∫ |g|·|y|ᵏ dl, k = 0, 1, 2.
    fn edge_integrals(&self, a: [f64; 2], b: [f64; 2], depth: u32) -> EdgeIntegrals {
        let middle: [f64; 2] = array::from_fn(|k| 0.5 * (a[k] + b[k]));
        let length = (b[0] - a[0]).hypot(b[1] - a[1]);
        if depth > 0 && (self.slip.spin * length).abs() > 0.4 * self.field(middle).2 {
            let parts = [[a, middle], [middle, b]];
            let [first, second] = parts.map(|[a, b]| self.edge_integrals(a, b, depth - 1));
            return array::from_fn(|k| first[k] + second[k]);
        }
        let mut sums = [0.0; 15];
        for [x, weight] in gauss(11) {
            let y: [f64; 2] = array::from_fn(|k| a[k] + x * (b[k] - a[k]));
            let (load, u, _) = self.field(y);
            let weight = length * weight * load;
            let monomials = [1.0, y[0], y[1], y[0] * y[0], y[0] * y[1], y[1] * y[1]];
            for (k, monomial) in monomials.into_iter().enumerate() {
                sums[2 * k] += weight * monomial * u[0];
                sums[2 * k + 1] += weight * monomial * u[1];
            }
            let size = y[0].hypot(y[1]);
            for (k, power) in [1.0, size, size * size].into_iter().enumerate() {
                sums[12 + k] += weight.abs() * power;
            }
        }
        sums
    }

    /// Returns the worst errors of resultant, direction, by_slip and fluxes.
    fn errors(&self) -> [f64; 4] {
        let exact = self.integrals();
        let resultant = self
            .slip
            .resultant(&self.corners, &self.pressure, &self.damping);
        let (moments, fluxes) = self.moments_and_fluxes();
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
            let degree = DEGREES[k];
            for j in 0..2 {
                note(
                    1,
                    moments.direction[j][k],
                    exact[3 + 2 * k + j],
                    exact[43 + degree],
                );
            }
            for j in 0..3 {
                if k < 6 {
                    note(
                        2,
                        moments.by_slip[j][k],
                        exact[23 + 3 * k + j],
                        exact[47 + degree],
                    );
                }
            }
        }
        let following = self.corners.iter().cycle().skip(1);
        let edges = self.corners.iter().zip(following);
        let edges: Vec<_> = edges
            .map(|(a, b)| self.edge_integrals(*a, *b, 40))
            .collect();
        let scales: [f64; 3] = array::from_fn(|k| edges.iter().map(|edge| edge[12 + k]).sum());
        for (edge, exact) in fluxes.iter().zip(&edges) {
            for (j, edge) in edge.iter().enumerate() {
                for (k, value) in edge.iter().enumerate() {
                    note(3, *value, exact[2 * k + j], scales[DEGREES[k]]);
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

/// Returns a load that is not negative on the polygon, and zero at a corner half the time.
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

/// Returns a case with this θ. At the center, σ comes from the translation, from the tolerance, or from both.
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

/// Errors of resultant, direction, by_slip and fluxes: several times the worst of hundreds of cases. The closed form computes by_slip from
/// a difference of integrals along edges and over the area, and loses more.
const TOLERANCES: [f64; 4] = [1e-11, 3e-11, 1e-9, 1e-11];

fn assert_exact(case: &Case) {
    let errors = case.errors();
    for (error, tolerance) in errors.iter().zip(TOLERANCES) {
        assert!(*error < tolerance, "{errors:?}: {case:?}");
    }
}

#[test]
fn all_integrals_agree_with_subdivision_whatever_the_spin() {
    let mut rng = StdRng::seed_from_u64(1);
    let thetas = [
        1e-6, 1e-4, 2.9e-3, 9.9e-3, 0.029, 0.1, 0.19, 0.3, 0.47, 0.49, 0.6, 1.0, 3.0, 30.0, 1e3,
        1e6,
    ];
    for theta in thetas {
        for size in [1e-9, 2e-3, 1.0, 1e3] {
            assert_exact(&random_case(&mut rng, theta, size));
        }
    }
}

/// Prints the errors that are noted at [`QUADRATURE`].
#[test]
#[ignore = "takes minutes"]
fn errors_at_the_upper_ends_of_the_levels_are_those_noted() {
    let mut rng = StdRng::seed_from_u64(12);
    let ends = QUADRATURE.iter().map(|level| 0.99 * level.below);
    for theta in ends.chain([0.49, 2.0]) {
        let mut worst = [0.0_f64; 4];
        for _ in 0..400 {
            let errors = random_case(&mut rng, theta, 1.0).errors();
            worst = [0, 1, 2, 3].map(|kind| worst[kind].max(errors[kind]));
        }
        println!(
            "{theta}: {}",
            worst.map(|error| format!("{error:.0e}")).join(", ")
        );
        assert!(
            worst
                .iter()
                .zip(TOLERANCES)
                .all(|(error, most)| *error < most)
        );
    }
}

#[test]
fn the_origin_need_not_be_the_center_of_the_polygon() {
    let mut rng = StdRng::seed_from_u64(11);
    for theta in [1e-6, 1e-4, 9e-4, 0.029, 0.19, 0.47, 0.49, 1.0, 3.0, 1e3] {
        for origin in [[2.0, 0.0], [-1.0, 1.5]] {
            assert_exact(&random_case(&mut rng, theta, 1.0).seen_from(origin));
        }
    }
}

/// Returns a pentagon that turns about a point.
fn turning_about(center: [f64; 2], spin: f64, tolerance: f64) -> Case {
    Case {
        corners: vec![
            [-0.5, -0.4],
            [0.6, -0.4],
            [0.8, 0.3],
            [0.1, 0.7],
            [-0.6, 0.2],
        ],
        slip: Slip {
            at_origin: [spin * center[1], -spin * center[0]],
            spin,
            tolerance,
        },
        pressure: [1.0, 0.5, -0.3],
        damping: [1.0, -0.2, 0.1],
    }
}

/// Centers inside, on a corner, on an edge, on the line of an edge, beside an edge, and far away.
const CENTERS: [[f64; 2]; 6] = [
    [0.1, 0.05],
    [0.6, -0.4],
    [0.05, -0.4],
    [1.4, -0.4],
    [0.2, -0.4 - 1e-9],
    [30.0, 20.0],
];

#[test]
fn all_integrals_agree_with_subdivision_wherever_the_center_of_rotation_is() {
    for center in CENTERS {
        for tolerance in [1e-6, 1e-3, 0.1, 1.0, 100.0] {
            for spin in [1.0, -1.0] {
                assert_exact(&turning_about(center, spin, tolerance));
            }
        }
    }
}

#[test]
fn pure_coulomb_friction_is_the_limit_of_a_small_tolerance() {
    /// The tolerance ε changes the resultant by ε·ln(1/ε).
    const LIMIT: f64 = 1e-9;
    for center in CENTERS {
        let resultant = |tolerance: f64| resultant_of(&turning_about(center, 1.0, tolerance));
        let (small, least) = (resultant(1e-11), resultant(1e-40));
        for k in 0..3 {
            assert!((small[k] - least[k]).abs() < LIMIT, "{center:?}");
        }
    }
}

fn resultant_of(case: &Case) -> [f64; 3] {
    case.slip
        .resultant(&case.corners, &case.pressure, &case.damping)
}

fn moments_of(case: &Case) -> SlipMoments {
    case.moments_and_fluxes().0
}

#[test]
fn integrals_hardly_change_where_the_method_does() {
    /// The worst error of the two methods. For by_slip, ten times this error is allowed.
    const STEP: f64 = 1e-10;
    /// A change of the spin so small that the integrals themselves change by less than `STEP`.
    const BESIDE: f64 = 1e-13;
    let mut rng = StdRng::seed_from_u64(2);
    for level in &QUADRATURE {
        for _ in 0..20 {
            let case = random_case(&mut rng, level.below, 1.0);
            let beside = |factor: f64| {
                let mut case = case.clone();
                case.slip.spin *= factor;
                let moments = moments_of(&case);
                (resultant_of(&case), moments.by_slip, case.fluxes())
            };
            let (below, above) = (beside(1.0 - BESIDE), beside(1.0 + BESIDE));
            for k in 0..3 {
                assert!((below.0[k] - above.0[k]).abs() < STEP);
                let (value_below, value_above) = (below.1[k][0], above.1[k][0]);
                let sigma = case.field([0.0; 2]).2;
                assert!((value_below - value_above).abs() < 10.0 * STEP / sigma);
            }
            for (value_below, value_above) in below
                .2
                .as_flattened()
                .as_flattened()
                .iter()
                .zip(above.2.as_flattened().as_flattened())
            {
                assert!((value_below - value_above).abs() < STEP);
            }
        }
    }
}

/// Round-off of some hundred operations on numbers of magnitude 1.
const ROUND_OFF: f64 = 1e-14;

#[test]
fn without_spin_the_direction_is_constant() {
    let mut case = turning_about([0.0; 2], 0.0, 0.3);
    case.corners = vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
    case.slip.at_origin = [0.3, -0.4];
    // The integral of a product of affine functions over a triangle is area/12·(Σ pᵢdᵢ + Σpᵢ·Σdᵢ).
    let at_corners = |f: &Affine<f64>| [f[0], f[0] + f[1], f[0] + f[2]];
    let (p, d) = (at_corners(&case.pressure), at_corners(&case.damping));
    let products: f64 = p.iter().zip(d).map(|(p, d)| p * d).sum();
    let load = (products + p.iter().sum::<f64>() * d.iter().sum::<f64>()) / 24.0;
    let sigma = 0.34f64.sqrt();
    let u = [0.3 / sigma, -0.4 / sigma];
    let (resultant, moments) = (resultant_of(&case), moments_of(&case));
    assert!((resultant[0] - load * u[0]).abs() < ROUND_OFF);
    assert!((resultant[1] - load * u[1]).abs() < ROUND_OFF);
    let expected = [u[0] * u[0] - 1.0, u[0] * u[1], u[1] * u[1] - 1.0];
    for (value, expected) in moments.by_slip.into_iter().zip(expected) {
        assert!((value[0] - load / sigma * expected).abs() < ROUND_OFF);
    }
}

#[test]
fn resultant_scales_with_size_and_speed() {
    let mut rng = StdRng::seed_from_u64(3);
    for theta in [1e-6, 1e-2, 0.3, 1.0, 100.0] {
        let case = random_case(&mut rng, theta, 1.0);
        let expected = resultant_of(&case);
        for (size, speed) in [
            (2f64.powi(-30), 2f64.powi(20)),
            (2f64.powi(10), 2f64.powi(-12)),
        ] {
            let mut scaled = case.clone();
            for y in scaled.corners.as_mut_slice().as_flattened_mut() {
                *y *= size;
            }
            for f in [&mut scaled.pressure, &mut scaled.damping] {
                f[1] /= size;
                f[2] /= size;
            }
            scaled.slip.at_origin = case.slip.at_origin.map(|x| x * speed);
            scaled.slip.spin *= speed / size;
            scaled.slip.tolerance *= speed;
            let units = [size.powi(2), size.powi(2), size.powi(3)];
            for (k, value) in resultant_of(&scaled).into_iter().enumerate() {
                assert!(
                    (value / units[k] - expected[k]).abs() < ROUND_OFF,
                    "{theta}"
                );
            }
        }
    }
}

#[test]
fn resultant_is_made_of_the_moments() {
    /// The error of each in the closed form.
    const AGREEMENT: f64 = 2e-11;
    let mut rng = StdRng::seed_from_u64(4);
    for theta in [1e-6, 1e-4, 1e-2, 0.1, 0.3, 0.5, 1.0, 1e3] {
        let case = random_case(&mut rng, theta, 1.0);
        let (resultant, moments) = (resultant_of(&case), moments_of(&case));
        let g = product(&case.pressure, &case.damping);
        let load = |indices: [usize; 6], j: usize| -> f64 {
            g.iter()
                .zip(indices)
                .map(|(g, k)| g * moments.direction[j][k])
                .sum()
        };
        let every = [0, 1, 2, 3, 4, 5];
        let torque = load([1, 3, 4, 6, 7, 8], 1) - load([2, 4, 5, 7, 8, 9], 0);
        for (value, expected) in resultant
            .into_iter()
            .zip([load(every, 0), load(every, 1), torque])
        {
            assert!(
                (value - expected).abs() < AGREEMENT,
                "{theta}: {value} {expected}"
            );
        }
    }
}

/// All numbers of a case, each with a direction of change.
struct Line {
    case: Case,
    by: Case,
}

impl Line {
    fn random(rng: &mut StdRng, case: Case) -> Self {
        let scale = case.field([0.0; 2]).2;
        let mut by = case.clone();
        let mut any = |scale: f64| scale * rng.random_range(-1.0..1.0);
        for y in by.corners.as_mut_slice().as_flattened_mut() {
            *y = any(1.0);
        }
        by.slip.at_origin = [any(scale), any(scale)];
        by.slip.spin = any(case.slip.spin.abs().max(scale));
        by.pressure = array::from_fn(|_| any(1.0));
        by.damping = array::from_fn(|_| any(1.0));
        Self { case, by }
    }

    fn resultant<T: Scalar>(&self, t: T) -> [T; 3] {
        let (case, by) = (&self.case, &self.by);
        let at = |value: f64, slope: f64| t * slope + lift::<T>(value);
        let corners: Vec<[T; 2]> = (0..case.corners.len())
            .map(|i| array::from_fn(|k| at(case.corners[i][k], by.corners[i][k])))
            .collect();
        let slip = Slip {
            at_origin: array::from_fn(|k| at(case.slip.at_origin[k], by.slip.at_origin[k])),
            spin: at(case.slip.spin, by.slip.spin),
            tolerance: case.slip.tolerance,
        };
        let pressure = array::from_fn(|k| at(case.pressure[k], by.pressure[k]));
        let damping = array::from_fn(|k| at(case.damping[k], by.damping[k]));
        slip.resultant(&corners, &pressure, &damping)
    }

    fn slope(&self, t: f64) -> [f64; 3] {
        self.resultant(DenseDual::new(t, [1.0])).map(|x| x.eps[0])
    }

    /// Asserts that first and second derivatives agree with central differences with this step.
    fn check(&self, step: f64, tolerance: f64) {
        let second = self.resultant(Dual2_64::new(0.0, 1.0, 0.0));
        let [after, before] = [step, -step].map(|t| self.resultant(t));
        let [slope_after, slope_before] = [step, -step].map(|t| self.slope(t));
        let size = second
            .iter()
            .fold(1.0, |size, x| x.v1.abs().max(x.v2.abs()).max(size));
        for k in 0..3 {
            let difference = (after[k] - before[k]) / (2.0 * step);
            assert!((self.slope(0.0)[k] - second[k].v1).abs() < 1e-9 * size);
            assert!(
                (second[k].v1 - difference).abs() < tolerance * size,
                "{} {difference}: {:?}",
                second[k].v1,
                self.case
            );
            let difference = (slope_after[k] - slope_before[k]) / (2.0 * step);
            assert!(
                (second[k].v2 - difference).abs() < tolerance * size,
                "second {} {difference}: {:?}",
                second[k].v2,
                self.case
            );
        }
    }
}

/// Error of central differences with a step of 1e-4: its square times third derivatives of some tens, and the value's error over the step.
const DIFFERENCES: f64 = 3e-6;

#[test]
fn dual_numbers_agree_with_differences() {
    let mut rng = StdRng::seed_from_u64(5);
    for theta in [1e-6, 1e-4, 0.005, 0.1, 0.3, 0.7, 1.0, 3.0] {
        for _ in 0..5 {
            let mut case = random_case(&mut rng, theta, 1.0);
            // Differences fail near σ = 0.
            case.slip.tolerance += 0.5 * case.slip.spin.abs();
            Line::random(&mut rng, case).check(1e-4, DIFFERENCES);
        }
    }
}

#[test]
fn dual_numbers_agree_with_differences_without_spin() {
    let mut rng = StdRng::seed_from_u64(6);
    for _ in 0..5 {
        let mut case = random_case(&mut rng, 1.0, 1.0);
        case.slip.spin = 0.0;
        case.slip.tolerance += 0.1;
        Line::random(&mut rng, case).check(1e-4, DIFFERENCES);
    }
}

#[test]
fn dual_numbers_agree_with_differences_wherever_the_center_of_rotation_is() {
    let mut rng = StdRng::seed_from_u64(10);
    for center in CENTERS {
        for spin in [1.0, -1.0] {
            // Third derivatives are some hundreds here.
            Line::random(&mut rng, turning_about(center, spin, 0.05)).check(1e-5, DIFFERENCES);
        }
    }
}

#[test]
fn corners_that_coincide_may_move_apart() {
    let mut rng = StdRng::seed_from_u64(7);
    for spin in [0.1, 3.0] {
        let mut case = turning_about([0.3, 0.2], spin, 0.5);
        case.corners.insert(2, case.corners[2]);
        Line::random(&mut rng, case.clone()).check(1e-4, DIFFERENCES);
        // The edge is so short that division by its length would destroy a second derivative.
        case.corners[2][1] -= 1e-9;
        Line::random(&mut rng, case).check(1e-4, DIFFERENCES);
    }
}

#[test]
fn by_slip_is_the_derivative_by_the_slip() {
    /// The errors of by_slip and of the dual numbers in the closed form.
    const AGREEMENT: f64 = 1e-9;
    let mut rng = StdRng::seed_from_u64(8);
    for theta in [1e-6, 1e-4, 1e-2, 0.1, 0.3, 0.5, 1.0, 1e3] {
        let case = random_case(&mut rng, theta, 1.0);
        let by_slip = moments_of(&case).by_slip.map(|moments| moments[0]);
        let slip = Slip {
            at_origin: [0, 1].map(|k| DenseDual::<2>::variable(case.slip.at_origin[k], k)),
            spin: lift(case.slip.spin),
            tolerance: case.slip.tolerance,
        };
        let corners: Vec<_> = case.corners.iter().map(|y| y.map(lift)).collect();
        let [pressure, damping] = [case.pressure, case.damping].map(|f| f.map(lift));
        let [first, second, _] = slip.resultant(&corners, &pressure, &damping);
        let scale = by_slip[0].abs() + by_slip[2].abs();
        let expected = [[by_slip[0], by_slip[1]], [by_slip[1], by_slip[2]]];
        for (row, expected) in [first, second].iter().zip(expected) {
            for (slope, expected) in row.eps.iter().zip(expected) {
                assert!((slope + expected).abs() < AGREEMENT * scale, "{theta}");
            }
        }
    }
}

#[test]
fn a_line_has_edges_and_no_area() {
    for spin in [0.0, 1e-4, 0.3, 2.0, 1e6] {
        for at_origin in [[0.0, 0.0], [0.4, 0.3]] {
            let (a, b) = ([-0.3, -0.3], [0.7, 0.7]);
            let mut case = turning_about([0.0; 2], spin, 0.2);
            case.slip.at_origin = at_origin;
            case.corners = vec![a, b, b, a];
            let moments = moments_of(&case);
            let area = moments
                .by_slip
                .as_flattened()
                .iter()
                .chain(moments.direction.as_flattened());
            assert!(
                area.chain(&resultant_of(&case))
                    .all(|value| value.abs() < ROUND_OFF)
            );
            let exact = case.edge_integrals(a, b, 40);
            let [there, opposite, back, end] = case.fluxes().try_into().unwrap();
            assert_eq!((opposite, end), ([[0.0; 6]; 2], [[0.0; 6]; 2]));
            for edge in [there, back] {
                for (k, value) in edge.as_flattened().iter().enumerate() {
                    let exact = exact[2 * (k % 6) + k / 6];
                    assert!((value - exact).abs() < TOLERANCES[3]);
                }
            }
        }
    }
}

#[test]
fn extremes_give_finite_numbers() {
    let corners = turning_about([0.0; 2], 1.0, 1.0).corners;
    for size in [1e-9, 1.0, 1e3] {
        for spin in [0.0, 1e-300, -1e-12, 1.0, 1e8, -1e15] {
            for tolerance in [1e-12, 1.0, 1e8] {
                for center in CENTERS {
                    let mut case = turning_about(center.map(|x| x * size), spin, tolerance);
                    case.corners = corners.iter().map(|y| y.map(|x| x * size)).collect();
                    assert_finite(&case);
                    case.corners = [corners[1], corners[2], corners[2], corners[1]]
                        .map(|y| y.map(|x| x * size))
                        .into();
                    assert_finite(&case);
                    case.corners = vec![corners[1].map(|x| x * size); 3];
                    assert_finite(&case);
                }
            }
        }
    }
}

fn assert_finite(case: &Case) {
    let moments = moments_of(case);
    let numbers = moments
        .direction
        .as_flattened()
        .iter()
        .chain(moments.by_slip.as_flattened());
    assert!(
        numbers
            .chain(case.fluxes().as_flattened().as_flattened())
            .all(|x| x.is_finite()),
        "{case:?}"
    );
    let mut rng = StdRng::seed_from_u64(9);
    let second = Line::random(&mut rng, case.clone()).resultant(Dual2_64::new(0.0, 1.0, 0.0));
    assert!(
        second
            .iter()
            .all(|x| x.re.is_finite() && x.v1.is_finite() && x.v2.is_finite()),
        "{second:?}: {case:?}"
    );
}
