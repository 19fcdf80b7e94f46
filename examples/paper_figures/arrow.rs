//! Arrows.

use super::view::{Pixel, whole};
use super::{Answer, Area};
use nalgebra::Vector2;
use plotters::prelude::*;

/// Length and half width (pixels) of a tip.
const TIP: [f64; 2] = [34.0, 13.0];

/// Draws an arrow from one pixel to another.
pub fn draw(area: &Area, [from, to]: [Pixel; 2], color: RGBColor, width: u32) -> Answer {
    let vector = |(x, y): Pixel| Vector2::new(f64::from(x), f64::from(y));
    let pixel = |v: Vector2<f64>| (whole(v.x), whole(v.y));
    let along = (vector(to) - vector(from)).normalize();
    let across = Vector2::new(-along.y, along.x) * TIP[1];
    let neck = vector(to) - along * TIP[0];
    let tip = [to, pixel(neck + across), pixel(neck - across)];
    area.draw(&PathElement::new(
        vec![from, pixel(neck)],
        color.stroke_width(width),
    ))?;
    area.draw(&Polygon::new(tip.to_vec(), color.filled()))?;
    Ok(())
}
