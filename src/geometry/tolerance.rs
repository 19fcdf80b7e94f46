use crate::scalar::{Scalar, real_part};

/// What counts as zero where a field decides on which side of its zero plane a point lies.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Tolerance {
    /// Values up to this are zero.
    pub zero: f64,
    /// Values up to this are zero by round-off.
    rounding: f64,
}

/// How large values were that are nearly zero, though not by round-off alone: bit k for one from 2ᵏ to 2ᵏ⁺¹ times what
/// round-off makes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Closeness(u32);

impl Closeness {
    /// Values of so many octaves above round-off are noted.
    const OCTAVES: u32 = 20;

    /// A value less than this many octaves above round-off makes a cut ill-conditioned: two planes that are further apart
    /// than that over a body meet in a line placed to one part in 2¹⁴.
    const ILL_CONDITIONED: u32 = 14;

    /// Actual rounding lies this many octaves below the tolerance.
    const CLEARANCE: u32 = 6;

    /// Whether there was a value so near to zero that round-off decides where two planes meet.
    pub fn is_ill_conditioned(self) -> bool {
        self.0 & ((1 << Self::ILL_CONDITIONED) - 1) != 0
    }

    /// Whether there was a value less than so many octaves above round-off.
    pub fn is_within(self, octaves: u32) -> bool {
        self.0 & ((1 << octaves) - 1) != 0
    }

    /// What there was in either.
    pub fn or(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// How many octaves of values, up to `most`, to take for zero: the most for which the smallest value kept is at least
    /// [`Self::CLEARANCE`] octaves above the largest one dropped; if there is no such gap, the split with the widest.
    /// Snapping a corner turns a plane by the ratio of the two.
    pub fn split(self, most: u32) -> u32 {
        if !self.is_within(most) {
            return most;
        }
        let clearance = |split: &u32| {
            let above = (self.0 >> split)
                .trailing_zeros()
                .min(Self::OCTAVES - split);
            let below = self.0 & ((1 << split) - 1);
            above
                + below
                    .checked_ilog2()
                    .map_or(split + Self::CLEARANCE, |top| split - 1 - top)
        };
        let is_clear = |split: &u32| clearance(split) >= Self::CLEARANCE;
        let splits = || (0..=most).rev();
        splits()
            .find(is_clear)
            .or_else(|| splits().max_by_key(clearance))
            .unwrap_or(0)
    }
}

impl Tolerance {
    /// For values that are rounded by much less than this.
    pub fn new(zero: f64) -> Self {
        Self {
            zero,
            rounding: zero,
        }
    }

    /// With values of so many octaves above round-off that count as zero.
    pub fn widened(self, octaves: u32) -> Self {
        Self {
            zero: self.rounding * f64::from(1_u32 << octaves),
            ..self
        }
    }

    /// For values times a factor.
    pub fn scaled(self, factor: f64) -> Self {
        Self {
            zero: self.zero * factor,
            rounding: self.rounding * factor,
        }
    }

    #[inline]
    pub fn closeness(self, value: f64) -> Closeness {
        let value = value.abs();
        if value <= self.rounding || value >= self.rounding * f64::from(1_u32 << Closeness::OCTAVES)
        {
            return Closeness::default();
        }
        let reaches = |octave: &u32| value >= self.rounding * f64::from(1_u32 << octave);
        Closeness(1 << (1..Closeness::OCTAVES).filter(reaches).count())
    }

    /// The closeness of all the values.
    #[inline]
    pub fn closeness_of(self, values: &[f64]) -> Closeness {
        let each = values.iter().map(|&value| self.closeness(value));
        each.fold(Closeness::default(), Closeness::or)
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
