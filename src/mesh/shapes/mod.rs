//! Ready-made pressure fields, centered on the origin of the body frame, and solids inside triangles,
//! where those are. Extents are in [0, 1].

mod closed_surface;
mod cored;
mod cuboid;
mod cylinder;
mod icosphere;
mod star_shaped;

pub use cuboid::{cuboid, distance_cuboid};
pub use cylinder::cylinder;
pub use icosphere::{ellipsoid, icosphere};
pub use star_shaped::{star_shaped, star_shaped_about};

use super::MeshError;

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

/// Checks that the count lies within the limits.
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
