//! The dense dual number against num-dual's, against `f64` and against differences, operation by
//! operation.
#![allow(clippy::float_cmp, reason = "constants and exact operations are exact")]
#![allow(clippy::op_ref, reason = "operators by reference are tested too")]

use hydroelastic::scalar::{DenseDual, lift, lift_vector, real_part};
use nalgebra::{SVector, Vector3};
use num_dual::{Derivative, DualNum, DualSVec64};
use num_traits::{FromPrimitive, Inv, Num, One, Signed, Zero};
use proptest::prelude::*;
use std::f64::consts::{E, LN_2};

const N: usize = 3;
type Dense = DenseDual<N>;
type Sparse = DualSVec64<N>;

/// Difference between two ways of writing a formula, a few rounding errors each. Near a zero of the function or at the end of its domain, a
/// digit or two are lost.
const SAME_FORMULA: f64 = 1e-12;

/// Error of central differences with a step of 1e-6 of the range. The squared step and the rounding error divided by the step are both near
/// 1e-10.
const DIFFERENCES: f64 = 1e-7;

struct Unary {
    name: &'static str,
    range: [f64; 2],
    dense: fn(Dense) -> Dense,
    sparse: fn(Sparse) -> Sparse,
    real: fn(f64) -> f64,
}

struct Binary {
    name: &'static str,
    dense: fn(Dense, Dense) -> Dense,
    sparse: fn(Sparse, Sparse) -> Sparse,
    real: fn(f64, f64) -> f64,
}

/// Evaluates an expression with all three number types.
macro_rules! unary {
    ($($name:literal in $low:literal to $high:literal: |$x:ident| $body:expr;)*) => {
        [$(Unary {
            name: $name,
            range: [$low, $high],
            dense: |$x| $body,
            sparse: |$x| $body,
            real: |$x| $body,
        }),*]
    };
}

macro_rules! binary {
    ($($name:literal: |$x:ident, $y:ident| $body:expr;)*) => {
        [$(Binary {
            name: $name,
            dense: |$x, $y| $body,
            sparse: |$x, $y| $body,
            real: |$x, $y| $body,
        }),*]
    };
}

fn unary_functions() -> [Unary; 47] {
    unary! {
        "neg" in -2.0 to 2.0: |x| -x;
        "plus constant" in -2.0 to 2.0: |x| x + 0.3;
        "minus constant" in -2.0 to 2.0: |x| x - 0.3;
        "times constant" in -2.0 to 2.0: |x| x * 0.3;
        "over constant" in -2.0 to 2.0: |x| x / 0.3;
        "scale" in -2.0 to 2.0: |x| DualNum::scale(x, &0.3);
        "abs below" in -2.0 to -0.1: |x| Signed::abs(&x);
        "abs above" in 0.1 to 2.0: |x| Signed::abs(&x);
        "signum" in -2.0 to -0.1: |x| Signed::signum(&x);
        "inv" in 0.2 to 2.0: |x| Inv::inv(x);
        "recip" in 0.2 to 2.0: |x| DualNum::recip(&x);
        "powi -2" in 0.5 to 2.0: |x| DualNum::powi(&x, -2);
        "powi 0" in 0.5 to 2.0: |x| DualNum::powi(&x, 0);
        "powi 1" in 0.5 to 2.0: |x| DualNum::powi(&x, 1);
        "powi 2" in 0.5 to 2.0: |x| DualNum::powi(&x, 2);
        "powi 5" in 0.5 to 2.0: |x| DualNum::powi(&x, 5);
        "powf 0" in 0.5 to 2.0: |x| DualNum::powf(&x, 0.0);
        "powf 1" in 0.5 to 2.0: |x| DualNum::powf(&x, 1.0);
        "powf 2" in 0.5 to 2.0: |x| DualNum::powf(&x, 2.0);
        "powf 1.7" in 0.5 to 2.0: |x| DualNum::powf(&x, 1.7);
        "sqrt" in 0.2 to 2.0: |x| DualNum::sqrt(&x);
        "cbrt" in 0.2 to 2.0: |x| DualNum::cbrt(&x);
        "exp" in -2.0 to 2.0: |x| DualNum::exp(&x);
        "exp2" in -2.0 to 2.0: |x| DualNum::exp2(&x);
        "exp_m1" in -2.0 to 2.0: |x| DualNum::exp_m1(&x);
        "ln" in 0.2 to 2.0: |x| DualNum::ln(&x);
        "log" in 0.2 to 2.0: |x| DualNum::log(&x, 3.0);
        "log2" in 0.2 to 2.0: |x| DualNum::log2(&x);
        "log10" in 0.2 to 2.0: |x| DualNum::log10(&x);
        "ln_1p" in -0.7 to 2.0: |x| DualNum::ln_1p(&x);
        "sin" in -4.0 to 4.0: |x| DualNum::sin(&x);
        "cos" in -4.0 to 4.0: |x| DualNum::cos(&x);
        "sine of sin_cos" in -4.0 to 4.0: |x| DualNum::sin_cos(&x).0;
        "cosine of sin_cos" in -4.0 to 4.0: |x| DualNum::sin_cos(&x).1;
        "tan" in -1.2 to 1.2: |x| DualNum::tan(&x);
        "asin" in -0.9 to 0.9: |x| DualNum::asin(&x);
        "acos" in -0.9 to 0.9: |x| DualNum::acos(&x);
        "atan" in -4.0 to 4.0: |x| DualNum::atan(&x);
        "sinh" in -2.0 to 2.0: |x| DualNum::sinh(&x);
        "cosh" in -2.0 to 2.0: |x| DualNum::cosh(&x);
        "tanh" in -2.0 to 2.0: |x| DualNum::tanh(&x);
        "asinh" in -2.0 to 2.0: |x| DualNum::asinh(&x);
        "acosh" in 1.2 to 3.0: |x| DualNum::acosh(&x);
        "atanh" in -0.9 to 0.9: |x| DualNum::atanh(&x);
        "sph_j0" in 0.5 to 4.0: |x| DualNum::sph_j0(&x);
        "sph_j1" in 0.5 to 4.0: |x| DualNum::sph_j1(&x);
        "sph_j2" in 0.5 to 4.0: |x| DualNum::sph_j2(&x);
    }
}

