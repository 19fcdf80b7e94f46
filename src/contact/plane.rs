use super::friction::{Affine, Quadratic, ends};
use super::motion::RelativeMotion;
use super::plane_motion::PlaneMotion;
use super::polygon::CutPolygon;
use crate::geometry::POLYGON_CAPACITY;
use crate::scalar::{Scalar, change, lift, lift_vector, real_part, real_vector};
use nalgebra::{Matrix3, Vector3};

/// A polygon is a sliver if its area is less than this fraction of its length squared: its centroid is round-off.
const SLIVER: f64 = 1e-9;

/// Where in an edge a rule of two points looks, from its start: exact for cubic polynomials.
const TWO_POINTS: [f64; 2] = [0.211_324_865_405_187_1, 0.788_675_134_594_812_9];

/// Room for the corners of a contact polygon that is cut once more.
const PLANE_CAPACITY: usize = POLYGON_CAPACITY + 1;

/// A contact polygon in coordinates y of its own plane: along the axes e₁ and e₂, n being the third, from a center.
#[derive(Clone)]
pub(super) struct PlanePolygon<T> {
    /// e₁, e₂ and n as columns, in A's axes.
    pub axes: Matrix3<T>,
    /// Where y is zero (m), in A's frame: it moves with the plane along its normal only.
    pub center: Vector3<T>,
    pub outline: Outline<T>,
    /// The pressure (Pa).
    pub pressure: Affine<T>,
    pub motion: PlaneMotion<T>,
}

/// The corners of a polygon in a plane, counter-clockwise.
#[derive(Clone, Copy)]
pub(super) struct Outline<T> {
    corners: [[T; 2]; PLANE_CAPACITY],
    /// The edge of the contact polygon that the edge from each corner to the next is a part of; [`NO_EDGE`] where it was cut.
    edges: [u8; PLANE_CAPACITY],
    len: usize,
}

/// The number of an edge that is no part of one of the contact polygon's.
pub(super) const NO_EDGE: u8 = u8::MAX;

impl<T: Scalar> PlanePolygon<T> {
    /// The polygon in its plane, if it has a corner.
    pub fn of(polygon: &CutPolygon<T>, motion: &RelativeMotion<T>) -> Option<Self> {
        let constant = lift_vector::<T>(&center_of(polygon)?);
        let normal = &polygon.plane.normal;
        let center = constant - normal * change(polygon.plane.height_at(&constant));
        let axes = axes_about(normal);
        let [e1, e2] = [0, 1].map(|axis| axes.column(axis).into_owned());
        let mut outline = Outline::empty();
        for (edge, corner) in (0..).zip(polygon.polygon.corners()) {
            let y = corner - center;
            outline.push([e1.dot(&y), e2.dot(&y)], edge);
        }
        let gradient = &polygon.pressure.gradient;
        Some(Self {
            motion: PlaneMotion::of(motion, &axes, &center),
            axes,
            center,
            outline,
            pressure: [
                polygon.pressure.at(&center),
                e1.dot(gradient),
                e2.dot(gradient),
            ],
        })
    }

    /// Takes another velocity of A relative to B.
    pub fn move_with(&mut self, motion: &RelativeMotion<T>) {
        self.motion = PlaneMotion::of(motion, &self.axes, &self.center);
    }
}

/// The centroid of the polygon; of a sliver, whose centroid is round-off, its first corner.
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

/// Orthonormal axes of which the third is this unit vector, without a square root \[Duff 2017\].
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

    /// The part where an affine function is not negative; `None` if that is everything.
    pub fn cut(&self, function: &Affine<T>) -> Option<Self> {
        let is_in = |y: &[T; 2]| real_part(at(function, y)) >= 0.0;
        if self.corners().iter().all(is_in) {
            return None;
        }
        let values = self.corners.map(|y| at(function, &y));
        let is_inside = |corner: usize| real_part(values[corner]) >= 0.0;
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

    /// ∫ m dA for the ten monomials m of degree three at most, 1, y₁, y₂, y₁² and so on: as m is homogeneous of degree
    /// d, (d + 2)∫ m dA = ∮ m y·ν dl by the divergence theorem, ν being the outward normal.
    pub fn moments(&self) -> [T; 10] {
        let mut moments = [lift::<T>(0.0); 10];
        let corners = self.corners();
        for edge in 0..corners.len() {
            let [a, b] = ends(corners, edge);
            let half_turn = (a[0] * b[1] - a[1] * b[0]) * 0.5;
            for share in TWO_POINTS {
                let y = [0, 1].map(|i| a[i] + (b[i] - a[i]) * share);
                for (moment, value) in moments.iter_mut().zip(&up_to_cubic(half_turn, &y)) {
                    *moment += *value;
                }
            }
        }
        for (moment, factor) in moments.iter_mut().zip(&PER_DEGREE) {
            *moment *= *factor;
        }
        moments
    }
}

/// The six monomials of degree two at most at a point, times a factor.
#[inline]
pub(super) fn up_to_quadratic<T: Scalar>(factor: T, [y1, y2]: &[T; 2]) -> [T; 6] {
    let (a, b) = (factor * *y1, factor * *y2);
    [factor, a, b, a * *y1, a * *y2, b * *y2]
}

/// The ten monomials of degree three at most at a point, times a factor.
#[inline]
fn up_to_cubic<T: Scalar>(factor: T, y: &[T; 2]) -> [T; 10] {
    let [y1, y2] = y;
    let [factor, a, b, aa, ab, bb] = up_to_quadratic(factor, y);
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

/// 1/(d + 2) for the ten monomials.
const PER_DEGREE: [f64; 10] = [
    1.0 / 2.0,
    1.0 / 3.0,
    1.0 / 3.0,
    1.0 / 4.0,
    1.0 / 4.0,
    1.0 / 4.0,
    1.0 / 5.0,
    1.0 / 5.0,
    1.0 / 5.0,
    1.0 / 5.0,
];

/// The places of m times the first six monomials, for m = 1, y₁ and y₂.
const BY_QUADRATIC: [[usize; 6]; 3] = [[0, 1, 2, 3, 4, 5], [1, 3, 4, 6, 7, 8], [2, 4, 5, 7, 8, 9]];

/// ∫ f m for a quadratic f and m = 1, y₁ and y₂.
#[inline]
pub(super) fn quadratic_moments<T: Scalar>(f: &Quadratic<T>, moments: &[T; 10]) -> [T; 3] {
    BY_QUADRATIC.map(|places| {
        let term = |k: usize| f[k] * moments[places[k]];
        (term(0) + term(1)) + (term(2) + term(3)) + (term(4) + term(5))
    })
}

/// The value of an affine function at a point.
pub(super) fn at<T: Scalar>(function: &Affine<T>, y: &[T; 2]) -> T {
    function[0] + function[1] * y[0] + function[2] * y[1]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Round-off may bend an outline so that a line cuts it many times.
    #[test]
    fn an_outline_that_is_cut_into_more_corners_than_it_has_room_for_drops_some() {
        let mut zigzag = Outline::<f64>::empty();
        for edge in 0..12 {
            let aside = if edge % 2 == 0 { 1.0 } else { -1.0 };
            zigzag.push([f64::from(edge), aside], edge);
        }
        let part = zigzag.cut(&[0.0, 0.0, 1.0]).unwrap();
        // Each of 12 edges is cut, and 6 corners are inside.
        assert_eq!(part.corners().len(), PLANE_CAPACITY);
        assert_eq!(part.edges().len(), PLANE_CAPACITY);
        assert!(part.corners().iter().all(|[_, y2]| *y2 >= 0.0));
    }
}
