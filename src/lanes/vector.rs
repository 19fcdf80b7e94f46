use super::traits::{Lanes, Mask, Numbers, Quad, Row};
use pulp::Simd;
use pulp::bytemuck::{bytes_of, cast_slice, cast_slice_mut};
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};
use std::slice;

/// An instruction set that was detected at run time, with its number of lanes.
#[derive(Clone, Copy)]
pub(super) struct Vectors<S>(pub S);

#[derive(Clone, Copy)]
pub(super) struct Vector<S: Simd> {
    simd: S,
    numbers: S::f64s,
}

#[derive(Clone, Copy)]
pub(super) struct VectorMask<S: Simd> {
    simd: S,
    mask: S::m64s,
}

impl<S: Simd> Lanes for Vectors<S> {
    type Numbers = Vector<S>;

    const COUNT: usize = S::F64_LANES;

    #[inline(always)]
    fn splat(self, value: f64) -> Vector<S> {
        Vector {
            simd: self.0,
            numbers: self.0.splat_f64s(value),
        }
    }

    #[inline(always)]
    fn load(self, row: &Row, first: usize) -> Vector<S> {
        self.gathered(|lane| row[first + lane])
    }

    #[inline(always)]
    fn gathered(self, lane_value: impl Fn(usize) -> f64) -> Vector<S> {
        let mut numbers = self.0.splat_f64s(0.0);
        let lanes: &mut [f64] = cast_slice_mut(slice::from_mut(&mut numbers));
        for (lane, number) in lanes.iter_mut().enumerate() {
            *number = lane_value(lane);
        }
        Vector {
            simd: self.0,
            numbers,
        }
    }
}

impl<S: Simd> Vector<S> {
    #[inline(always)]
    fn made(self, numbers: S::f64s) -> Self {
        Self { numbers, ..self }
    }

    #[inline(always)]
    fn mask(self, mask: S::m64s) -> VectorMask<S> {
        VectorMask {
            simd: self.simd,
            mask,
        }
    }
}

impl<S: Simd> Numbers for Vector<S> {
    type Mask = VectorMask<S>;

    #[inline(always)]
    fn abs(self) -> Self {
        self.made(self.simd.abs_f64s(self.numbers))
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        self.made(self.simd.sqrt_f64s(self.numbers))
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.made(self.simd.max_f64s(self.numbers, other.numbers))
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.made(self.simd.min_f64s(self.numbers, other.numbers))
    }

    #[inline(always)]
    fn is_less(self, other: Self) -> VectorMask<S> {
        self.mask(self.simd.less_than_f64s(self.numbers, other.numbers))
    }

    #[inline(always)]
    fn is_at_most(self, other: Self) -> VectorMask<S> {
        let is_at_most = self
            .simd
            .less_than_or_equal_f64s(self.numbers, other.numbers);
        self.mask(is_at_most)
    }

    #[inline(always)]
    fn store(self, row: &mut Row, first: usize) {
        let lanes: &[f64] = cast_slice(slice::from_ref(&self.numbers));
        row[first..first + S::F64_LANES].copy_from_slice(lanes);
    }

    #[inline(always)]
    fn store_four(self, quad: &mut Quad, first: usize) {
        let lanes: &[f64] = cast_slice(slice::from_ref(&self.numbers));
        let count = S::F64_LANES.min(quad.len());
        quad[first..first + count].copy_from_slice(&lanes[..count]);
    }
}

impl<S: Simd> Mask<Vector<S>> for VectorMask<S> {
    #[inline(always)]
    fn select(self, if_so: Vector<S>, otherwise: Vector<S>) -> Vector<S> {
        let chosen = self
            .simd
            .select_f64s(self.mask, if_so.numbers, otherwise.numbers);
        if_so.made(chosen)
    }

    #[inline(always)]
    fn is_any(self) -> bool {
        self.simd.first_true_m64s(self.mask) != S::F64_LANES
    }

    #[inline(always)]
    fn bits(self) -> u32 {
        // An AVX-512 mask already is a byte of bits.
        if let [bits] = bytes_of(&self.mask) {
            return (*bits).into();
        }
        let (one, zero) = (self.simd.splat_u64s(1), self.simd.splat_u64s(0));
        let set = self.simd.select_u64s(self.mask, one, zero);
        let lanes: &[u64] = cast_slice(slice::from_ref(&set));
        let mut bits = 0;
        for (lane, &is_set) in lanes.iter().enumerate() {
            bits |= u32::from(is_set != 0) << lane;
        }
        bits
    }
}

impl<S: Simd> Add for Vector<S> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.made(self.simd.add_f64s(self.numbers, other.numbers))
    }
}

impl<S: Simd> Sub for Vector<S> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.made(self.simd.sub_f64s(self.numbers, other.numbers))
    }
}

impl<S: Simd> Mul for Vector<S> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.made(self.simd.mul_f64s(self.numbers, other.numbers))
    }
}

impl<S: Simd> Div for Vector<S> {
    type Output = Self;

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        self.made(self.simd.div_f64s(self.numbers, other.numbers))
    }
}

impl<S: Simd> Neg for Vector<S> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        // pulp's negation may stay a function call that is compiled for any CPU.
        let sign = self.simd.splat_f64s(-0.0);
        self.made(self.simd.xor_f64s(self.numbers, sign))
    }
}

impl<S: Simd> BitAnd for VectorMask<S> {
    type Output = Self;

    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        let mask = self.simd.and_m64s(self.mask, other.mask);
        Self { mask, ..self }
    }
}

impl<S: Simd> BitOr for VectorMask<S> {
    type Output = Self;

    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        let mask = self.simd.or_m64s(self.mask, other.mask);
        Self { mask, ..self }
    }
}

impl<S: Simd> Not for VectorMask<S> {
    type Output = Self;

    #[inline(always)]
    fn not(self) -> Self {
        let zero = self.simd.splat_f64s(0.0);
        let all = self.simd.equal_f64s(zero, zero);
        let mask = self.simd.xor_m64s(self.mask, all);
        Self { mask, ..self }
    }
}
