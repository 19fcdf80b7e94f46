//! Quartiles of errors along many motions.

use crate::show::{Curve, Panel};
use crate::tosses::RATE;

/// Curves, with the number of quarters of the errors below them.
const CURVES: [(&str, usize); 3] = [("upper quartile", 3), ("median", 2), ("lower quartile", 1)];

/// Returns a panel with the quartiles over motions of the errors of the first body, multiplied by `scale`, against time. The curves end
/// before the first frame that fewer than half of the motions reach.
pub fn panel<'e>(
    y_label: &'static str,
    motions: impl Iterator<Item = &'e Vec<Vec<f64>>>,
    scale: f64,
) -> Panel {
    let motions: Vec<&Vec<Vec<f64>>> = motions.collect();
    let sorted = |frame: usize| {
        let errors = motions.iter().filter_map(|errors| errors.get(frame));
        let mut errors: Vec<f64> = errors.map(|bodies| scale * bodies[0]).collect();
        errors.sort_by(f64::total_cmp);
        (errors.len() >= motions.len().div_ceil(2).max(1)).then_some(errors)
    };
    let frames: Vec<Vec<f64>> = (0..).map_while(sorted).collect();
    let curve = |(name, quarters): (&str, usize)| {
        let points = frames.iter().enumerate();
        Curve::new(
            name,
            points.map(|(frame, errors)| (frame as f64 / RATE, quartile(errors, quarters))),
        )
    };
    Panel {
        x_label: "time (s)",
        y_label,
        is_log: false,
        curves: CURVES.map(curve).into(),
    }
}

/// Returns a quartile of sorted values, by linear interpolation.
fn quartile(sorted: &[f64], quarters: usize) -> f64 {
    let rank = quarters * (sorted.len() - 1);
    let (value, next) = (sorted[rank / 4], sorted[rank.div_ceil(4)]);
    value + 0.25 * (rank % 4) as f64 * (next - value)
}
