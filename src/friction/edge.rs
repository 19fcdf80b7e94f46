use super::rules::EDGE_8;
use crate::scalar::portable::ln_1p;
use crate::scalar::{Scalar, lift, real_part};

/// A vector in the plane of the polygon.
pub(super) type Vector<T> = [T; 2];

/// An edge shorter than this fraction of its distance R is integrated by the rule of eight points, to 4e-15. The closed form divides by the
/// length, which would make the derivatives of a short edge far away inaccurate.
const SHORT: f64 = 0.5;

/// Terms of the integrals along an edge from a to b.
///
/// Positions are measured from the center of rotation, r(t) = base + t·direction, and R = √(r·r + ε²). All numbers are means over the edge,
/// so they are also defined for an edge without length. The polygon's derivative needs them if two corners coincide and move apart.
pub(super) struct EdgeMeans<T> {
    pub base: Vector<T>,
    pub direction: Vector<T>,
    /// The means of tᵏ/R.
    pub over_r: [T; 6],
    /// The means of tᵏR.
    pub by_r: [T; 4],
    /// The length, or 0 if the corners coincide.
    pub length: f64,
}

/// A corner of the polygon: its position from the center of rotation, and R there.
#[derive(Clone, Copy)]
pub(super) struct Corner<T> {
    pub position: Vector<T>,
    pub distance: T,
}

impl<T: Scalar> Corner<T> {
    #[inline]
    pub fn new(position: Vector<T>, epsilon_squared: T) -> Self {
        let distance = (dot(position, position) + epsilon_squared).sqrt();
        Self { position, distance }
    }
}

impl<T: Scalar> EdgeMeans<T> {
    #[inline]
    pub fn new(a: &Corner<T>, b: &Corner<T>, epsilon_squared: T) -> Self {
        let span = [b.position[0] - a.position[0], b.position[1] - a.position[1]];
        let length_squared = real_part(dot(span, span));
        let distance = 0.5 * (real_part(a.distance) + real_part(b.distance));
        if length_squared > (SHORT * distance).powi(2) {
            Self::closed_form(a, b, epsilon_squared)
        } else {
            Self::by_rule(a.position, span, epsilon_squared)
        }
    }

    /// Computes the means in closed form. Let h be the distance of the edge's line, t_a and t_b the coordinates of the corners along it
    /// from the foot of the perpendicular, ℓ = t_b − t_a, and c² = h² + ε². Then R² = t² + c², and E_m = ∫ tᵐ/R dt follows from
    ///
    /// d(tᵐ⁻¹R)/dt = m·tᵐ/R + (m−1)·c²·tᵐ⁻²/R.
    #[inline]
    fn closed_form(a: &Corner<T>, b: &Corner<T>, epsilon_squared: T) -> Self {
        let span = [b.position[0] - a.position[0], b.position[1] - a.position[1]];
        let length = dot(span, span).sqrt();
        let per_length = length.recip();
        let direction = [span[0] * per_length, span[1] * per_length];
        let h = cross(a.position, b.position) * per_length;
        let (t_a, t_b) = (dot(a.position, direction), dot(b.position, direction));
        let c_squared = h * h + epsilon_squared;
        // R_a + t_a and R_b − t_b, both without cancellation.
        let from_a = sum_without_cancellation(a.distance, t_a, c_squared);
        let from_b = sum_without_cancellation(b.distance, -t_b, c_squared);
        let logarithm = ln_1p(length * 2.0 / (from_a + from_b));
        let mut over_r = [logarithm * per_length; 6];
        over_r[1] = (t_a + t_b) / (a.distance + b.distance);
        let (mut at_a, mut at_b) = (a.distance * per_length, b.distance * per_length);
        for m in 2..over_r.len() {
            (at_a, at_b) = (at_a * t_a, at_b * t_b);
            let below = c_squared * over_r[m - 2] * (m - 1) as f64;
            over_r[m] = (at_b - at_a - below) * (1.0 / m as f64);
        }
        Self {
            base: [h * direction[1], -h * direction[0]],
            direction,
            over_r,
            by_r: [0, 1, 2, 3].map(|k| over_r[k + 2] + c_squared * over_r[k]),
            length: real_part(length),
        }
    }

    /// Computes the means by quadrature. t is measured from the middle of the edge, from −1 to 1.
    #[inline]
    fn by_rule(a: Vector<T>, span: Vector<T>, epsilon_squared: T) -> Self {
        let direction = span.map(|component| component * 0.5);
        let base = [a[0] + direction[0], a[1] + direction[1]];
        let (mut over_r, mut by_r) = ([lift::<T>(0.0); 6], [lift::<T>(0.0); 4]);
        let points = EDGE_8
            .pairs()
            .iter()
            .flat_map(|[t, w]| [[t[0], w[0]], [t[1], w[1]]]);
        for [t, weight] in points {
            let position = [base[0] + direction[0] * t, base[1] + direction[1] * t];
            let squared = dot(position, position) + epsilon_squared;
            let inverse = squared.sqrt().recip();
            let mut powered = weight;
            for k in 0..over_r.len() {
                over_r[k] += inverse * powered;
                if k < by_r.len() {
                    by_r[k] += inverse * squared * powered;
                }
                powered *= t;
            }
        }
        Self {
            base,
            direction,
            over_r,
            by_r,
            length: real_part(dot(span, span)).sqrt(),
        }
    }
}

/// Returns R + t, where R² = t² + c².
#[inline]
fn sum_without_cancellation<T: Scalar>(root: T, t: T, c_squared: T) -> T {
    if real_part(t) > 0.0 {
        root + t
    } else {
        c_squared / (root - t)
    }
}

#[inline]
pub(super) fn dot<T: Scalar>(a: Vector<T>, b: Vector<T>) -> T {
    a[0] * b[0] + a[1] * b[1]
}

#[inline]
pub(super) fn cross<T: Scalar>(a: Vector<T>, b: Vector<T>) -> T {
    a[0] * b[1] - a[1] * b[0]
}
