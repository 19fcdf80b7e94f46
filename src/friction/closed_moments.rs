//! Moments in closed form: the recursion of [`super::closed_form`], continued by one degree, and the fluxes through the edges.

use super::closed_form::{HalfSolidAngle, Rotation};
use super::edge::{Corner, EdgeMeans, Vector, cross};
use super::{Affine, ClosedForm, Load, Quadratic, SlipMoments, product};

/// A number for each monomial up to degree 3: 1, y₁, y₂, y₁², y₁y₂, y₂², y₁³, y₁²y₂, y₁y₂², y₂³.
type Cubic = [f64; 10];

/// Indices of y₁·m and y₂·m among the monomials, for the first six m.
const RAISED: [[usize; 2]; 6] = [[1, 2], [3, 4], [4, 5], [6, 7], [7, 8], [8, 9]];

impl ClosedForm<'_> {
    /// Computes the integrals over the polygon.
    pub fn moments(&self) -> SlipMoments {
        let Self { slip, load, .. } = self;
        let rotation = Rotation::new(slip, self.size);
        let g = product(load.pressure, load.damping);
        let (mut sums, mut fluxes) = (Sums::default(), [[[0.0; 6]; 2]; 2]);
        rotation.visit_edges(self.corners, |a, b| {
            let means = EdgeMeans::new(a, b, rotation.epsilon * rotation.epsilon);
            sums.add(a, b, &means, rotation.epsilon);
            let flux = EdgeFlux::new(&rotation, &means, load).by_monomial();
            let normal = [b.position[1] - a.position[1], a.position[0] - b.position[0]];
            for (axis, flux) in flux.iter().enumerate() {
                for (m, mean) in flux.iter().enumerate() {
                    fluxes[0][axis][m] += normal[0] * mean;
                    fluxes[1][axis][m] += normal[1] * mean;
                }
            }
        });
        let [by_r1, by_r2] = sums.first_moments_over_r(rotation.epsilon);
        let direction = [by_r2.map(|x| -x), by_r1].map(|u| rotation.about_origin(u));
        SlipMoments {
            by_slip: by_slip(&direction, &g, &fluxes, slip.spin),
            direction,
        }
    }

    /// Returns ∫ g·m·u dl along an edge for the first six monomials m, or zero if its ends coincide.
    pub fn along(&self, ends: [Vector<f64>; 2]) -> [[f64; 6]; 2] {
        let rotation = Rotation::new(&self.slip, self.size);
        let [a, b] = ends.map(|y| rotation.corner(&y));
        let means = EdgeMeans::new(&a, &b, rotation.epsilon * rotation.epsilon);
        let flux = EdgeFlux::new(&rotation, &means, &self.load).by_monomial();
        flux.map(|flux| flux.map(|mean| mean * means.length))
    }
}

/// ∮ nᵢ·f·R dl and ∮ (r·n)·f·R dl for the monomials f in r, and the terms of I\[1\] (see [`super::closed_form`]).
struct Sums {
    normal: [Cubic; 2],
    radial: Cubic,
    radial_over_r: f64,
    angle: HalfSolidAngle<f64>,
}

impl Default for Sums {
    fn default() -> Self {
        Self {
            normal: [[0.0; 10]; 2],
            radial: [0.0; 10],
            radial_over_r: 0.0,
            angle: HalfSolidAngle::new(),
        }
    }
}

impl Sums {
    #[inline]
    fn add(&mut self, a: &Corner<f64>, b: &Corner<f64>, means: &EdgeMeans<f64>, epsilon: f64) {
        self.angle.turn(a, b, epsilon);
        let by_r = monomial_means(means);
        let radial = cross(a.position, b.position);
        let normal = [b.position[1] - a.position[1], a.position[0] - b.position[0]];
        for (k, mean) in by_r.into_iter().enumerate() {
            self.normal[0][k] += normal[0] * mean;
            self.normal[1][k] += normal[1] * mean;
            self.radial[k] += radial * mean;
        }
        self.radial_over_r += radial * means.over_r[0];
    }

