//! Colors and materials.

use crate::scalar::portable::powf;
use gltf_json::Material;
use gltf_json::extensions::material::{Material as Extensions, Unlit};
use gltf_json::material::{AlphaMode, PbrBaseColorFactor, PbrMetallicRoughness, StrengthFactor};
use gltf_json::validation::Checked;

/// Red, green and blue from 0 to 255, as on a screen (sRGB).
pub(super) type Color = [u8; 3];

/// Colors of moving bodies, one after the other, told apart by color-blind eyes too [Okabe 2008].
pub(super) const BODIES: [Color; 6] = [
    [86, 180, 233],
    [230, 159, 0],
    [0, 158, 115],
    [204, 121, 167],
    [213, 94, 0],
    [0, 114, 178],
];
/// Of bodies that do not move by forces.
pub(super) const SCENERY: Color = [150, 155, 160];
pub(super) const EDGES: Color = [40, 45, 50];
pub(super) const FORCE: Color = [200, 30, 30];
pub(super) const TORQUE: Color = [120, 60, 170];
pub(super) const TARGET: Color = [0, 150, 60];
/// Of the first path and of the last one.
pub(super) const PATHS: [Color; 2] = [[160, 175, 215], [20, 60, 200]];

/// From no pressure to the largest one.
const PRESSURES: [Color; 5] = [
    [13, 8, 135],
    [126, 3, 168],
    [204, 71, 120],
    [248, 149, 64],
    [240, 249, 33],
];

/// The color of a pressure from 0 to 1, linear, with alpha.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the numbers lie between 0 and 255"
)]
pub(super) fn pressure_color(pressure: f64) -> [u8; 4] {
    let place = pressure.clamp(0.0, 1.0) * (PRESSURES.len() - 1) as f64;
    let below = (place as usize).min(PRESSURES.len() - 2);
    let color = mixed(PRESSURES[below], PRESSURES[below + 1], place - below as f64);
    let [r, g, b] = color.map(|part| (255.0 * linear(part)).round() as u8);
    [r, g, b, u8::MAX]
}

/// A color between two, from 0 at the first to 1 at the second.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the numbers lie between 0 and 255"
)]
pub(super) fn mixed(first: Color, second: Color, place: f64) -> Color {
    std::array::from_fn(|part| {
        let [from, to] = [first, second].map(|color| f64::from(color[part]));
        (from + (to - from) * place).round() as u8
    })
}

/// Lit by the viewer, and seen through if `alpha` is below 1.
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

/// The same color in any light, from both sides.
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

/// Light, from 0 to 1, of a part of an sRGB color (IEC 61966-2-1).
fn linear(part: u8) -> f64 {
    let part = f64::from(part) / 255.0;
    if part <= 0.04045 {
        part / 12.92
    } else {
        powf((part + 0.055) / 1.055, 2.4)
    }
}
