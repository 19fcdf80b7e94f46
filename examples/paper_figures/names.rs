//! Names of curves and dots in a picture.

use super::style::{letters, write};
use super::view::Pixel;
use super::{Answer, Area};
use plotters::prelude::*;
use plotters::style::text_anchor::HPos;

/// Pixels between successive names, and the length of a sample line.
const ROW: i32 = 36;
const SAMPLE: i32 = 44;

/// Drawing style of a curve or of dots.
pub enum Sample {
    Line(ShapeStyle),
    Dashes(ShapeStyle),
    Dot(u32, ShapeStyle),
    Patch(ShapeStyle),
}

/// Draws names below each other, starting at a position.
pub fn draw(area: &Area, (left, top): Pixel, names: &[(Sample, &str)]) -> Answer {
    for (row, (sample, name)) in (0..).zip(names) {
        let y = top + ROW * row;
        draw_sample(area, (left, y), sample)?;
        let place = ((left + SAMPLE + 14, y), HPos::Left);
        write(area, name, &letters(23), place)?;
    }
    Ok(())
}

fn draw_sample(area: &Area, (x, y): Pixel, sample: &Sample) -> Answer {
    let end = x + SAMPLE;
    match sample {
        Sample::Line(style) => area.draw(&PathElement::new([(x, y), (end, y)], *style))?,
        Sample::Dashes(style) => {
            for dash in [x, x + 17, x + 34] {
                area.draw(&PathElement::new([(dash, y), (dash + 10, y)], *style))?;
            }
        }
        Sample::Dot(radius, style) => {
            area.draw(&Circle::new((x + SAMPLE / 2, y), *radius, *style))?;
        }
        Sample::Patch(style) => {
            area.draw(&Rectangle::new([(x, y - 11), (end, y + 11)], *style))?;
        }
    }
    Ok(())
}
