use crate::scalar::portable::sin_cos;
use crate::scalar::{
    Order, Scalar, change, constant_times, cross_constant, dot_constant, lift, real_part,
    real_vector,
};
use nalgebra::{Matrix3, RowVector3, SMatrix, Vector3};

/// Squared angle (rad²) below which the exponential map is evaluated by its series.
const SERIES_LIMIT: f64 = 0.25;

/// Number of terms of the series. The first omitted term is below 1e-19 at [`SERIES_LIMIT`].
const SERIES_TERMS: u32 = 9;

/// Returns the skew-symmetric matrix `S` of a vector, with `S·x = vector × x`.
#[must_use]
pub fn skew<T: Scalar>(vector: &Vector3<T>) -> Matrix3<T> {
    let zero = lift(0.0);
    Matrix3::new(
        zero, -vector.z, vector.y, //
        vector.z, zero, -vector.x, //
        -vector.y, vector.x, zero,
    )
}

/// Adds a 3×3 block at the given row and column.
pub(crate) fn add_block<T: Scalar, const R: usize, const C: usize>(
    matrix: &mut SMatrix<T, R, C>,
    [row, column]: [usize; 2],
    block: Matrix3<T>,
) {
    let mut view = matrix.fixed_view_mut::<3, 3>(row, column);
    view += block;
}

/// Returns the rotation by `|rotation_vector|` radians about the direction of `rotation_vector`.
/// This is the exponential map exp(S) = I + (sin θ/θ)·S + ((1 − cos θ)/θ²)·S² of the paper, §V.
///
/// Near zero, both coefficients are evaluated as series in θ², so all derivatives exist there. The
/// library has no other function that creates a rotation from a vector.
///
/// With v the vector, S² = v vᵀ − θ²·I. This formula takes twelve products, fewer than a matrix
/// product.
#[must_use]
pub fn rotation_from_vector<T: Scalar>(rotation_vector: &Vector3<T>) -> Matrix3<T> {
    if Order::<T>::IS_FIRST {
        let real = real_vector(rotation_vector);
        let turn = constant_times(
            &left_jacobian(&real),
            &(rotation_vector - real.map(lift::<T>)),
        );
        return turned_real(&rotation_from_vector(&real), &turn);
    }
    let v = rotation_vector;
    let (sine_term, cosine_term) = exponential_coefficients(v.dot(v));
    let (sine, cosine) = (v * sine_term, v * cosine_term);
    let [xx, yy, zz] = [cosine.x * v.x, cosine.y * v.y, cosine.z * v.z];
    let [xy, xz, yz] = [cosine.x * v.y, cosine.x * v.z, cosine.y * v.z];
    let one: T = lift(1.0);
    let [x, y, z] = [one - (yy + zz), one - (xx + zz), one - (xx + yy)];
    Matrix3::from_rows(&[
        RowVector3::new(x, xy - sine.z, xz + sine.y),
        RowVector3::new(xy + sine.z, y, yz - sine.x),
        RowVector3::new(xz - sine.y, yz + sine.x, z),
    ])
}

/// Returns exp(\[v\]ₓ)·R: the rotation R, rotated by the rotation vector v (rad) in the axes of the
/// outer frame.
pub(crate) fn turned_by<T: Scalar>(
    rotation: &Matrix3<T>,
    rotation_vector: &Vector3<T>,
) -> Matrix3<T> {
    if Order::<T>::IS_FIRST {
        let vector = real_vector(rotation_vector);
        let by = rotation_from_vector(&vector);
        let turn = constant_times(&left_jacobian(&vector), &rotation_vector.map(change))
            + constant_times(&by, &turn_from_real(rotation));
        return turned_real(&(by * rotation.map(real_part)), &turn);
    }
    rotation_from_vector(rotation_vector) * rotation
}

/// Rotates a frame, given by its axes as columns, about one of its own axes by an angle (rad).
pub(crate) fn turned_about_own_axis<T: Scalar>(
    frame: &Matrix3<T>,
    axis: usize,
    angle: T,
) -> Matrix3<T> {
    let (sine, cosine) = sin_cos(angle);
    let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
    let (first, second) = (frame.column(next), frame.column(last));
    let mut turned = *frame;
    turned.set_column(next, &(first * cosine + second * sine));
    turned.set_column(last, &(second * cosine - first * sine));
    turned
}

