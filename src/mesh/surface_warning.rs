use super::surface_faults::point;
use crate::geometry::Aabb;
use nalgebra::Vector3;

/// Usual sizes (m) of bodies. A body of more than 10 mm exceeds the upper limit if its millimeters are read as meters.
const USUAL_SIZES: std::ops::RangeInclusive<f64> = 1e-4..=10.0;

/// Property of a surface that is accepted, but may be a mistake.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SurfaceWarning {
    /// Vertices at different positions were merged, because the surface was not closed otherwise.
    #[error(
        "{vertex_count} vertices were moved by up to {distance:.1e} m onto other vertices, to close the surface"
    )]
    Welded {
        /// Number of vertices that moved.
        vertex_count: usize,
        /// Largest displacement (m).
        distance: f64,
    },
    /// Triangles that repeat another one with the same orientation were dropped. With them, the solid would count twice.
    #[error(
        "{triangle_count} triangles were dropped, because they repeat others with the same corners and orientation"
    )]
    Repeated {
        /// Number of triangles dropped.
        triangle_count: usize,
    },
    /// Components of the surface overlap. Volume, mass and contact forces count their common volume more than once.
    #[error(
        "{pair_count} pairs of components overlap, the first near {} m: about {volume:.2e} m³ counts twice in volume, mass and force; a \
         Solid of these triangles, or their convex hull, counts it once",
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
    /// The surface has so many components that not all of them were searched for overlaps.
    #[error(
        "only the first {pair_count} pairs of components with overlapping boxes were searched for overlaps, and there are more"
    )]
    UnsearchedPairs {
        /// Number of pairs that were searched.
        pair_count: usize,
    },
    /// The unit of length is probably wrong.
    #[error(
        "the surface is {size:.3e} m large: is the unit correct? A unit of 1e-3 m reads millimeters"
    )]
    Size {
        /// Longest side (m) of the bounding box.
        size: f64,
    },
}

impl SurfaceWarning {
    /// Returns a warning if triangles in this box are larger than 10 m or smaller than 0.1 mm.
    #[must_use]
    pub fn of_size(aabb: &Aabb) -> Option<Self> {
        unusual_size(aabb).map(|size| Self::Size { size })
    }
}

/// Returns the longest side (m) of the bounding box of a body if it is unusual: above 10 m or below 0.1 mm.
pub(crate) fn unusual_size(aabb: &Aabb) -> Option<f64> {
    let size = 2.0 * aabb.half_extents().amax();
    (!USUAL_SIZES.contains(&size)).then_some(size)
}
