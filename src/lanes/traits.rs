//! Numbers in lanes, and what is computed with them.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

/// The most lanes there are.
pub(crate) const ROW: usize = 8;

/// A number of each of eight items.
pub(crate) type Row = [f64; ROW];

/// A number of each of four items.
pub(crate) type Quad = [f64; 4];

/// What makes numbers in lanes.
pub(crate) trait Lanes: Copy {
    type Numbers: Numbers;

    /// How many lanes: 2, 4 or 8.
    const COUNT: usize;

    /// The same number in all lanes.
    fn splat(self, value: f64) -> Self::Numbers;

    /// The numbers of the items from `first` on.
    fn load(self, row: &Row, first: usize) -> Self::Numbers;

    /// The numbers of four items from `first` on; eight lanes have each twice.
    #[inline(always)]
    fn load_four(self, quad: &Quad, first: usize) -> Self::Numbers {
        self.gathered(|lane| quad[(first + lane) % 4])
    }

    /// A number for each lane, lane 0 first.
    fn gathered(self, number: impl Fn(usize) -> f64) -> Self::Numbers;
}

/// A number, or one in each lane: what sums and products are made of.
pub(crate) trait Linear:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Neg<Output = Self>
{
}

impl<N> Linear for N where
    N: Copy + Add<Output = N> + Sub<Output = N> + Mul<Output = N> + Neg<Output = N>
{
}

/// A number in each lane.
pub(crate) trait Numbers: Linear + Div<Output = Self> {
    type Mask: Mask<Self>;

    fn abs(self) -> Self;

    fn sqrt(self) -> Self;

    /// Of numbers of which none is NaN, nor both zero: there widths may differ.
    fn max(self, other: Self) -> Self;

    /// Under the same conditions.
    fn min(self, other: Self) -> Self;

    /// False where either number is NaN.
    fn is_less(self, other: Self) -> Self::Mask;

    /// False where either number is NaN.
    fn is_at_most(self, other: Self) -> Self::Mask;

    /// Writes the numbers of the items from `first` on.
    fn store(self, row: &mut Row, first: usize);

    /// Writes the numbers of four items from `first` on: of eight lanes the first four.
    fn store_four(self, quad: &mut Quad, first: usize);
}

/// Whether something is so, in each lane of numbers.
pub(crate) trait Mask<N>:
    Copy + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self>
{
    /// The first numbers where it is so, the others elsewhere; NaN and infinities that are not taken leave no trace.
    fn select(self, if_so: N, otherwise: N) -> N;

    /// Whether it is so in any lane.
    fn is_any(self) -> bool;

    /// Bit k for lane k.
    fn bits(self) -> u32;
}

/// Something to be computed in lanes.
pub(crate) trait InLanes {
    type Output;

    /// All that runs in lanes must be inlined into this, and this itself: it is compiled for each processor.
    fn run<L: Lanes>(self, lanes: L) -> Self::Output;
}
