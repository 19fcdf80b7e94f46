//! Colors and materials of a recording.

use crate::scalar::portable::powf;
use gltf_json::Material;
use gltf_json::extensions::material::{Material as Extensions, Unlit};
use gltf_json::material::{AlphaMode, PbrBaseColorFactor, PbrMetallicRoughness, StrengthFactor};
use gltf_json::validation::Checked;

/// Red, green and blue from 0 to 255, as on a screen (sRGB).
pub(super) type Color = [u8; 3];

/// Colors of dynamic bodies, in order. Color-blind viewers can distinguish them [Okabe 2008].
pub(super) const BODIES: [Color; 6] = [
    [86, 180, 233],
    [230, 159, 0],
    [0, 158, 115],
    [204, 121, 167],
    [213, 94, 0],
    [0, 114, 178],
];
/// Color of fixed and kinematic bodies.
pub(super) const SCENERY: Color = [150, 155, 160];
pub(super) const EDGES: Color = [40, 45, 50];
pub(super) const FORCE: Color = [200, 30, 30];
pub(super) const TORQUE: Color = [120, 60, 170];
pub(super) const TARGET: Color = [0, 150, 60];
/// End colors of the paths, from the first to the last.
pub(super) const PATHS: [Color; 2] = [[160, 175, 215], [20, 60, 200]];

/// Color map of the pressure, from zero to the largest pressure.
const PRESSURES: [Color; 5] = [
    [13, 8, 135],
    [126, 3, 168],
    [204, 71, 120],
    [248, 149, 64],
    [240, 249, 33],
];

/// Color of a relative pressure from 0 to 1: linear red, green, blue and alpha.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the numbers lie between 0 and 255"
)]
pub(super) fn pressure_color(pressure: f64) -> [u8; 4] {
    let position = pressure.clamp(0.0, 1.0) * (PRESSURES.len() - 1) as f64;
    let below = (position as usize).min(PRESSURES.len() - 2);
    let color = mixed(
        PRESSURES[below],
        PRESSURES[below + 1],
        position - below as f64,
    );
    let [r, g, b] = color.map(|part| (255.0 * linear(part)).round() as u8);
    [r, g, b, u8::MAX]
}

/// Linear interpolation between two colors: `fraction` is 0 at the first and 1 at the second.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the numbers lie between 0 and 255"
)]
pub(super) fn mixed(first: Color, second: Color, fraction: f64) -> Color {
    std::array::from_fn(|part| {
        let [from, to] = [first, second].map(|color| f64::from(color[part]));
        (from + (to - from) * fraction).round() as u8
    })
}

/// Material that is lit by the viewer, and translucent if `alpha` is below 1.
pub(super) fn lit(color: Color, alpha: f32) -> Material {
    let [r, g, b] = linear_color(color);
    Material {
        name: None,
        alpha_mode: Checked::Valid(if alpha < 1.0 {
            AlphaMode::Blend
        } else {
            AlphaMode::Opaque
        }),
        pbr_metallic_roughness: PbrMetallicRoughness {
            base_color_factor: PbrBaseColorFactor([r, g, b, alpha]),
            metallic_factor: StrengthFactor(0.0),
            roughness_factor: StrengthFactor(0.8),
            ..PbrMetallicRoughness::default()
        },
        ..Material::default()
    }
}

/// Double-sided material with the same color in any light.
pub(super) fn unlit(color: Color, alpha: f32) -> Material {
    Material {
        double_sided: true,
        extensions: Some(Extensions {
            unlit: Some(Unlit {}),
        }),
        ..lit(color, alpha)
    }
}

#[expect(clippy::cast_possible_truncation, reason = "glTF has single precision")]
fn linear_color(color: Color) -> [f32; 3] {
    color.map(|part| linear(part) as f32)
}

/// Linear intensity, from 0 to 1, of a component of an sRGB color (IEC 61966-2-1).
fn linear(part: u8) -> f64 {
    let part = f64::from(part) / 255.0;
    if part <= 0.04045 {
        part / 12.92
    } else {
        powf((part + 0.055) / 1.055, 2.4)
    }
}
