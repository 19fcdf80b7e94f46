use super::friction::{Affine, PLANE_CAPACITY};
use super::polygon::CutPolygon;
use super::surface_law::RelativeMotion;
use crate::narrow_phase::EquilibriumPlane;
use crate::scalar::{Scalar, change, lift, lift_vector, real_part, real_vector};
use nalgebra::{Matrix3, Vector3};

/// The coefficients of a polynomial of degree two, or moments by its monomials: 1, y₁, y₂, y₁², y₁y₂, y₂².
pub(super) type Quadratic<T> = [T; 6];

/// A polygon is a sliver if its area is less than this fraction of its length squared: its centroid is round-off.
const SLIVER: f64 = 1e-9;

/// Where in an edge a rule of two points looks, from its start: exact for cubic polynomials.
const TWO_POINTS: [f64; 2] = [0.211_324_865_405_187_1, 0.788_675_134_594_812_9];

/// A contact polygon in coordinates y of its own plane: along the axes e₁ and e₂, n being the third, from a center.
pub(super) struct PlanePolygon<T> {
    /// e₁, e₂ and n as columns, in A's axes.
    pub axes: Matrix3<T>,
    /// Where y is zero (m), in A's frame: it moves with the plane along its normal only.
    pub center: Vector3<T>,
    pub outline: Outline<T>,
    /// The pressure (Pa).
    pub pressure: Affine<T>,
    /// The velocity of A relative to B at the center, and its angular velocity, along the axes.
    pub velocity: [T; 3],
    pub angular: [T; 3],
}

/// The corners of a polygon in a plane, counter-clockwise.
#[derive(Clone, Copy)]
pub(super) struct Outline<T> {
    corners: [[T; 2]; PLANE_CAPACITY],
    /// The edge of the contact polygon that the edge from each corner to the next is a part of; none where it was cut.
    edges: [u8; PLANE_CAPACITY],
    len: usize,
}

/// The number of an edge that is no part of one of the contact polygon's.
pub(super) const NO_EDGE: u8 = u8::MAX;

impl<T: Scalar> PlanePolygon<T> {
    pub fn of(polygon: &CutPolygon<T>, motion: &RelativeMotion<T>) -> Option<Self> {
        let constant = lift_vector::<T>(&center_of(polygon)?);
        let EquilibriumPlane { normal, steepness } = &polygon.plane;
        let excess = polygon.pressure_a.at(&constant) - polygon.pressure_b.at(&constant);
        let center = constant - normal * (change(excess) / *steepness);
        let axes = axes_about(normal);
        let along = |vector: &Vector3<T>| {
            let [e1, e2, n] = [0, 1, 2].map(|axis| axes.column(axis).dot(vector));
            [e1, e2, n]
        };
        let mut outline = Outline::empty();
        for (edge, corner) in (0..).zip(polygon.polygon.corners()) {
            let [y1, y2, _] = along(&(corner - center));
            outline.push([y1, y2], edge);
        }
        let [p1, p2, _] = along(&polygon.pressure.gradient);
        Some(Self {
            axes,
            center,
            outline,
            pressure: [polygon.pressure.at(&center), p1, p2],
            velocity: along(&motion.at(&center)),
            angular: along(&motion.angular),
        })
    }

    /// 1 − d v₃, the factor of the pressure by Hunt and Crossley: v₃ = v·n.
    pub fn damping(&self, dissipation: T) -> Affine<T> {
        let [v0, v1, v2] = self.separating();
        [
            -(dissipation * v0) + 1.0,
            -(dissipation * v1),
            -(dissipation * v2),
        ]
    }

    /// v₃, positive where the surfaces part.
    pub fn separating(&self) -> Affine<T> {
        [self.velocity[2], -self.angular[1], self.angular[0]]
    }
}

/// A point in the polygon, or at least near it.
fn center_of<T: Scalar>(polygon: &CutPolygon<T>) -> Option<Vector3<f64>> {
    let corners = polygon.polygon.corners();
    let first = real_vector(corners.first()?);
    let square = |corner: &Vector3<T>| (real_vector(corner) - first).norm_squared();
    let length_squared = corners.iter().map(square).fold(0.0, f64::max);
    let moments = &polygon.moments;
    let area = real_part(moments.area);
    Some(if area > SLIVER * length_squared {
        real_vector(&moments.reference) + real_vector(&moments.first) / area
    } else {
        first
    })
}

/// Orthonormal axes of which the third is this unit vector, without a root \[Duff 2017\].
fn axes_about<T: Scalar>(n: &Vector3<T>) -> Matrix3<T> {
    let sign = if real_part(n.z) >= 0.0 { 1.0 } else { -1.0 };
    let a = -(n.z + sign).recip();
    let b = n.x * n.y * a;
    let e1 = Vector3::new(n.x * n.x * a * sign + 1.0, b * sign, -n.x * sign);
    let e2 = Vector3::new(b, n.y * n.y * a + sign, -n.y);
    Matrix3::from_columns(&[e1, e2, *n])
}

