//! Ready-made pressure fields, centered on the origin of the body frame, and solids inside triangles,
//! where those are. Extents are in [0, 1].
//!
//! For a shape with dimensions, a function `…_rates` of the same arguments tells how its vertices and extents change with
//! them: with [`ShapeGradient::along`](crate::contact::ShapeGradient::along), derivatives by the shape become those by the dimensions.

mod cored;
mod cuboid;
mod cylinder;
mod icosphere;
mod star_shaped;

pub use cuboid::{cuboid, cuboid_rates, distance_cuboid, distance_cuboid_rates};
pub use cylinder::{cylinder, cylinder_rates};
pub use icosphere::{ellipsoid, ellipsoid_rates, icosphere, icosphere_rates};
pub use star_shaped::{star_shaped, star_shaped_about};

use super::MeshError;
use crate::scalar::DenseDual;

/// The lengths (m) as variables, in their order.
fn variables<const N: usize>(lengths: [f64; N]) -> [DenseDual<N>; N] {
    std::array::from_fn(|place| DenseDual::variable(lengths[place], place))
}

/// The lengths, if all are positive and finite.
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

/// Checks that the count lies within the limits, which are allowed themselves.
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
