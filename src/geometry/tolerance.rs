use crate::scalar::{Scalar, real_part};

/// What counts as zero where a field decides on which side of its zero plane a point lies.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Tolerance {
    /// Values up to this are zero.
    pub zero: f64,
    /// Actual rounding: [`NearZeroHistogram::CLEARANCE`] octaves below what counts as zero, unless that is widened.
    rounding: f64,
}

/// How large values were that are nearly zero, though not by actual rounding alone. Bit k says that there was one from 2ᵏ to
/// 2ᵏ⁺¹ times the actual rounding, which is [`Self::CLEARANCE`] octaves below the tolerance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct NearZeroHistogram(u32);

impl NearZeroHistogram {
    /// Actual rounding lies this many octaves below the tolerance for it.
    const CLEARANCE: u32 = 6;

    /// Values of so many octaves above actual rounding are noted.
    const OCTAVES: u32 = Self::CLEARANCE + 20;

    /// A plane is turned by less than one part in 16 if corners beyond a gap of this many octaves are snapped.
    const LEAST_GAP: u32 = 5;

    /// A value less than this many octaves above the tolerance makes a cut ill-conditioned: two planes that are further
    /// apart than that over a body meet in a line placed to one part in 2¹⁴.
    const ILL_CONDITIONED: u32 = 14;

    /// Whether there was a value so near to zero that round-off decides where two planes meet.
    pub fn is_ill_conditioned(self) -> bool {
        self.is_within(Self::ILL_CONDITIONED)
    }

    /// Octaves between the largest value below a split, or actual rounding, and the smallest one above.
    fn gap(self, split: u32) -> u32 {
        let above = (self.0 >> split)
            .trailing_zeros()
            .min(Self::OCTAVES.saturating_sub(split));
        let below = self.0 & ((1 << split) - 1);
        above + below.checked_ilog2().map_or(split, |top| split - 1 - top)
    }

    /// Whether there was a value above the tolerance by less than so many octaves.
    pub fn is_within(self, octaves: u32) -> bool {
        (self.0 >> Self::CLEARANCE) & ((1 << octaves) - 1) != 0
    }

    /// What there was in either.
    pub fn or(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Returns by how many octaves to widen the tolerance, so that it lies in a gap between values: snapping a corner turns a plane
    /// by the ratio of the largest value dropped to the smallest one kept.
    ///
    /// With `merges`, a gap of [`Self::LEAST_GAP`] octaves is preferred that has a value below it and above the margin, so that
    /// something counts as coincident. Otherwise chooses the most octaves up to `most` with a gap of [`Self::CLEARANCE`]
    /// octaves. If there is none, chooses the fewest above `most` with one, up to [`Self::CLEARANCE`] above. If there is none either,
    /// chooses the widest gap, which may be below the margin (a negative number), and of equal gaps the last in that order.
    pub fn split(self, most: u32, merges: bool) -> i32 {
        let (none, most) = (Self::CLEARANCE, Self::CLEARANCE + most);
        let preferred = || (none..=most).rev().chain(most + 1..=most + Self::CLEARANCE);
        let clearance = |split: &u32| self.gap(*split);
        let has_merged = |split: &u32| (self.0 & ((1 << *split) - 1)) >> none != 0;
        let is_merging =
            |split: &u32| merges && has_merged(split) && clearance(split) >= Self::LEAST_GAP;
        let split = preferred()
            .find(is_merging)
            .or_else(|| preferred().find(|split| clearance(split) >= Self::CLEARANCE))
            .or_else(|| (0..none).chain(preferred()).max_by_key(clearance));
        split.map_or(0, |split| split.cast_signed() - none.cast_signed())
    }
}

impl Tolerance {
    /// For values that are rounded by much less than this.
    pub fn new(zero: f64) -> Self {
        let octaves = f64::from(1_u32 << NearZeroHistogram::CLEARANCE);
        Self {
            zero,
            rounding: zero / octaves,
        }
    }

    /// With values of so many octaves above the first tolerance that count as zero.
    pub fn widened(self, octaves: i32) -> Self {
        Self {
            zero: self.rounding * 2_f64.powi(octaves + NearZeroHistogram::CLEARANCE.cast_signed()),
            ..self
        }
    }

    /// Up to here values are noted: nothing depends on how near to zero larger ones are.
    pub fn noted(self) -> f64 {
        self.rounding * f64::from(1_u32 << NearZeroHistogram::OCTAVES)
    }

    /// How far values that count as zero may misplace a plane in a tetrahedron, as a fraction of its longest edge: along an edge
    /// by their ratio to the smallest value that does not. Twice that, to be sure.
    pub fn misplacement(self, closeness: NearZeroHistogram) -> f64 {
        let is_zero = |octave: &u32| self.rounding * f64::from(1_u32 << octave) <= self.zero;
        let split = (1..=NearZeroHistogram::OCTAVES)
            .rev()
            .find(is_zero)
            .unwrap_or(0);
        2.0 * 2_f64.powi(-closeness.gap(split).cast_signed())
    }

    /// For values times a factor.
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

    /// The closeness of all the values.
    #[inline]
    pub fn closeness_of(self, values: &[f64]) -> NearZeroHistogram {
        let each = values.iter().map(|&value| self.closeness(value));
        each.fold(NearZeroHistogram::default(), NearZeroHistogram::or)
    }
}

/// The value, its real part set to zero where that is within `tolerance` of zero; the derivatives
/// stay.
#[inline]
pub(crate) fn snapped<T: Scalar>(value: T, tolerance: f64) -> T {
    let real = real_part(value);
    if real.abs() <= tolerance {
        value - real
    } else {
        value
    }
}
