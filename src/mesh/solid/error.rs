use crate::mesh::{MeshError, SurfaceError};

/// Reason why a region cannot be filled with tetrahedra.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SolidError {
    /// There are no triangles, or all are degenerate.
    #[error("a solid needs triangles with a positive area, but there are none")]
    NoTriangles,
    /// A triangle refers to a vertex that does not exist, or a coordinate is NaN or infinite.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    /// The bounds of the triangles or of a distance function have no interior, or second moments (m⁵) that overflow or underflow.
    #[error(
        "the size of the region is {size:?} m, but each length must be between about 1e-61 m and 1e61 m"
    )]
    NoSize {
        /// Size of the box around the region (m).
        size: [f64; 3],
    },
    /// A spacing or a tolerance is not positive and finite.
    #[error("the {name} of a solid must be positive and finite, but is {value}")]
    InvalidResolution {
        /// Name of the number.
        name: &'static str,
        /// The value.
        value: f64,
    },
    /// The lattice would have too many cells.
    #[error(
        "a spacing of {spacing:e} m needs {cells:.3e} cells, but at most 1e8 are supported: choose a larger spacing"
    )]
    TooFine {
        /// The spacing (m).
        spacing: f64,
        /// Number of cells of the lattice.
        cells: f64,
    },
    /// No point of the lattice lies inside.
    #[error(
        "no point of a lattice with a spacing of {spacing:e} m lies inside: choose a smaller spacing or tighter bounds, or check that the triangles enclose a solid"
    )]
    Empty {
        /// The smallest spacing that was tried (m).
        spacing: f64,
    },
    /// A distance function returned the wrong number of values.
    #[error("the distance function returned {found} values for {expected} points")]
    DistanceCount {
        /// Number of values.
        found: usize,
        /// Number of points.
        expected: usize,
    },
    /// A distance is NaN or infinite.
    #[error("the distance function is {value} at {point:?} m, but distances must be finite")]
    NonFiniteDistance {
        /// The point (m).
        point: [f64; 3],
        /// The value.
        value: f64,
    },
    /// The region of negative distances reaches beyond the bounds.
    #[error(
        "the distance is {distance:e} m at {point:?} m, on or outside of the bounds: choose bounds that contain the whole region"
    )]
    BeyondBounds {
        /// A point inside the region (m).
        point: [f64; 3],
        /// The distance there (m).
        distance: f64,
    },
    /// The tetrahedra are not a valid mesh.
    #[error(transparent)]
    Mesh(#[from] MeshError),
}