fn binary_functions() -> [Binary; 15] {
    binary! {
        "add": |x, y| x + y;
        "sub": |x, y| x - y;
        "mul": |x, y| x * y;
        "div": |x, y| x / y;
        "by reference": |x, y| (x + &y) * &y - &(x / &y);
        "add_assign": |x, y| { let mut z = x; z += y; z };
        "sub_assign": |x, y| { let mut z = x; z -= y; z };
        "mul_assign": |x, y| { let mut z = x; z *= y; z };
        "div_assign": |x, y| { let mut z = x; z /= y; z };
        "with constants": |x, y| { let mut z = x; z += 0.3; z *= 1.7; z -= 0.2; z /= 1.3; z * y };
        "atan2": |x, y| DualNum::atan2(&x, y);
        "mul_add": |x, y| DualNum::mul_add(&x, y, x);
        "powd": |x, y| DualNum::powd(&x, y);
        "sum": |x, y| [x, y, x].into_iter().sum();
        "product": |x, y| [x, y, x].into_iter().product();
    }
}

fn sparse(number: Dense) -> Sparse {
    Sparse::new(number.re, Derivative::some(SVector::from(number.eps)))
}

/// Returns the value and all derivatives as plain numbers.
fn numbers_of_sparse(number: Sparse) -> [f64; N + 1] {
    let eps = number
        .eps
        .unwrap_generic(nalgebra::Const::<N>, nalgebra::U1);
    [number.re, eps[0], eps[1], eps[2]]
}

fn numbers(number: Dense) -> [f64; N + 1] {
    [number.re, number.eps[0], number.eps[1], number.eps[2]]
}

fn assert_same(name: &str, actual: [f64; N + 1], expected: [f64; N + 1]) {
    let scale = expected.iter().fold(1.0_f64, |most, x| most.max(x.abs()));
    for (actual, expected) in actual.into_iter().zip(expected) {
        let error = (actual - expected).abs() / scale;
        assert!(error <= SAME_FORMULA, "{name}: {actual} for {expected}");
    }
}

fn derivatives() -> impl Strategy<Value = [f64; N]> {
    prop::array::uniform3(-1.0..1.0)
}

