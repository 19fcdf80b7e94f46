use super::surface_faults::point;
use crate::geometry::Aabb;
use nalgebra::Vector3;

/// Sizes (m) of bodies that no unit has to be suspected of. Millimeters that are read as meters exceed the upper limit.
const COMMON_SIZES: std::ops::RangeInclusive<f64> = 1e-4..=100.0;

/// A property of a surface that is accepted, but is probably not intended.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SurfaceWarning {
    /// Vertices were merged that had different positions, because the surface was not closed otherwise.
    #[error(
        "{vertex_count} vertices were moved by up to {distance:.1e} m to the vertices beside them, which closes the surface"
    )]
    Welded {
        /// Number of vertices that moved.
        vertex_count: usize,
        /// Largest displacement (m).
        distance: f64,
    },
    /// Parts of the surface overlap. Their common volume counts several times in the volume and the mass, and several times in contact.
    #[error(
        "{pair_count} pairs of components overlap, the first near {}: about {volume:.2e} m³ count twice in volume, mass and force; a \
         solid of tetrahedra of these triangles, or their convex hull, counts them once",
        point(near)
    )]
    Overlap {
        /// Number of pairs of components that overlap.
        pair_count: usize,
        /// Estimate of the volume (m³) that counts twice.
        volume: f64,
        /// A point (m) in the first overlap.
        near: Vector3<f64>,
    },
    /// The unit of length is probably wrong.
    #[error(
        "the surface is {size:.3e} m large: is this the unit of the file? A unit of 1e-3 m reads millimeters"
    )]
    Size {
        /// Longest side (m) of the bounding box.
        size: f64,
    },
}

impl SurfaceWarning {
    /// Returns a warning if triangles in this box are larger than 100 m or smaller than 0.1 mm.
    #[must_use]
    pub fn of_size(aabb: &Aabb) -> Option<Self> {
        unusual_size(aabb).map(|size| Self::Size { size })
    }
}

/// Returns the longest side (m) of the bounding box of a body if it is unusual: above 100 m or below 0.1 mm.
pub(crate) fn unusual_size(aabb: &Aabb) -> Option<f64> {
    let size = 2.0 * aabb.half_extents().amax();
    (!COMMON_SIZES.contains(&size)).then_some(size)
}
