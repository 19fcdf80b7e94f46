//! Colours.

use nalgebra::Vector3;
use rerun::{Color, Rgba32};

/// Bodies that never move: seen through.
pub const FIXED: Color = Color(Rgba32::from_unmultiplied_rgba(150, 155, 165, 110));
/// The two colours of bodies that move: seen through as well.
pub const MOVING: [Color; 2] = [
    Color(Rgba32::from_unmultiplied_rgba(225, 230, 240, 110)),
    Color(Rgba32::from_unmultiplied_rgba(90, 140, 220, 110)),
];
/// Forces.
pub const FORCE: Color = Color(Rgba32::from_rgb(60, 220, 120));

/// Colours of no pressure, of the highest, and of equal steps between: red, green, blue of 255.
const PRESSURE: [[f64; 3]; 4] = [
    [40.0, 20.0, 110.0],
    [175.0, 40.0, 120.0],
    [245.0, 120.0, 30.0],
    [255.0, 245.0, 140.0],
];

/// The colour of a share, from 0 to 1, of the highest pressure.
pub fn pressure(share: f64) -> Color {
    let place = share.clamp(0.0, 1.0) * (PRESSURE.len() - 1) as f64;
    let below = (place as usize).min(PRESSURE.len() - 2);
    let [low, high] = [below, below + 1].map(|stop| Vector3::from(PRESSURE[stop]));
    let [r, g, b] = low.lerp(&high, place - below as f64).into();
    Color::from_rgb(r as u8, g as u8, b as u8)
}