/// Multiplies by a constant matrix, with 27 products `T * f64` instead of `T * T`.
pub(crate) fn times_constant<T: Scalar>(
    matrix: &Matrix3<T>,
    constant: &Matrix3<f64>,
) -> Matrix3<T> {
    Matrix3::from_fn(|i, j| {
        matrix[(i, 0)] * constant[(0, j)]
            + matrix[(i, 1)] * constant[(1, j)]
            + matrix[(i, 2)] * constant[(2, j)]
    })
}

/// Returns the left Jacobian J of the exponential map. To first order, exp(\[v + dv\]ₓ) = (I +
/// \[J·dv\]ₓ)·exp(\[v\]ₓ), with J = I + ((1 − cos θ)/θ²)·\[v\]ₓ + ((1 − sin θ/θ)/θ²)·\[v\]ₓ².
pub(crate) fn left_jacobian(rotation_vector: &Vector3<f64>) -> Matrix3<f64> {
    let angle_squared = rotation_vector.norm_squared();
    let (sine_term, cosine_term) = exponential_coefficients(angle_squared);
    let cubic_term = if angle_squared < SERIES_LIMIT {
        alternating_series(angle_squared, 3)
    } else {
        (1.0 - sine_term) / angle_squared
    };
    let s = skew(rotation_vector);
    Matrix3::identity() + s * cosine_term + s * s * cubic_term
}

/// Returns (I + \[turn\]ₓ)·R: a rotation R with the derivatives of a small rotation `turn` (rad).
/// `turn` is in the axes of the outer frame and has the real part zero.
pub(crate) fn turned_real<T: Scalar>(rotation: &Matrix3<f64>, turn: &Vector3<T>) -> Matrix3<T> {
    let column = |k: usize| {
        let axis = rotation.column(k).into_owned();
        let change = cross_constant(turn, &axis);
        Vector3::new(change.x + axis.x, change.y + axis.y, change.z + axis.z)
    };
    Matrix3::from_columns(&[column(0), column(1), column(2)])
}

/// Returns the small rotation (rad) from the real part of a rotation to the rotation. It is in the
/// axes of the outer frame and has the real part zero. Derivatives that are not tangent to the
/// rotations are dropped.
pub(crate) fn turn_from_real<T: Scalar>(rotation: &Matrix3<T>) -> Vector3<T> {
    // To first order, R = (I + [ω]ₓ)·R₀. So [ω]ₓ is the skew part of (R − R₀)·R₀ᵀ.
    let real = rotation.map(real_part);
    let entry = |i: usize, j: usize| {
        let row = rotation.row(i).transpose();
        dot_constant(&row, &real.row(j).transpose())
    };
    let half_skew = |i: usize, j: usize| {
        let twice = entry(i, j) - entry(j, i);
        (twice - real_part(twice)) * 0.5
    };
    Vector3::new(half_skew(2, 1), half_skew(0, 2), half_skew(1, 0))
}

/// Returns (sin θ/θ, (1 − cos θ)/θ²) as functions of θ².
fn exponential_coefficients<T: Scalar>(angle_squared: T) -> (T, T) {
    if real_part(angle_squared) < SERIES_LIMIT {
        return (
            alternating_series(angle_squared, 1),
            alternating_series(angle_squared, 2),
        );
    }
    let angle = angle_squared.sqrt();
    let (sine, cosine) = sin_cos(angle);
    (sine / angle, (-cosine + lift::<T>(1.0)) / angle_squared)
}

/// Evaluates Σₙ (−x)ⁿ/(2n + first)! by Horner's rule. With x = θ²:
///
/// - sin θ/θ for `first` = 1,
/// - (1 − cos θ)/θ² for `first` = 2,
/// - (θ − sin θ)/θ³ for `first` = 3.
fn alternating_series<T: Scalar>(x: T, first: u32) -> T {
    let one: T = lift(1.0);
    let sum = (1..=SERIES_TERMS).rev().fold(one, |tail, n| {
        one - x * tail * f64::from((2 * n + first - 1) * (2 * n + first)).recip()
    });
    sum * f64::from((1..=first).product::<u32>()).recip()
}
