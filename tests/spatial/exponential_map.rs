//! The exponential map of rotations and its derivatives.

use crate::samples_and_tolerances::{EXACT, ROUND_OFF, rotation_vectors};
use hydroelastic::scalar::lift_vector;
use hydroelastic::spatial::{rotation_from_vector, skew};
use nalgebra::{Matrix3, Rotation3, Vector3, vector};
use num_dual::{Dual2SVec64, Dual3_64, Dual64, DualSVec64, gradient, hessian, third_derivative};

/// Relative rounding error of an angle and of its sine. The error of a rotation grows with the angle.
const ANGLE_ROUND_OFF: f64 = 1e-15;

/// Step of central differences and their error: the squared step times a third derivative of order one, and round-off divided by the step.
const STEP: f64 = 1e-5;
const DIFFERENCE_ERROR: f64 = 1e-9;

#[test]
fn skew_matrix_takes_the_cross_product() {
    let (a, b) = (vector![1.0, -2.0, 3.0], vector![0.5, 0.7, -0.2]);
    assert!((skew(&a) * b - a.cross(&b)).amax() <= ROUND_OFF);
}

#[test]
fn exponential_map_agrees_with_nalgebra() {
    assert_eq!(
        rotation_from_vector(&Vector3::<f64>::zeros()),
        Matrix3::identity()
    );
    for vector in rotation_vectors() {
        let expected = Rotation3::new(vector).into_inner();
        let error = (rotation_from_vector(&vector) - expected).amax();
        let tolerance = ANGLE_ROUND_OFF * vector.norm().max(1.0);
        assert!(error <= tolerance, "{error:e} at {vector:?}");
    }
}

#[test]
fn small_rotations_keep_their_relative_accuracy() {
    let vector = vector![3e-13, -4e-13, 1.2e-12];
    let rotation = rotation_from_vector(&vector);
    // The off-diagonal entries are R = S + S²/2. The quadratic term is 1e-12 of the linear term.
    let relative = (rotation - skew(&vector) - Matrix3::identity()).amax() / vector.norm();
    assert!(relative <= 1e-12, "{relative:e}");
}

/// Returns ∂R/∂vₖ from the columns of the left Jacobian J of SO(3): ∂R/∂vₖ = [J eₖ]ₓ R with J = I + (1 − cos θ)/θ²·S + (θ − sin θ)/θ³·S².
fn derivative_of_rotation(v: &Vector3<f64>, k: usize) -> Matrix3<f64> {
    let (angle, s) = (v.norm(), skew(v));
    let jacobian = Matrix3::identity()
        + s * ((1.0 - angle.cos()) / angle.powi(2))
        + s * s * ((angle - angle.sin()) / angle.powi(3));
    skew(&jacobian.column(k).into_owned()) * Rotation3::new(*v).into_inner()
}

/// Returns rotation vectors that are large enough for the closed form of J without cancellation.
fn ordinary_rotation_vectors() -> Vec<Vector3<f64>> {
    vec![
        vector![0.1, -0.3, 0.2],
        vector![0.3, 0.3, 0.263],
        vector![0.3, 0.3, 0.265],
        vector![0.9, -0.2, 0.4],
        vector![-1.0, 2.0, 1.5],
        vector![3.0, 4.0, -2.0],
    ]
}

#[test]
fn first_derivatives_of_the_exponential_map_agree_with_the_closed_form() {
    for v in ordinary_rotation_vectors() {
        for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
            let entry = |x: Vector3<DualSVec64<3>>| rotation_from_vector(&x)[(i, j)];
            let (value, slope) = gradient(entry, &v);
            assert!((value - Rotation3::new(v)[(i, j)]).abs() <= EXACT);
            let expected = Vector3::from_fn(|k, _| derivative_of_rotation(&v, k)[(i, j)]);
            assert!(
                (slope - expected).amax() <= EXACT,
                "{:e}",
                (slope - expected).amax()
            );
        }
    }
}

#[test]
fn first_derivatives_of_the_exponential_map_agree_with_differences() {
    for v in rotation_vectors() {
        for k in 0..3 {
            let seeded = |x: Dual64| {
                let mut moved = lift_vector::<Dual64>(&v);
                moved[k] = x;
                rotation_from_vector(&moved).map(|entry| entry.eps)
            };
            let slope = seeded(Dual64::new(v[k], 1.0));
            let step = Vector3::ith(k, STEP);
            let (after, before) = (
                rotation_from_vector(&(v + step)),
                rotation_from_vector(&(v - step)),
            );
            let difference = (after - before) / (2.0 * STEP);
            assert!(
                (slope - difference).amax() <= DIFFERENCE_ERROR,
                "{:e} at {v:?}",
                (slope - difference).amax()
            );
        }
    }
}

#[test]
fn derivatives_of_the_exponential_map_at_zero_are_those_of_its_series() {
    let generators: [Matrix3<f64>; 3] = std::array::from_fn(|k| skew(&Vector3::ith(k, 1.0)));
    for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
        let entry = |x: Vector3<Dual2SVec64<3>>| rotation_from_vector(&x)[(i, j)];
        let (value, slope, curvature) = hessian(entry, &Vector3::zeros());
        assert_eq!(value.to_bits(), f64::from(u8::from(i == j)).to_bits());
        // exp(S) = I + S + S²/2 + …
        let expected = Vector3::from_fn(|k, _| generators[k][(i, j)]);
        assert!((slope - expected).amax() <= ROUND_OFF);
        let expected = Matrix3::from_fn(|k, l| {
            let (a, b) = (generators[k], generators[l]);
            ((a * b + b * a) * 0.5)[(i, j)]
        });
        assert!((curvature - expected).amax() <= ROUND_OFF);
    }
}

#[test]
fn second_derivatives_of_the_exponential_map_agree_with_differences_of_the_closed_form() {
    for v in ordinary_rotation_vectors() {
        for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
            let entry = |x: Vector3<Dual2SVec64<3>>| rotation_from_vector(&x)[(i, j)];
            let (_, _, curvature) = hessian(entry, &v);
            let expected = Matrix3::from_fn(|k, l| {
                let step = Vector3::ith(l, STEP);
                let slope_at = |x: Vector3<f64>| derivative_of_rotation(&x, k)[(i, j)];
                (slope_at(v + step) - slope_at(v - step)) / (2.0 * STEP)
            });
            assert!(
                (curvature - expected).amax() <= DIFFERENCE_ERROR,
                "{:e}",
                (curvature - expected).amax()
            );
        }
    }
}

#[test]
fn derivatives_about_a_fixed_axis_are_powers_of_its_generator() {
    let axis = vector![0.48, -0.6, 0.64];
    // The angles are on both sides of the limit of the series, and at zero.
    for angle in [0.0, 1e-9, 0.3, 0.499_999, 0.500_001, 1.0, 3.0] {
        for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
            let (_, first, second, third) = third_derivative(
                |x: Dual3_64| {
                    let vector = lift_vector::<Dual3_64>(&axis) * x;
                    rotation_from_vector(&vector)[(i, j)]
                },
                angle,
            );
            // d/dθ exp(θ S) = S exp(θ S).
            let (s, rotation) = (skew(&axis), Rotation3::new(axis * angle).into_inner());
            for (coefficient, power) in [(first, s), (second, s * s), (third, s * s * s)] {
                let error = (coefficient - (power * rotation)[(i, j)]).abs();
                assert!(error <= EXACT, "{error:e} at {angle}");
            }
        }
    }
}
