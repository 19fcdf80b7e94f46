//! Scalars over which poses and wrenches are generic, and their derivatives.

use crate::samples_and_tolerances::ROUND_OFF;
use hydroelastic::scalar::{Scalar, lift, lift_vector, norm, real_part, real_vector};
use nalgebra::{Matrix3, SVector, Vector3, vector};
use num_dual::{
    Dual, Dual2, Dual2_64, Dual2SVec64, Dual3_64, Dual64, DualSVec64, HyperDual64, HyperDualSVec64,
    first_derivative, gradient, hessian, partial_hessian, second_derivative,
    second_partial_derivative, third_derivative,
};

// f(x) = x³ + sin x.
fn cubic_and_sine<T: Scalar>(x: T) -> T {
    x * x * x + x.sin()
}

/// Point at which the functions are evaluated.
const X: f64 = 0.7;

/// Returns f, f′, f″, f‴ at [`X`].
fn expected_derivatives() -> [f64; 4] {
    let (sine, cosine) = X.sin_cos();
    [
        X.powi(3) + sine,
        3.0 * X * X + cosine,
        6.0 * X - sine,
        6.0 - cosine,
    ]
}

fn assert_near(actual: &[f64], expected: &[f64]) {
    assert_eq!(actual.len(), expected.len());
    for (actual, expected) in actual.iter().zip(expected) {
        assert!(
            (actual - expected).abs() <= ROUND_OFF,
            "{actual} is not {expected}"
        );
    }
}

#[test]
fn scalars_of_one_variable_carry_the_derivatives_of_their_order() {
    let expected = expected_derivatives();
    assert_near(&[cubic_and_sine(X)], &expected[..1]);
    let (value, first) = first_derivative(cubic_and_sine::<Dual64>, X);
    assert_near(&[value, first], &expected[..2]);
    let (value, first, second) = second_derivative(cubic_and_sine::<Dual2_64>, X);
    assert_near(&[value, first, second], &expected[..3]);
    let (value, first, second, third) = third_derivative(cubic_and_sine::<Dual3_64>, X);
    assert_near(&[value, first, second, third], &expected);
}

#[test]
fn nested_scalars_carry_derivatives_of_derivatives() {
    let x = Dual2 {
        re: Dual::new(X, 1.0),
        v1: Dual::new(1.0, 0.0),
        v2: Dual::new(0.0, 0.0),
    };
    let y = cubic_and_sine::<Dual2<Dual64>>(x);
    assert_near(&[y.re.re, y.v1.re, y.v2.re], &expected_derivatives()[..3]);
    assert_near(
        &[y.re.eps, y.v1.eps, y.v2.eps],
        &expected_derivatives()[1..],
    );
    assert_near(&[real_part(y)], &expected_derivatives()[..1]);
}

// f(v) = x y² + sin z.
fn product_and_sine<T: Scalar>(v: &Vector3<T>) -> T {
    v.x * v.y * v.y + v.z.sin()
}

#[test]
fn scalars_of_many_variables_carry_gradients_and_hessians() {
    let v = vector![2.0, -3.0, X];
    let (sine, cosine) = X.sin_cos();
    let expected_gradient = [9.0, -12.0, cosine];
    let expected_hessian = Matrix3::new(
        0.0, -6.0, 0.0, //
        -6.0, 4.0, 0.0, //
        0.0, 0.0, -sine,
    );
    let (value, slope) = gradient(|v: Vector3<DualSVec64<3>>| product_and_sine(&v), &v);
    assert_near(&[value], &[18.0 + sine]);
    assert_near(slope.as_slice(), &expected_gradient);
    let (value, slope, curvature) = hessian(|v: Vector3<Dual2SVec64<3>>| product_and_sine(&v), &v);
    assert_near(&[value], &[18.0 + sine]);
    assert_near(slope.as_slice(), &expected_gradient);
    assert_near(curvature.as_slice(), expected_hessian.as_slice());
}

/// Two variables for the first derivative, one variable for the second.
type Mixed = HyperDualSVec64<2, 1>;

#[test]
fn hyper_dual_scalars_carry_mixed_derivatives() {
    let in_x_and_y = |(x, y): (HyperDual64, HyperDual64)| product_and_sine(&vector![x, y, lift(X)]);
    let (value, by_x, by_y, by_both) = second_partial_derivative(in_x_and_y, (2.0, -3.0));
    assert_near(
        &[value, by_x, by_y, by_both],
        &[18.0 + X.sin(), 9.0, -12.0, -6.0],
    );
    let in_xz_and_y = |(xz, y): (SVector<Mixed, 2>, SVector<Mixed, 1>)| {
        product_and_sine(&vector![xz[0], y[0], xz[1]])
    };
    let (_, by_xz, by_y, by_both) =
        partial_hessian(in_xz_and_y, (&vector![2.0, X], &vector![-3.0]));
    assert_near(by_xz.as_slice(), &[9.0, X.cos()]);
    assert_near(by_y.as_slice(), &[-12.0]);
    assert_near(by_both.as_slice(), &[-6.0, 0.0]);
}

#[test]
fn lifted_numbers_come_back_with_no_derivative() {
    let constant: Dual64 = lift(X);
    assert_near(&[constant.re, constant.eps], &[X, 0.0]);
    let vector = vector![1.0, -2.0, X];
    assert_eq!(real_vector(&lift_vector::<Dual2_64>(&vector)), vector);
    assert_near(&[real_part(Dual64::new(X, 5.0))], &[X]);
}

#[test]
fn the_length_of_a_vector_has_its_direction_for_gradient_and_none_at_zero() {
    let v = vector![2.0, -3.0, X];
    let (length, slope) = gradient(|v| norm(&v), &v);
    let expected = v / v.norm();
    assert_near(&[length], &[v.norm()]);
    assert_near(slope.as_slice(), expected.as_slice());
    let (length, slope) = gradient(|v| norm(&v), &Vector3::<f64>::zeros());
    assert!(length == 0.0 && slope.iter().all(|number: &f64| !number.is_finite()));
}
