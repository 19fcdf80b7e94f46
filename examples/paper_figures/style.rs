//! Colors and fonts. Color-blind readers can distinguish the colors (M. Okabe, K. Ito).

use super::{Answer, Area};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::path::Path;

pub const BLUE: RGBColor = RGBColor(0, 114, 178);
pub const RED: RGBColor = RGBColor(213, 94, 0);
pub const GREEN: RGBColor = RGBColor(0, 158, 115);
pub const ORANGE: RGBColor = RGBColor(230, 159, 0);
pub const PURPLE: RGBColor = RGBColor(204, 121, 167);
pub const INK: RGBColor = RGBColor(40, 40, 40);
pub const GRAY: RGBColor = RGBColor(130, 130, 130);
pub const FAINT: RGBColor = RGBColor(225, 225, 225);

/// Creates a white drawing area of a size in pixels.
pub fn ground(path: &Path, size: (u32, u32)) -> Answer<Area<'_>> {
    let area = SVGBackend::new(path, size).into_drawing_area();
    area.fill(&WHITE)?;
    Ok(area)
}

/// Returns a text style of a size in pixels.
pub fn letters(size: u32) -> TextStyle<'static> {
    ("sans-serif", size).into_font().color(&INK)
}

/// Draws a text that is centered at a position, or begins or ends there.
pub fn write(
    area: &Area,
    text: &str,
    style: &TextStyle,
    (place, side): ((i32, i32), HPos),
) -> Answer {
    let style = style.pos(Pos::new(side, VPos::Center));
    area.draw_text(text, &style, place)?;
    Ok(())
}

/// Interpolates between two colors.
pub fn between(from: RGBColor, to: RGBColor, share: f64) -> RGBColor {
    let mixed = |a: u8, b: u8| channel(f64::from(a) + share * (f64::from(b) - f64::from(a)));
    RGBColor(
        mixed(from.0, to.0),
        mixed(from.1, to.1),
        mixed(from.2, to.2),
    )
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "held to 0..=255"
)]
fn channel(value: f64) -> u8 {
    value.round().clamp(0.0, 255.0) as u8
}
