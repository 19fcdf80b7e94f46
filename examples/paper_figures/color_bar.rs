//! Shades of green for pressures, from light to dark, and the color bar.

use super::style::{INK, between, letters, write};
use super::view::{Pixel, whole};
use super::{Answer, Area};
use plotters::prelude::*;
use plotters::style::text_anchor::HPos;

const LIGHT: RGBColor = RGBColor(240, 246, 200);
const MIDDLE: RGBColor = RGBColor(60, 170, 100);
const DARK: RGBColor = RGBColor(0, 52, 38);

/// Width and height (pixels) of the bar.
const SIZE: (i32, i32) = (40, 520);

/// Number of shades between 0 and the highest pressure.
pub const LEVELS: u32 = 16;

/// Returns the start of a level, as a fraction of the highest pressure.
pub fn share(level: u32) -> f64 {
    f64::from(level) / f64::from(LEVELS)
}

/// Returns the shade of a level.
pub fn color(level: u32) -> RGBColor {
    let share = f64::from(level) / f64::from(LEVELS - 1);
    if share < 0.5 {
        between(LIGHT, MIDDLE, 2.0 * share)
    } else {
        between(MIDDLE, DARK, 2.0 * share - 1.0)
    }
}

/// Draws the bar from 0 to the highest pressure (kPa), with a mark at every multiple of `every`.
pub fn draw(area: &Area, (left, top): Pixel, highest: f64, every: f64) -> Answer {
    let right = left + SIZE.0;
    let height = |share: f64| top + whole(f64::from(SIZE.1) * (1.0 - share));
    for level in 0..LEVELS {
        let [from, to] = [level, level + 1].map(|step| height(share(step)));
        let corners = [(left, to), (right, from)];
        area.draw(&Rectangle::new(corners, color(level).filled()))?;
    }
    area.draw(&Rectangle::new([(left, top), (right, top + SIZE.1)], INK))?;
    let marks = (0..).map(|step| f64::from(step) * every);
    for mark in marks.take_while(|mark| *mark <= highest) {
        let y = height(mark / highest);
        area.draw(&PathElement::new([(right, y), (right + 10, y)], INK))?;
        let place = ((right + 20, y), HPos::Left);
        write(area, &format!("{mark}"), &letters(26), place)?;
    }
    write(
        area,
        "pressure (kPa)",
        &letters(28),
        ((left, top - 36), HPos::Left),
    )
}
