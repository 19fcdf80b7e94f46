//! Ready-made pressure fields, fields of outlines, closed surfaces and points, and compounds. Extents are in [0, 1].
//!
//! Each shape with dimensions has a function `…_rates`, which takes the same arguments. It returns the rates of change
//! of the vertices and extents with respect to the dimensions.
//! [`ShapeGradient::along`](crate::contact::ShapeGradient::along) uses the rates to convert derivatives with respect to
//! the shape into derivatives with respect to the dimensions.

mod capsule;
mod compound;
mod convex_hull;
mod cored;
mod cross_section;
mod cuboid;
mod cylinder;
mod extrusion;
mod icosphere;
mod lathe;
mod outline;
mod staircase;
mod star_shaped;
mod torus;

pub use capsule::{capsule, capsule_rates};
pub use compound::compound;
pub use convex_hull::convex_hull;
pub use cuboid::{cuboid, cuboid_rates, distance_cuboid, distance_cuboid_rates};
pub use cylinder::{cylinder, cylinder_rates};
pub use extrusion::{extrusion, extrusion_rates};
pub use icosphere::{ellipsoid, ellipsoid_rates, icosphere, icosphere_rates};
pub use lathe::{lathe, lathe_rates};
pub use star_shaped::{star_shaped, star_shaped_about};
pub use torus::{torus, torus_rates};

use super::MeshError;
use crate::scalar::DenseDual;

/// Largest mean error of the interpolated distance in extrusions and solids of revolution, over the mean distance.
const DISTANCE_ERROR: f64 = 0.005;

/// Returns the lengths (m) as independent dual variables, in order.
fn variables<const N: usize>(lengths: [f64; N]) -> [DenseDual<N>; N] {
    std::array::from_fn(|index| DenseDual::variable(lengths[index], index))
}

/// Returns the lengths (m) if all are positive and finite.
fn checked_lengths<const N: usize>(
    lengths: [(&'static str, f64); N],
) -> Result<[f64; N], MeshError> {
    for (name, value) in lengths {
        if !(value > 0.0 && value.is_finite()) {
            return Err(MeshError::InvalidDimension { name, value });
        }
    }
    Ok(lengths.map(|(_, value)| value))
}

/// Returns the radius and the length (m) of a round solid if both are positive and finite, and the number of segments is within the limits.
fn checked_round_dimensions(
    radius: f64,
    length: f64,
    (segments, limits): (usize, [usize; 2]),
) -> Result<[f64; 2], MeshError> {
    let dimensions = checked_lengths([("radius", radius), ("length", length)])?;
    check_resolution("segments", segments, limits)?;
    Ok(dimensions)
}

/// Checks that the number lies within the limits (inclusive).
fn check_resolution(
    name: &'static str,
    found: usize,
    [lowest, highest]: [usize; 2],
) -> Result<(), MeshError> {
    if (lowest..=highest).contains(&found) {
        return Ok(());
    }
    Err(MeshError::InvalidResolution {
        name,
        found,
        lowest,
        highest,
    })
}
