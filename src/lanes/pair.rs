use super::traits::{Lanes, Mask, Numbers, Quad, Row};
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};
use wide::f64x2;

/// Two lanes, with instructions that every x86-64 and aarch64 CPU has.
#[derive(Clone, Copy)]
pub(super) struct Pairs;

#[derive(Clone, Copy)]
pub(super) struct Pair(f64x2);

#[derive(Clone, Copy)]
pub(super) struct PairMask(f64x2);

impl Lanes for Pairs {
    type Numbers = Pair;

    const COUNT: usize = 2;

    #[inline(always)]
    fn splat(self, value: f64) -> Pair {
        Pair(f64x2::splat(value))
    }

    #[inline(always)]
    fn load(self, row: &Row, first: usize) -> Pair {
        Pair(f64x2::new([row[first], row[first + 1]]))
    }

    #[inline(always)]
    fn gathered(self, number: impl Fn(usize) -> f64) -> Pair {
        Pair(f64x2::new([number(0), number(1)]))
    }
}

impl Numbers for Pair {
    type Mask = PairMask;

    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.abs())
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.sqrt())
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(self.0.fast_max(other.0))
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(self.0.fast_min(other.0))
    }

    #[inline(always)]
    fn is_less(self, other: Self) -> PairMask {
        PairMask(self.0.simd_lt(other.0))
    }

    #[inline(always)]
    fn is_at_most(self, other: Self) -> PairMask {
        PairMask(self.0.simd_le(other.0))
    }

    #[inline(always)]
    fn store(self, row: &mut Row, first: usize) {
        let numbers = self.0.to_array();
        row[first] = numbers[0];
        row[first + 1] = numbers[1];
    }

    #[inline(always)]
    fn store_four(self, quad: &mut Quad, first: usize) {
        let numbers = self.0.to_array();
        quad[first] = numbers[0];
        quad[first + 1] = numbers[1];
    }
}

impl Mask<Pair> for PairMask {
    #[inline(always)]
    fn select(self, if_so: Pair, otherwise: Pair) -> Pair {
        Pair(self.0.bitselect(if_so.0, otherwise.0))
    }

    #[inline(always)]
    fn is_any(self) -> bool {
        self.bits() != 0
    }

    #[inline(always)]
    fn bits(self) -> u32 {
        self.0.to_bitmask()
    }
}

impl Add for Pair {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(self.0 + other.0)
    }
}

impl Sub for Pair {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(self.0 - other.0)
    }
}

impl Mul for Pair {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self(self.0 * other.0)
    }
}

impl Div for Pair {
    type Output = Self;

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        Self(self.0 / other.0)
    }
}

impl Neg for Pair {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0 ^ f64x2::splat(-0.0))
    }
}

impl BitAnd for PairMask {
    type Output = Self;

    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}

impl BitOr for PairMask {
    type Output = Self;

    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl Not for PairMask {
    type Output = Self;

    #[inline(always)]
    fn not(self) -> Self {
        Self(!self.0)
    }
}
