//! Colors of the recording.

use nalgebra::Vector3;
use rerun::Rgba32;

/// Color of bodies that never move.
pub const FIXED: Rgba32 = Rgba32::from_rgb(150, 155, 165);
/// The two colors of bodies that move.
pub const MOVING: [Rgba32; 2] = [
    Rgba32::from_rgb(225, 230, 240),
    Rgba32::from_rgb(90, 140, 220),
];
/// Tint of transparent bodies, inside which contact surfaces lie.
pub const GLASS: Rgba32 = Rgba32::from_unmultiplied_rgba(255, 255, 255, 60);
/// Color of force arrows.
pub const FORCE: Rgba32 = Rgba32::from_rgb(60, 220, 120);

/// Colors of the lines in a plot, in turn.
pub const LINES: [Rgba32; 4] = [
    Rgba32::from_rgb(80, 160, 255),
    Rgba32::from_rgb(255, 180, 60),
    Rgba32::from_rgb(255, 80, 140),
    Rgba32::from_rgb(235, 235, 235),
];

/// Colors of zero pressure, of the highest pressure, and of equal steps between them: red, green, blue of 255.
const PRESSURE: [[f64; 3]; 4] = [
    [40.0, 20.0, 110.0],
    [175.0, 40.0, 120.0],
    [245.0, 120.0, 30.0],
    [255.0, 245.0, 140.0],
];

/// Returns the color of a pressure, given as a fraction of the highest pressure.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "from 0 to 3, and from 0 to 255"
)]
pub fn pressure(share: f64) -> Rgba32 {
    let place = share.clamp(0.0, 1.0) * (PRESSURE.len() - 1) as f64;
    let below = (place as usize).min(PRESSURE.len() - 2);
    let [low, high] = [below, below + 1].map(|stop| Vector3::from(PRESSURE[stop]));
    let [r, g, b] = low.lerp(&high, place - below as f64).into();
    Rgba32::from_rgb(r as u8, g as u8, b as u8)
}
