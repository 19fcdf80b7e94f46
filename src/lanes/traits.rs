//! Traits of SIMD vectors, masks and kernels.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

/// Largest number of lanes.
pub(crate) const ROW: usize = 8;

/// One number for each of eight items.
pub(crate) type Row = [f64; ROW];

/// One number for each of four items.
pub(crate) type Quad = [f64; 4];

/// A SIMD instruction set, which creates vectors.
pub(crate) trait Lanes: Copy {
    type Numbers: Numbers;

    /// Number of lanes: 2, 4 or 8.
    const COUNT: usize;

    /// Returns one number in all lanes.
    fn splat(self, value: f64) -> Self::Numbers;

    /// Loads the numbers of consecutive items, beginning with item `first`.
    fn load(self, row: &Row, first: usize) -> Self::Numbers;

    /// Loads the numbers of consecutive items of four, beginning with item `first`. With eight
    /// lanes, each number is loaded twice.
    #[inline(always)]
    fn load_four(self, quad: &Quad, first: usize) -> Self::Numbers {
        self.gathered(|lane| quad[(first + lane) % 4])
    }

    /// Gathers one number for each lane, beginning with lane 0.
    fn gathered(self, number: impl Fn(usize) -> f64) -> Self::Numbers;
}

/// A number or a SIMD vector of numbers, with sums, differences and products.
pub(crate) trait Linear:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Neg<Output = Self>
{
}

impl<N> Linear for N where
    N: Copy + Add<Output = N> + Sub<Output = N> + Mul<Output = N> + Neg<Output = N>
{
}

/// A SIMD vector: one number in each lane.
pub(crate) trait Numbers: Linear + Div<Output = Self> {
    type Mask: Mask<Self>;

    fn abs(self) -> Self;

    fn sqrt(self) -> Self;

    /// Returns the larger number in each lane. Requires that neither operand is NaN and that they
    /// are not both zero. Otherwise the result may depend on the SIMD width.
    fn max(self, other: Self) -> Self;

    /// Returns the smaller number in each lane, with the requirements of [`Self::max`].
    fn min(self, other: Self) -> Self;

    /// Compares with `<` in each lane. The result is false if either number is NaN.
    fn is_less(self, other: Self) -> Self::Mask;

    /// Compares with `≤` in each lane. The result is false if either number is NaN.
    fn is_at_most(self, other: Self) -> Self::Mask;

    /// Stores the numbers of consecutive items, beginning with item `first`.
    fn store(self, row: &mut Row, first: usize);

    /// Stores the numbers of consecutive items of four, beginning with item `first`. With eight
    /// lanes, only the first four are stored.
    fn store_four(self, quad: &mut Quad, first: usize);
}

/// One boolean in each SIMD lane.
pub(crate) trait Mask<N>:
    Copy + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self>
{
    /// Selects `if_so` in lanes where the mask is set, and `otherwise` in the other lanes.
    /// Unselected numbers may be NaN or infinite.
    fn select(self, if_so: N, otherwise: N) -> N;

    /// Returns whether the mask is set in any lane.
    fn is_any(self) -> bool;

    /// Returns the mask as bits: bit k for lane k.
    fn bits(self) -> u32;
}

/// A kernel that runs at any number of lanes.
pub(crate) trait InLanes {
    type Output;

    /// Runs the kernel. This function and all functions that it calls must be inlined, because it
    /// is compiled once for each instruction set.
    fn run<L: Lanes>(self, lanes: L) -> Self::Output;
}
