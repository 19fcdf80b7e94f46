//! Elementary functions with the same bits on every platform.
//!
//! IEEE 754 defines sums, products, quotients and square roots to the last bit, but not sines or
//! logarithms. Their last bits depend on the C library and on the CPU. The functions in this module
//! pass the real part to the crate `libm`, which uses only operations that IEEE 754 defines.
//!
//! A dual number is x + d with the real part x. The addition theorem of the function gives f(x + d)
//! from f(x) and f(d′), where d′ has the real part zero. At zero every library is exact.
//!
//! Clippy rejects the methods of `f64` and of `DualNum` elsewhere in the library (`clippy.toml`).

#![cfg_attr(
    not(test),
    expect(
        clippy::disallowed_methods,
        reason = "their arguments have the real part zero here"
    )
)]

use super::{Order, Scalar, carries_derivatives, change, lift, real_part};

/// Computes sine and cosine of an angle (rad).
#[inline]
pub(crate) fn sin_cos<T: Scalar>(angle: T) -> (T, T) {
    let (sine, cosine) = libm::sincos(real_part(angle));
    if !carries_derivatives::<T>() {
        return (lift(sine), lift(cosine));
    }
    let turn = change(angle);
    let (sine_of_turn, cosine_of_turn) = about_zero(turn, T::sin_cos, (turn, lift(1.0)));
    (
        cosine_of_turn * sine + sine_of_turn * cosine,
        cosine_of_turn * cosine - sine_of_turn * sine,
    )
}

/// Computes ln(1 + x).
#[inline]
pub(crate) fn ln_1p<T: Scalar>(x: T) -> T {
    let real = real_part(x);
    let logarithm = libm::log1p(real);
    if !carries_derivatives::<T>() {
        return lift(logarithm);
    }
    let relative = change(x) * (1.0 + real).recip();
    about_zero(relative, T::ln_1p, relative) + logarithm
}

/// Computes the exponential function.
pub(crate) fn exp(x: f64) -> f64 {
    libm::exp(x)
}

/// Computes the natural logarithm.
pub(crate) fn ln(x: f64) -> f64 {
    libm::log(x)
}

/// Computes xʸ.
pub(crate) fn power(x: f64, y: f64) -> f64 {
    libm::pow(x, y)
}

/// Computes the angle (rad) from the x axis to the point (x, y), in (−π, π].
#[inline]
pub(crate) fn atan2<T: Scalar>(y: T, x: T) -> T {
    let [real_y, real_x] = [y, x].map(real_part);
    let angle = libm::atan2(real_y, real_x);
    if !carries_derivatives::<T>() {
        return lift(angle);
    }
    let per_square = (real_x * real_x + real_y * real_y).recip();
    let across = (y * real_x - x * real_y) * per_square;
    let along = || (x * real_x + y * real_y) * per_square;
    about_zero(across, |across| across.atan2(along()), across) + angle
}

/// Raises a positive number to a power.
#[cfg(feature = "files")]
pub(crate) fn powf(base: f64, exponent: f64) -> f64 {
    libm::pow(base, exponent)
}

/// Evaluates a function at a number whose real part is zero. If the scalar has only first
/// derivatives, returns the given linear value instead.
#[inline]
fn about_zero<T: Scalar, O>(x: T, function: impl FnOnce(&T) -> O, linear: O) -> O {
    if Order::<T>::IS_FIRST {
        linear
    } else {
        function(&x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_dual::{Dual3_64, DualNum};

    /// Tolerance for agreement with another library, relative to the largest derivative. It covers
    /// the last bits of sums of a few products. Third derivatives of the arc tangent lose one more
    /// digit, because they divide by the cube of the distance from its pole (0.4 here).
    const LAST_BITS: f64 = 4e-14;

    /// Returns variables with three derivatives, at values of both signs and several magnitudes.
    fn variables() -> impl Iterator<Item = Dual3_64> {
        let sizes = [0.0, 1e-9, 0.03, 0.7, 1.0, 2.9];
        sizes
            .into_iter()
            .flat_map(|size| [size, -size])
            .map(|x| Dual3_64::from_re(x).derivative())
    }

    fn assert_close(actual: Dual3_64, expected: Dual3_64) {
        let parts = |x: Dual3_64| [x.re, x.v1, x.v2, x.v3];
        let largest = parts(expected)
            .into_iter()
            .fold(1.0, |largest: f64, part| largest.max(part.abs()));
        for (actual, expected) in parts(actual).into_iter().zip(parts(expected)) {
            assert!(
                (actual - expected).abs() <= LAST_BITS * largest,
                "{actual} instead of {expected}"
            );
        }
    }

    #[test]
    fn portable_functions_are_those_of_the_platform_with_all_derivatives() {
        for x in variables() {
            let (sine, cosine) = sin_cos(x);
            assert_close(sine, x.sin());
            assert_close(cosine, x.cos());
            let positive = x * x;
            assert_close(ln_1p(positive), positive.ln_1p());
            let (y, x) = (x * 0.7 - 0.2, x * x * 0.3 - 0.4);
            assert_close(atan2(y, x), y.atan2(x));
        }
    }
}
