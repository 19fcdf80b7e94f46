use crate::scalar::{Scalar, real_part};

/// Zero tolerance for the values of a field, whose signs decide on which side of its zero plane a
/// point lies.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Tolerance {
    /// Largest absolute value that counts as zero.
    pub zero: f64,
    /// Actual rounding error. It is [`NearZeroHistogram::CLEARANCE`] octaves below `zero`, unless the
    /// tolerance was widened.
    rounding: f64,
}

/// A histogram, in octaves, of values near zero that exceed the actual rounding error. It is used
/// to place a tolerance in a gap between values. Bit k is set if a value was between 2ᵏ and 2ᵏ⁺¹
/// times the actual rounding error. That error is [`Self::CLEARANCE`] octaves below the tolerance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct NearZeroHistogram(u32);

impl NearZeroHistogram {
    /// Number of octaves from the actual rounding error up to the tolerance.
    const CLEARANCE: u32 = 6;

    /// Number of octaves above the actual rounding error in which values are recorded.
    const OCTAVES: u32 = Self::CLEARANCE + 20;

    /// Snapping corners across a gap of this many octaves rotates a plane by less than one part in 16.
    const LEAST_GAP: u32 = 5;

    /// A cut is ill-conditioned if a value is less than this many octaves above the tolerance. If
    /// two planes separate by more than that over a body, the position of their common line is
    /// accurate to one part in 2¹⁴.
    const ILL_CONDITIONED: u32 = 14;

    /// Returns whether a value was so close to zero that rounding errors decide where two planes
    /// meet.
    pub fn is_ill_conditioned(self) -> bool {
        self.is_within(Self::ILL_CONDITIONED)
    }

    /// Returns the width of the gap around a split, in octaves. The gap extends from the largest
    /// value below the split, or from the actual rounding error, to the smallest value above the
    /// split.
    fn gap(self, split: u32) -> u32 {
        let above = (self.0 >> split)
            .trailing_zeros()
            .min(Self::OCTAVES.saturating_sub(split));
        let below = self.0 & ((1 << split) - 1);
        above + below.checked_ilog2().map_or(split, |top| split - 1 - top)
    }

    /// Returns whether a value was above the tolerance by less than this many octaves.
    pub fn is_within(self, octaves: u32) -> bool {
        (self.0 >> Self::CLEARANCE) & ((1 << octaves) - 1) != 0
    }

    /// Returns the union of both histograms.
    pub fn or(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Returns the number of octaves by which to widen the tolerance so that it lies in a gap between values. Rounding values to zero
    /// rotates a plane by the ratio of the largest value dropped to the smallest value kept.
    ///
    /// The candidates, in order of preference, are:
    ///
    /// 1. with `merges`, the first number that rounds a value above the margin to zero, so that something counts as coincident, with
    ///    a gap of at least [`Self::LEAST_GAP`] octaves, or of [`Self::CLEARANCE`] octaves if it is above `most`;
    /// 2. the largest number up to `most` with a gap of at least [`Self::CLEARANCE`] octaves;
    /// 3. the smallest number above `most`, by up to [`Self::CLEARANCE`], with such a gap;
    /// 4. the number with the widest gap, which is negative if the gap is below the tolerance.
    ///
    /// Candidate 1 is the first from `most` down to 0, then above `most` ascending. Among equally wide gaps, candidate 4 is the last in
    /// this order: negative numbers ascending, `most` down to 0, numbers above `most` ascending.
    pub fn split(self, most: u32, merges: bool) -> i32 {
        let (margin, most) = (Self::CLEARANCE, Self::CLEARANCE + most);
        let preferred = || {
            (margin..=most)
                .rev()
                .chain(most + 1..=most + Self::CLEARANCE)
        };
        let clearance = |split: &u32| self.gap(*split);
        let has_merged = |split: &u32| (self.0 & ((1 << *split) - 1)) >> margin != 0;
        let least_gap = |split: &u32| {
            if *split > most {
                Self::CLEARANCE
            } else {
                Self::LEAST_GAP
            }
        };
        let is_merging =
            |split: &u32| merges && has_merged(split) && clearance(split) >= least_gap(split);
        let split = preferred()
            .find(is_merging)
            .or_else(|| preferred().find(|split| clearance(split) >= Self::CLEARANCE))
            .or_else(|| (0..margin).chain(preferred()).max_by_key(clearance));
        split.map_or(0, |split| split.cast_signed() - margin.cast_signed())
    }
}

impl Tolerance {
    /// Creates a tolerance for values whose rounding errors are much smaller than `zero`.
    pub fn new(zero: f64) -> Self {
        let octaves = f64::from(1_u32 << NearZeroHistogram::CLEARANCE);
        Self {
            zero,
            rounding: zero / octaves,
        }
    }

    /// Returns a tolerance of 2^`octaves` times the original tolerance. Repeated calls do not
    /// accumulate.
    pub fn widened(self, octaves: i32) -> Self {
        Self {
            zero: self.rounding * 2_f64.powi(octaves + NearZeroHistogram::CLEARANCE.cast_signed()),
            ..self
        }
    }

    /// Returns the bound below which values are recorded. No decision depends on how close to zero
    /// larger values are.
    pub fn noted(self) -> f64 {
        self.rounding * f64::from(1_u32 << NearZeroHistogram::OCTAVES)
    }

    /// Returns a bound on the displacement of a plane in a tetrahedron, relative to the longest
    /// edge. The displacement is caused by rounding values to zero. Along an edge, it is the ratio
    /// of a dropped value to the smallest value kept. The bound is twice that ratio, as a safety
    /// factor.
    pub fn misplacement(self, closeness: NearZeroHistogram) -> f64 {
        let is_zero = |octave: &u32| self.rounding * f64::from(1_u32 << octave) <= self.zero;
        let split = (1..=NearZeroHistogram::OCTAVES)
            .rev()
            .find(is_zero)
            .unwrap_or(0);
        2.0 * 2_f64.powi(-closeness.gap(split).cast_signed())
    }

    /// Returns the tolerance for values multiplied by a factor.
    pub fn scaled(self, factor: f64) -> Self {
        Self {
            zero: self.zero * factor,
            rounding: self.rounding * factor,
        }
    }

    #[inline]
    pub fn closeness(self, value: f64) -> NearZeroHistogram {
        let value = value.abs();
        let reaches = |octave: u32| value >= self.rounding * f64::from(1_u32 << octave);
        if value < self.rounding || reaches(NearZeroHistogram::OCTAVES) {
            return NearZeroHistogram::default();
        }
        NearZeroHistogram(
            1 << (1..NearZeroHistogram::OCTAVES)
                .filter(|&octave| reaches(octave))
                .count(),
        )
    }

    /// Returns the near-zero histogram of the values.
    #[inline]
    pub fn closeness_of(self, values: &[f64]) -> NearZeroHistogram {
        let each = values.iter().map(|&value| self.closeness(value));
        each.fold(NearZeroHistogram::default(), NearZeroHistogram::or)
    }
}

/// Sets the real part of a value to zero if it is within `tolerance` of zero. Keeps the
/// derivatives.
#[inline]
pub(crate) fn snapped<T: Scalar>(value: T, tolerance: f64) -> T {
    let real = real_part(value);
    if real.abs() <= tolerance {
        value - real
    } else {
        value
    }
}