proptest! {
    #[test]
    fn elementary_functions_are_those_of_num_dual_and_of_f64(share in 0.0..1.0, eps in derivatives()) {
        for Unary { name, range: [low, high], dense, sparse: reference, real } in unary_functions() {
            let x = Dense::new(low + share * (high - low), eps);
            let dual = dense(x);
            assert_same(name, numbers(dual), numbers_of_sparse(reference(sparse(x))));
            let error = (dual.re - real(x.re)).abs();
            assert!(error <= SAME_FORMULA, "{name}: {error:e}");
        }
    }

    #[test]
    fn operators_are_those_of_num_dual_and_of_f64_bit_for_bit(
        x in 0.3..2.0, y in 0.3..2.0, eps_x in derivatives(), eps_y in derivatives(),
    ) {
        let (x, y) = (Dense::new(x, eps_x), Dense::new(y, eps_y));
        for Binary { name, dense, sparse: reference, real } in binary_functions() {
            let dual = dense(x, y);
            assert_same(name, numbers(dual), numbers_of_sparse(reference(sparse(x), sparse(y))));
            assert_eq!(dual.re.to_bits(), real(x.re, y.re).to_bits(), "{name}");
        }
    }

    #[test]
    fn derivatives_are_differences(share in 0.01..0.99, second in 0.3..2.0) {
        let assert_near = |name: &str, actual: f64, expected: f64| {
            let error = (actual - expected).abs() / expected.abs().max(1.0);
            assert!(error <= DIFFERENCES, "{name}: {actual} for {expected}");
        };
        for Unary { name, range: [low, high], dense, real, .. } in unary_functions() {
            let (x, step) = (low + share * (high - low), 1e-6 * (high - low));
            let difference = (real(x + step) - real(x - step)) / (2.0 * step);
            assert_near(name, dense(Dense::variable(x, 1)).eps[1], difference);
        }
        for Binary { name, dense, real, .. } in binary_functions() {
            let (x, y, step) = (0.3 + share, second, 1e-6);
            let by_x = (real(x + step, y) - real(x - step, y)) / (2.0 * step);
            let by_y = (real(x, y + step) - real(x, y - step)) / (2.0 * step);
            let dual = dense(Dense::variable(x, 0), Dense::variable(y, 2));
            assert_near(name, dual.eps[0], by_x);
            assert_near(name, dual.eps[2], by_y);
            assert_eq!(dual.eps[1], 0.0, "{name}");
        }
    }

    /// num-dual has no remainder, so only differences check this rule.
    #[test]
    fn remainders_have_the_slopes_of_differences(whole in 0..5, part in 0.1..0.9, y in 0.5..2.0) {
        let (x, step) = ((f64::from(whole) + part) * y, 1e-7);
        let mut remainder = Dense::variable(x, 0) % Dense::variable(y, 1);
        assert_eq!(remainder.re, x % y);
        let by_y = (x % (y + step) - x % (y - step)) / (2.0 * step);
        assert!((remainder.eps[1] - by_y).abs() <= DIFFERENCES * 10.0, "{by_y}");
        assert_eq!(remainder.eps[0], 1.0);
        remainder %= Dense::from(y);
        remainder %= y;
        assert_eq!((remainder % y).eps, [1.0, -f64::from(whole), 0.0]);
    }
}

#[test]
fn at_zero_spherical_bessel_functions_are_their_series() {
    let zero = Dense::variable(0.0, 0);
    let values = [zero.sph_j0(), zero.sph_j1(), zero.sph_j2()];
    assert_eq!(
        values.map(|f| (f.re, f.eps[0])),
        [(1.0, 0.0), (0.0, 1.0 / 3.0), (0.0, 0.0)]
    );
}

#[test]
fn constants_and_comparisons_look_at_values_alone() {
    let (x, y) = (Dense::variable(2.0, 0), Dense::variable(2.0, 1));
    assert!(x == y && x == 2.0 && x < 3.0 && x < Dense::from(3.0));
    assert!(x.is_positive() && (-x).is_negative() && !x.is_zero() && Dense::one().is_one());
    assert_eq!(Signed::abs_sub(&(x + 1.0), &y).eps, [1.0, -1.0, 0.0]);
    assert_eq!(Signed::abs_sub(&x, &y).eps, [0.0; N]);
    assert_eq!(numbers(Dense::zero().signum()), [0.0; N + 1]);
    let constants = [
        (Dense::from_i64(-7), -7.0),
        (Dense::from_u64(7), 7.0),
        (Dense::from_f64(LN_2), LN_2),
        (Dense::from_f32(0.5), 0.5),
        (Dense::from_str_radix("101", 2).ok(), 5.0),
        (Some(lift(E)), E),
        (Some(<Dense as DualNum>::from_re(E)), E),
    ];
    for (constant, value) in constants {
        assert_eq!(numbers(constant.unwrap()), [value, 0.0, 0.0, 0.0]);
    }
    assert_eq!(real_part(x), 2.0);
    assert_eq!(Dense::variable(1.0, N).eps, [0.0; N]);
    assert_eq!(format!("{x}"), "2 + [1.0, 0.0, 0.0]ε");
}

#[test]
fn vectors_of_it_multiply_like_numbers() {
    let x: Vector3<Dense> = Vector3::from_fn(|i, _| Dense::variable(i as f64 + 1.0, i));
    let product = x.dot(&lift_vector(&Vector3::new(2.0, 3.0, 4.0)));
    assert_eq!(numbers(product), [20.0, 2.0, 3.0, 4.0]);
}
