//! A ball under a stroboscope.

use super::Answer;
use super::chart::Chart;
use super::style::{BLUE, INK};
use super::view::whole;
use plotters::prelude::*;

/// Distance of the mark from the center of a ball, in radii.
const MARK: f64 = 0.75;

/// A ball at one time: the position of its center, and its rotation in the picture's plane (rad, clockwise).
pub struct Flash {
    pub center: (f64, f64),
    pub turn: f64,
}

/// Draws balls of a radius in pixels, later balls more opaque. A mark near the rim of each ball shows its rotation.
pub fn draw(chart: &mut Chart, flashes: &[Flash], radius: f64) -> Answer {
    let count = flashes.len() as f64;
    for (index, flash) in flashes.iter().enumerate() {
        let strength = 0.08 + 0.3 * index as f64 / count;
        let toward_mark = (flash.turn.sin(), -flash.turn.cos());
        let mark = (
            whole(MARK * radius * toward_mark.0),
            whole(MARK * radius * toward_mark.1),
        );
        let ball = EmptyElement::at(flash.center)
            + Circle::new((0, 0), whole(radius), BLUE.mix(strength).filled())
            + Circle::new((0, 0), whole(radius), BLUE.stroke_width(2))
            + Circle::new(mark, 4, INK.filled());
        chart.draw_series([ball])?;
    }
    Ok(())
}