impl<T: Scalar> Outline<T> {
    fn empty() -> Self {
        Self {
            corners: [[lift(0.0); 2]; PLANE_CAPACITY],
            edges: [NO_EDGE; PLANE_CAPACITY],
            len: 0,
        }
    }

    /// A full outline drops corners, which are copies by round-off (see
    /// [`ConvexPolygon`](crate::geometry::ConvexPolygon)).
    fn push(&mut self, corner: [T; 2], edge: u8) {
        if self.len < PLANE_CAPACITY {
            self.corners[self.len] = corner;
            self.edges[self.len] = edge;
            self.len += 1;
        }
    }

    pub fn corners(&self) -> &[[T; 2]] {
        &self.corners[..self.len]
    }

    /// For the edge from each corner to the next, the edge of the contact polygon that it is a part of, or [`NO_EDGE`].
    pub fn edges(&self) -> &[u8] {
        &self.edges[..self.len]
    }

    /// The part where an affine function is not negative; none if that is everything.
    pub fn cut(&self, function: &Affine<T>) -> Option<Self> {
        let values = self.corners.map(|y| at(function, &y));
        let is_inside = |corner: usize| real_part(values[corner]) >= 0.0;
        if (0..self.len).all(is_inside) {
            return None;
        }
        let mut part = Self::empty();
        let mut before = self.len - 1;
        for now in 0..self.len {
            if is_inside(before) != is_inside(now) {
                let share = values[before] / (values[before] - values[now]);
                let [from, to] = [self.corners[before], self.corners[now]];
                let crossing = [0, 1].map(|i| from[i] + (to[i] - from[i]) * share);
                let enters = is_inside(now);
                part.push(crossing, if enters { self.edges[before] } else { NO_EDGE });
            }
            if is_inside(now) {
                part.push(self.corners[now], self.edges[now]);
            }
            before = now;
        }
        Some(part)
    }

    /// ∫ m dA for the ten monomials m of degree three at most, in the order of [`place`]: as m is homogeneous of degree
    /// d, (d + 2)∫ m dA = ∮ m y·ν dl by the divergence theorem, ν being the outward normal.
    pub fn moments(&self) -> [T; 10] {
        let mut moments = [lift::<T>(0.0); 10];
        let corners = self.corners();
        for (number, a) in corners.iter().enumerate() {
            let b = &corners[if number + 1 == corners.len() {
                0
            } else {
                number + 1
            }];
            let half_turn = (a[0] * b[1] - a[1] * b[0]) * 0.5;
            for share in TWO_POINTS {
                let y = [0, 1].map(|i| a[i] + (b[i] - a[i]) * share);
                for (moment, value) in moments.iter_mut().zip(monomials(&y, half_turn)) {
                    *moment += value;
                }
            }
        }
        for (moment, degree) in moments.iter_mut().zip([0, 1, 1, 2, 2, 2, 3, 3, 3, 3]) {
            *moment /= f64::from(degree + 2);
        }
        moments
    }
}

/// The ten monomials of degree three at most at a point, times a factor.
pub(super) fn monomials<T: Scalar>([y1, y2]: &[T; 2], factor: T) -> [T; 10] {
    let (a, b) = (factor * *y1, factor * *y2);
    let (aa, ab, bb) = (a * *y1, a * *y2, b * *y2);
    [
        factor,
        a,
        b,
        aa,
        ab,
        bb,
        aa * *y1,
        aa * *y2,
        ab * *y2,
        bb * *y2,
    ]
}

/// The place of y₁ᵃy₂ᵇ among the monomials.
pub(super) const fn place(a: usize, b: usize) -> usize {
    (a + b) * (a + b + 1) / 2 + b
}

/// The exponents of the first six monomials.
pub(super) const EXPONENTS: [[usize; 2]; 6] = [[0, 0], [1, 0], [0, 1], [2, 0], [1, 1], [0, 2]];

/// The value of an affine function at a point.
pub(super) fn at<T: Scalar>(function: &Affine<T>, y: &[T; 2]) -> T {
    function[0] + function[1] * y[0] + function[2] * y[1]
}

/// The product of two affine functions.
pub(super) fn product<T: Scalar>(f: &Affine<T>, g: &Affine<T>) -> Quadratic<T> {
    [
        f[0] * g[0],
        f[0] * g[1] + f[1] * g[0],
        f[0] * g[2] + f[2] * g[0],
        f[1] * g[1],
        f[1] * g[2] + f[2] * g[1],
        f[2] * g[2],
    ]
}

/// ∫ f m for a polynomial f of three (affine) or six coefficients and the monomial m with these exponents, from the
/// moments by monomials.
pub(super) fn moment_of<T: Scalar>(f: &[T], moments: &[T; 10], [a, b]: [usize; 2]) -> T {
    let terms = f.iter().zip(EXPONENTS);
    terms
        .map(|(coefficient, [i, j])| *coefficient * moments[place(a + i, b + j)])
        .sum()
}
