//! A logarithmic axis with few ticks.

use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint, Ranged};
use std::ops::Range;

/// Margin on both sides of the values, as a factor.
const ROOM: f64 = 1.6;

/// Logarithmic axis with ticks at the powers of ten. If there would be fewer than three ticks, twice and five times the powers of ten have
/// ticks too.
#[derive(Clone)]
pub struct LogAxis {
    limits: Range<f64>,
    ticks: Vec<f64>,
}

impl LogAxis {
    /// Creates an axis over the values, with a margin.
    pub fn over(values: impl Iterator<Item = f64> + Clone) -> Self {
        let low = values.clone().fold(f64::INFINITY, f64::min) / ROOM;
        let limits = low..values.fold(0.0, f64::max) * ROOM;
        let mut ticks = ticks(&limits, &[1.0]);
        if ticks.len() < 3 {
            ticks = self::ticks(&limits, &[1.0, 2.0, 5.0]);
        }
        Self { limits, ticks }
    }
}

/// Returns the given multiples of powers of ten within the limits.
fn ticks(limits: &Range<f64>, multiples: &[f64]) -> Vec<f64> {
    let powers = (-9..=9).map(|exponent| 10_f64.powi(exponent));
    let all = powers.flat_map(|power| multiples.iter().map(move |multiple| multiple * power));
    all.filter(|tick| limits.contains(tick)).collect()
}

impl Ranged for LogAxis {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    #[expect(clippy::cast_possible_truncation, reason = "a pixel in the picture")]
    fn map(&self, value: &f64, (first, last): (i32, i32)) -> i32 {
        let across = (value / self.limits.start).ln() / (self.limits.end / self.limits.start).ln();
        first + (across * f64::from(last - first)).round() as i32
    }

    fn key_points<H: KeyPointHint>(&self, _: H) -> Vec<f64> {
        self.ticks.clone()
    }

    fn range(&self) -> Range<f64> {
        self.limits.clone()
    }
}