    /// Returns I\[r₁f\] and I\[r₂f\] for the monomials f in r. If two choices of i and f give the same integral, the one with M\[∂ᵢf\] = 0
    /// is used, if any.
    fn first_moments_over_r(&self, epsilon: f64) -> [Cubic; 2] {
        let ([n1, n2], radial) = (&self.normal, &self.radial);
        let squared = epsilon * epsilon;
        let by_r =
            |k: usize, over_r: f64, degree: f64| (radial[k] + squared * over_r) / (degree + 3.0);
        let i0 = self.radial_over_r - epsilon * self.angle.solid_angle();
        let m0 = by_r(0, i0, 0.0);
        let (i1, i2) = (n1[0], n2[0]);
        let (m1, m2) = (by_r(1, i1, 1.0), by_r(2, i2, 1.0));
        let (i11, i12, i22) = (n1[1] - m0, n2[1], n2[2] - m0);
        let [m11, m22] = [(3, i11), (5, i22)].map(|(k, over_r)| by_r(k, over_r, 2.0));
        let (i111, i112, i122, i222) = (n1[3] - 2.0 * m1, n2[3], n1[5], n2[5] - 2.0 * m2);
        let (i1112, i1122, i1222) = (n2[6], n1[8] - m22, n1[9]);
        let (i1111, i2222) = (n1[6] - 3.0 * m11, n2[9] - 3.0 * m22);
        [
            [i1, i11, i12, i111, i112, i122, i1111, i1112, i1122, i1222],
            [i2, i12, i22, i112, i122, i222, i1112, i1122, i1222, i2222],
        ]
    }
}

/// Returns the means of m·R along an edge for the monomials m in r = base + t·direction.
#[inline]
fn monomial_means(means: &EdgeMeans<f64>) -> Cubic {
    let ([o1, o2], [e1, e2], t) = (means.base, means.direction, means.by_r);
    // For each m, an array of the means of tᵏ·m·R for k = 0, 1, ..., up to the highest power that is needed.
    let by_1 = |low: [f64; 2]| o1 * low[0] + e1 * low[1];
    let by_2 = |low: [f64; 2]| o2 * low[0] + e2 * low[1];
    let first = [0, 1, 2].map(|k| by_1([t[k], t[k + 1]]));
    let second = [0, 1, 2].map(|k| by_2([t[k], t[k + 1]]));
    let first_first = [0, 1].map(|k| by_1([first[k], first[k + 1]]));
    let first_second = [0, 1].map(|k| by_2([first[k], first[k + 1]]));
    let second_second = [0, 1].map(|k| by_2([second[k], second[k + 1]]));
    [
        t[0],
        first[0],
        second[0],
        first_first[0],
        first_second[0],
        second_second[0],
        by_1(first_first),
        by_2(first_first),
        by_2(first_second),
        by_2(second_second),
    ]
}

/// The means of g·tᵏ·u along an edge for k = 0, 1, 2, with y = base + t·direction.
struct EdgeFlux {
    base: Vector<f64>,
    direction: Vector<f64>,
    means: [[f64; 3]; 2],
}

impl EdgeFlux {
    #[inline]
    fn new(rotation: &Rotation<f64>, means: &EdgeMeans<f64>, load: &Load<f64>) -> Self {
        let ([o1, o2], [e1, e2]) = (means.base, means.direction);
        let base = [rotation.center[0] + o1, rotation.center[1] + o2];
        let along = |f: &Affine<f64>| {
            let at_base = f[0] + f[1] * base[0] + f[2] * base[1];
            [at_base, f[1] * e1 + f[2] * e2]
        };
        let ([p0, p1], [d0, d1]) = (along(load.pressure), along(load.damping));
        let g = [p0 * d0, p0 * d1 + p1 * d0, p1 * d1];
        // The means of g·tᵏ/R. The means of g·tᵏ·u follow from them, because u = sense·(−r₂, r₁)/R.
        let over_r = |k: usize| (0..3).map(|i| g[i] * means.over_r[k + i]).sum::<f64>();
        let over_r = [0, 1, 2, 3].map(over_r);
        let along = |o: f64, e: f64| {
            [0, 1, 2].map(|k| rotation.sense * (o * over_r[k] + e * over_r[k + 1]))
        };
        Self {
            base,
            direction: means.direction,
            means: [along(-o2, -e2), along(o1, e1)],
        }
    }

