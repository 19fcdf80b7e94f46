//! Elementary functions of a [`DenseDual`], each from its value and its first derivative.

#![cfg_attr(
    not(test),
    expect(
        clippy::disallowed_methods,
        reason = "callers outside the library get the values of `f64`; the library itself calls `portable`"
    )
)]

use super::DenseDual;
use num_dual::DualNum;
use num_traits::{One, Zero};
use std::f64::consts::{LN_2, LN_10};

/// Absolute value below which the spherical Bessel functions are evaluated by the first terms of
/// their series.
const BESSEL_SERIES: f64 = f64::EPSILON;

impl<const N: usize> DualNum for DenseDual<N> {
    type Primitive = f64;
    type InnerDual = f64;
    const NDERIV: usize = 1;

    #[inline]
    fn from_re(value: f64) -> Self {
        Self::constant(value)
    }

    #[inline]
    fn scale(self, factor: &f64) -> Self {
        self * *factor
    }

    #[inline]
    fn recip(&self) -> Self {
        let inverse = self.re.recip();
        self.chained(inverse, -inverse * inverse)
    }

    #[inline]
    fn powi(&self, exponent: i32) -> Self {
        match exponent {
            0 => Self::one(),
            1 => *self,
            _ => {
                let slope = self.re.powi(exponent.saturating_sub(1)) * f64::from(exponent);
                self.chained(self.re.powi(exponent), slope)
            }
        }
    }

    #[inline]
    fn powf(&self, exponent: f64) -> Self {
        if exponent.is_zero() {
            return Self::one();
        }
        let slope = self.re.powf(exponent - 1.0) * exponent;
        self.chained(self.re.powf(exponent), slope)
    }

    #[inline]
    fn sqrt(&self) -> Self {
        let root = self.re.sqrt();
        self.chained(root, 0.5 / root)
    }

    #[inline]
    fn cbrt(&self) -> Self {
        let root = self.re.cbrt();
        self.chained(root, (3.0 * root * root).recip())
    }

    #[inline]
    fn exp(&self) -> Self {
        let value = self.re.exp();
        self.chained(value, value)
    }

    #[inline]
    fn exp2(&self) -> Self {
        let value = self.re.exp2();
        self.chained(value, value * LN_2)
    }

    #[inline]
    fn exp_m1(&self) -> Self {
        self.chained(self.re.exp_m1(), self.re.exp())
    }

    #[inline]
    fn ln(&self) -> Self {
        self.chained(self.re.ln(), self.re.recip())
    }

    #[inline]
    fn log(&self, base: f64) -> Self {
        self.chained(self.re.log(base), (self.re * base.ln()).recip())
    }

    #[inline]
    fn log2(&self) -> Self {
        self.chained(self.re.log2(), (self.re * LN_2).recip())
    }

    #[inline]
    fn log10(&self) -> Self {
        self.chained(self.re.log10(), (self.re * LN_10).recip())
    }

    #[inline]
    fn ln_1p(&self) -> Self {
        self.chained(self.re.ln_1p(), (1.0 + self.re).recip())
    }

    #[inline]
    fn sin(&self) -> Self {
        self.sin_cos().0
    }

    #[inline]
    fn cos(&self) -> Self {
        self.sin_cos().1
    }

    #[inline]
    fn tan(&self) -> Self {
        let tangent = self.re.tan();
        self.chained(tangent, 1.0 + tangent * tangent)
    }

    #[inline]
    fn sin_cos(&self) -> (Self, Self) {
        let (sine, cosine) = self.re.sin_cos();
        (self.chained(sine, cosine), self.chained(cosine, -sine))
    }

    #[inline]
    fn asin(&self) -> Self {
        self.chained(self.re.asin(), (1.0 - self.re * self.re).sqrt().recip())
    }

    #[inline]
    fn acos(&self) -> Self {
        self.chained(self.re.acos(), -(1.0 - self.re * self.re).sqrt().recip())
    }

    #[inline]
    fn atan(&self) -> Self {
        self.chained(self.re.atan(), (1.0 + self.re * self.re).recip())
    }

    /// Computes the angle of the point (`other`, `self`). The function is smooth except at the
    /// origin, where it has no derivative.
    #[inline]
    fn atan2(&self, other: Self) -> Self {
        let inverse = (self.re * self.re + other.re * other.re).recip();
        let turn = *self * (other.re * inverse) - other * (self.re * inverse);
        Self::new(self.re.atan2(other.re), turn.eps)
    }

    #[inline]
    fn sinh(&self) -> Self {
        self.chained(self.re.sinh(), self.re.cosh())
    }

    #[inline]
    fn cosh(&self) -> Self {
        self.chained(self.re.cosh(), self.re.sinh())
    }

    #[inline]
    fn tanh(&self) -> Self {
        let tangent = self.re.tanh();
        self.chained(tangent, 1.0 - tangent * tangent)
    }

    #[inline]
    fn asinh(&self) -> Self {
        self.chained(self.re.asinh(), (self.re * self.re + 1.0).sqrt().recip())
    }

    #[inline]
    fn acosh(&self) -> Self {
        self.chained(self.re.acosh(), (self.re * self.re - 1.0).sqrt().recip())
    }

    #[inline]
    fn atanh(&self) -> Self {
        self.chained(self.re.atanh(), (1.0 - self.re * self.re).recip())
    }

    fn sph_j0(&self) -> Self {
        if self.re.abs() < BESSEL_SERIES {
            return Self::one() - *self * self / 6.0;
        }
        self.sin() / self
    }

    fn sph_j1(&self) -> Self {
        if self.re.abs() < BESSEL_SERIES {
            return *self / 3.0;
        }
        let (sine, cosine) = self.sin_cos();
        (sine - *self * cosine) / (*self * self)
    }

    fn sph_j2(&self) -> Self {
        if self.re.abs() < BESSEL_SERIES {
            return *self * self / 15.0;
        }
        let (sine, cosine) = self.sin_cos();
        let square = *self * self;
        ((sine - *self * cosine) * 3.0 - square * sine) / (square * self)
    }

    #[inline]
    fn mul_add(&self, factor: Self, summand: Self) -> Self {
        let value = self.re.mul_add(factor.re, summand.re);
        Self::new(value, (*self * factor + summand).eps)
    }

    #[inline]
    fn powd(&self, exponent: Self) -> Self {
        let value = self.re.powf(exponent.re);
        let by_base = exponent.re * self.re.powf(exponent.re - 1.0);
        let change = *self * by_base + exponent * (value * self.re.ln());
        Self::new(value, change.eps)
    }
}
