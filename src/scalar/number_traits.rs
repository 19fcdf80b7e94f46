//! Traits of num-traits and num-dual for [`DenseDual`]. Comparisons use real parts only.

use super::DenseDual;
use num_dual::{DualStruct, Mappable};
use num_traits::{FromPrimitive, Inv, Num, One, Signed, Zero};
use std::cmp::Ordering;
use std::iter::{Product, Sum};

impl<const N: usize> From<f64> for DenseDual<N> {
    #[inline]
    fn from(value: f64) -> Self {
        Self::constant(value)
    }
}

impl<const N: usize> FromPrimitive for DenseDual<N> {
    #[inline]
    fn from_i64(value: i64) -> Option<Self> {
        f64::from_i64(value).map(Self::constant)
    }

    #[inline]
    fn from_u64(value: u64) -> Option<Self> {
        f64::from_u64(value).map(Self::constant)
    }

    #[inline]
    fn from_f64(value: f64) -> Option<Self> {
        Some(Self::constant(value))
    }
}

impl<const N: usize> Zero for DenseDual<N> {
    #[inline]
    fn zero() -> Self {
        Self::constant(0.0)
    }

    #[inline]
    fn is_zero(&self) -> bool {
        self.re.is_zero()
    }
}

impl<const N: usize> One for DenseDual<N> {
    #[inline]
    fn one() -> Self {
        Self::constant(1.0)
    }

    #[inline]
    fn is_one(&self) -> bool {
        self.re.is_one()
    }
}

impl<const N: usize> Num for DenseDual<N> {
    type FromStrRadixErr = <f64 as Num>::FromStrRadixErr;

    fn from_str_radix(text: &str, radix: u32) -> Result<Self, Self::FromStrRadixErr> {
        f64::from_str_radix(text, radix).map(Self::constant)
    }
}

impl<const N: usize> Signed for DenseDual<N> {
    /// Computes the absolute value. The derivative at zero is one-sided: from above for +0, from
    /// below for −0.
    #[inline]
    fn abs(&self) -> Self {
        if self.re.is_sign_positive() {
            *self
        } else {
            -*self
        }
    }

    #[inline]
    fn abs_sub(&self, other: &Self) -> Self {
        if self.re > other.re {
            *self - other
        } else {
            Self::zero()
        }
    }

    #[inline]
    fn signum(&self) -> Self {
        if self.is_zero() {
            Self::zero()
        } else {
            Self::constant(self.re.signum())
        }
    }

    #[inline]
    fn is_positive(&self) -> bool {
        self.re.is_sign_positive()
    }

    #[inline]
    fn is_negative(&self) -> bool {
        self.re.is_sign_negative()
    }
}

impl<const N: usize> Inv for DenseDual<N> {
    type Output = Self;
    #[inline]
    fn inv(self) -> Self {
        num_dual::DualNum::recip(&self)
    }
}

impl<const N: usize> Sum for DenseDual<N> {
    #[inline]
    fn sum<I: Iterator<Item = Self>>(numbers: I) -> Self {
        numbers.fold(Self::zero(), |sum, number| sum + number)
    }
}

impl<const N: usize> Product for DenseDual<N> {
    #[inline]
    fn product<I: Iterator<Item = Self>>(numbers: I) -> Self {
        numbers.fold(Self::one(), |product, number| product * number)
    }
}

impl<const N: usize> PartialEq for DenseDual<N> {
    #[inline]
    fn eq(&self, other: &Self) -> bool {
        self.re.eq(&other.re)
    }
}

impl<const N: usize> PartialEq<f64> for DenseDual<N> {
    #[inline]
    fn eq(&self, other: &f64) -> bool {
        self.re.eq(other)
    }
}

impl<const N: usize> PartialOrd for DenseDual<N> {
    #[inline]
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        self.re.partial_cmp(&other.re)
    }
}

impl<const N: usize> PartialOrd<f64> for DenseDual<N> {
    #[inline]
    fn partial_cmp(&self, other: &f64) -> Option<Ordering> {
        self.re.partial_cmp(other)
    }
}

impl<const N: usize> DualStruct for DenseDual<N> {
    type Real = f64;
    type Inner = f64;
    #[inline]
    fn re(&self) -> f64 {
        self.re
    }

    #[inline]
    fn from_inner(inner: &f64) -> Self {
        Self::constant(*inner)
    }
}

impl<const N: usize> Mappable<Self> for DenseDual<N> {
    type Output<O> = O;
    #[inline]
    fn map_dual<M: Fn(Self) -> O, O>(self, map: M) -> O {
        map(self)
    }
}