    /// Returns the means of g·m·u for the first six monomials m in y.
    #[inline]
    fn by_monomial(&self) -> [[f64; 6]; 2] {
        let ([o1, o2], [e1, e2]) = (self.base, self.direction);
        self.means.map(|t| {
            let first = [0, 1].map(|k| o1 * t[k] + e1 * t[k + 1]);
            let second = [0, 1].map(|k| o2 * t[k] + e2 * t[k + 1]);
            [
                t[0],
                first[0],
                second[0],
                o1 * first[0] + e1 * first[1],
                o2 * first[0] + e2 * first[1],
                o2 * second[0] + e2 * second[1],
            ]
        })
    }
}

impl Rotation<f64> {
    /// Converts ∫ f·m(r) dA to sense·∫ f·m(y) dA for all monomials m, with y = center + r. In each coordinate, yᵏ = (center + r)ᵏ is
    /// expanded by k passes of Horner's scheme, each of which adds a multiple of the next lower monomial.
    fn about_origin(&self, moments: Cubic) -> Cubic {
        let mut m = moments.map(|x| self.sense * x);
        let [c1, c2] = self.center;
        // Each pair contains the index of a monomial, and the index of this monomial divided by the coordinate. Higher powers come first.
        for chains in [
            (c1, [[6, 3], [3, 1], [1, 0], [7, 4], [4, 2], [8, 5]]),
            (c2, [[9, 5], [5, 2], [2, 0], [8, 4], [4, 1], [7, 3]]),
        ] {
            let (c, steps) = chains;
            for [high, low] in steps {
                m[high] += c * m[low];
            }
            for [high, low] in [steps[0], steps[1], steps[3]] {
                m[high] += c * m[low];
            }
            let [high, low] = steps[0];
            m[high] += c * m[low];
        }
        m
    }
}

/// Returns ∫ g·m·(u uᵀ − 1)/σ dA by the divergence theorem.
///
/// Because ∂u/∂y₁ = w·∂u/∂s₂, ∂u/∂y₂ = −w·∂u/∂s₁ and ∂u/∂s = (1 − u uᵀ)/σ, the integrals D_k = ∫ g·m·∂u/∂y_k dA = ∮ n_k·g·m·u dl − ∫
/// ∂(g·m)/∂y_k·u dA give the columns of the result: the first is D₂/w, and the second is −D₁/w.
fn by_slip(
    direction: &[Cubic; 2],
    g: &Quadratic<f64>,
    fluxes: &[[[f64; 6]; 2]; 2],
    spin: f64,
) -> [[f64; 6]; 3] {
    let inner = direction.each_ref().map(|u| load_slopes(u, g));
    let per_spin = spin.recip();
    let d = |k: usize, j: usize, m: usize| (fluxes[k][j][m] - inner[j][k][m]) * per_spin;
    let monomials = [0, 1, 2, 3, 4, 5];
    [
        monomials.map(|m| d(1, 0, m)),
        // This is the mean of two equal expressions for the entry 12. They are equal because the divergence of u is zero.
        monomials.map(|m| 0.5 * (d(1, 1, m) - d(0, 0, m))),
        monomials.map(|m| -d(0, 1, m)),
    ]
}

/// Returns ∫ ∂(g·m)/∂y_k·u dA for k = 1, 2 and the first six m. Here `u` are the moments ∫ m·u dA of one component of u.
fn load_slopes(u: &Cubic, g: &Quadratic<f64>) -> [[f64; 6]; 2] {
    let slopes = [[g[1], 2.0 * g[3], g[4]], [g[2], g[4], 2.0 * g[5]]];
    let [constant, first, second] = load_moments(u, g);
    let of_monomial = [
        [0.0, constant, 0.0, 2.0 * first, second, 0.0],
        [0.0, 0.0, constant, 0.0, first, 2.0 * second],
    ];
    let mut sums = of_monomial;
    for (sum, slope) in sums.iter_mut().zip(slopes) {
        for (m, [first, second]) in RAISED.into_iter().enumerate() {
            sum[m] += slope[0] * u[m] + slope[1] * u[first] + slope[2] * u[second];
        }
    }
    sums
}

/// Returns ∫ g·m·u dA for m = 1, y₁, y₂ and one component of u.
fn load_moments(u: &Cubic, g: &Quadratic<f64>) -> [f64; 3] {
    let all = (0..6).map(|m| g[m] * u[m]).sum();
    let raised = |i: usize| (0..6).map(|m| g[m] * u[RAISED[m][i]]).sum();
    [all, raised(0), raised(1)]
}
