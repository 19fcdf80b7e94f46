use crate::scalar::{Scalar, lift, real_part};
use nalgebra::{Matrix3, Vector3};

/// Below this squared angle (rad²) the exponential map is evaluated by its series.
const SERIES_LIMIT: f64 = 0.25;

/// Terms of the series: the first one left out is below 1e-19 at [`SERIES_LIMIT`].
const SERIES_TERMS: u32 = 9;

/// The skew-symmetric matrix `S` of a vector, with `S·x = vector × x`.
#[must_use]
pub fn skew<T: Scalar>(vector: &Vector3<T>) -> Matrix3<T> {
    let zero = lift(0.0);
    Matrix3::new(
        zero, -vector.z, vector.y, //
        vector.z, zero, -vector.x, //
        -vector.y, vector.x, zero,
    )
}

/// The rotation by `|rotation_vector|` radians about the direction of `rotation_vector`: the
/// exponential map exp(S) = I + (sin θ/θ)·S + ((1 − cos θ)/θ²)·S² of the paper, §V.
///
/// Both coefficients are series in θ² near zero, so all derivatives exist there. Nothing else in
/// the library makes a rotation from a vector.
#[must_use]
pub fn rotation_from_vector<T: Scalar>(rotation_vector: &Vector3<T>) -> Matrix3<T> {
    let angle_squared = rotation_vector.dot(rotation_vector);
    let (sine_term, cosine_term) = exponential_coefficients(angle_squared);
    let s = skew(rotation_vector);
    Matrix3::identity() + s * sine_term + s * s * cosine_term
}

/// (sin θ/θ, (1 − cos θ)/θ²) as functions of θ².
fn exponential_coefficients<T: Scalar>(angle_squared: T) -> (T, T) {
    if real_part(angle_squared) < SERIES_LIMIT {
        return (
            alternating_series(angle_squared, 1),
            alternating_series(angle_squared, 2),
        );
    }
    let angle = angle_squared.sqrt();
    (
        angle.sin() / angle,
        (-angle.cos() + lift::<T>(1.0)) / angle_squared,
    )
}

/// Σₙ (−x)ⁿ/(2n + first)! by Horner's rule: sin θ/θ for `first` = 1, (1 − cos θ)/θ² for 2.
fn alternating_series<T: Scalar>(x: T, first: u32) -> T {
    let one: T = lift(1.0);
    let sum = (1..=SERIES_TERMS).rev().fold(one, |tail, n| {
        one - x * tail / f64::from((2 * n + first - 1) * (2 * n + first))
    });
    sum / f64::from(first)
}
