use nalgebra::Vector3;

/// Property of a file that the reader accepts, but that may be a mistake. Positions and lengths are in meters, in the body frame.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FileWarning {
    /// Duplicated vertices were merged, which joined coincident faces. The faces now lie inside the body.
    #[error(
        "merged {vertex_count} duplicated vertices, so that {pair_count} pairs of coincident faces lie inside the body and not on its surface"
    )]
    WeldedVertices {
        /// Number of vertices that were removed.
        vertex_count: usize,
        /// Number of pairs of faces that were joined.
        pair_count: usize,
    },
    /// Faces of different tetrahedra coincide, but do not share their vertices. The pressure is zero on such faces.
    #[error(
        "{pair_count} pairs of faces coincide to within {distance:e} m but do not share vertices, so the pressure on them is zero, first near ({:.4e}, {:.4e}, {:.4e}) m: a weld_tolerance of this distance joins them if the result is a valid mesh",
        at.x, at.y, at.z
    )]
    Seam {
        /// Number of pairs of faces.
        pair_count: usize,
        /// Largest distance between corresponding vertices of two such faces (m).
        distance: f64,
        /// A corner of the first pair of faces.
        at: Vector3<f64>,
    },
    /// Tetrahedra are so thin that fields in them are inaccurate.
    #[error(
        "{count} tetrahedra are thin: the smallest height of the worst is {ratio:.1e} of its longest edge, near ({:.4e}, {:.4e}, {:.4e}) m",
        at.x, at.y, at.z
    )]
    ThinTetrahedra {
        /// Number of thin tetrahedra.
        count: usize,
        /// Smallest height of the worst tetrahedron divided by its longest edge.
        ratio: f64,
        /// A corner of the worst tetrahedron.
        at: Vector3<f64>,
    },
    /// The body is unusually large or small. The unit of the file may be wrong.
    #[error(
        "the body is {size:.3e} m large with a unit of {unit} m: is the unit correct? A unit of 1e-3 m reads millimeters"
    )]
    Size {
        /// Longest side of the bounding box (m).
        size: f64,
        /// Length of a coordinate of 1 in the file (m).
        unit: f64,
    },
    /// Surface cells with vertices that no tetrahedron uses were ignored.
    #[error(
        "ignored {count} surface cells with vertices that no tetrahedron uses: a part of the file is not in the mesh"
    )]
    IgnoredCells {
        /// Number of these cells.
        count: usize,
    },
}
