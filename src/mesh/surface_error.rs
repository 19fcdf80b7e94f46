use super::surface_faults::{SurfaceFaults, point};
use nalgebra::Vector3;

/// The reason why triangles do not make a closed surface.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SurfaceError {
    /// There are fewer triangles than a solid can have.
    #[error(
        "a closed surface needs at least 4 triangles, but {count} were given: points without triangles have a convex hull \
         (TriangleSoup::convex_hull, hull=True in Python)"
    )]
    TooFewTriangles {
        /// Number of triangles given.
        count: usize,
    },
    /// The repairs of [`TriangleSoup::closed`](super::TriangleSoup::closed) leave fewer triangles than a solid can have.
    #[error(
        "{given} triangles leave only {count} after the repairs, but a closed surface needs at least 4: pairs of triangles with the same \
         corners and opposite orientations cancel, because nothing lies between them; give a sheet a thickness, or use the convex hull \
         (TriangleSoup::convex_hull, hull=True in Python)"
    )]
    Cancelled {
        /// Number of triangles given.
        given: usize,
        /// Number of triangles after the repairs.
        count: usize,
    },
    /// There are more triangles or vertices than 32-bit indices can address.
    #[error("a surface holds at most {limit} vertices and triangles, but {count} were given")]
    TooLarge {
        /// The given number.
        count: usize,
        /// The largest number supported.
        limit: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error("vertex {vertex} has the coordinate {value}, but coordinates must be finite")]
    NonFiniteCoordinate {
        /// Index of the vertex. If triangles do not share vertices, corner k of triangle t has the index 3t + k.
        vertex: usize,
        /// The coordinate.
        value: f64,
    },
    /// A triangle refers to a vertex that does not exist.
    #[error("triangle {triangle} refers to vertex {vertex}, but there are {vertex_count} vertices")]
    VertexOutOfRange {
        /// Index of the triangle.
        triangle: usize,
        /// The invalid index.
        vertex: usize,
        /// Number of vertices.
        vertex_count: usize,
    },
    /// A triangle refers to the same vertex twice, or to two vertices that were merged because their positions are
    /// equal.
    #[error(
        "triangle {triangle} has two corners at vertex {vertex}, but needs three different corners"
    )]
    RepeatedVertex {
        /// Index of the triangle.
        triangle: usize,
        /// Index of the vertex.
        vertex: usize,
    },
    /// A vertex belongs to no triangle.
    #[error("vertex {vertex} belongs to no triangle")]
    UnusedVertex {
        /// Index of the vertex.
        vertex: usize,
    },
    /// A triangle is too thin to have an accurate normal. [`TriangleSoup::closed`](super::TriangleSoup::closed) removes such triangles.
    #[error("triangle {triangle} at {} m has no area, to round-off", point(at))]
    ThinTriangle {
        /// Index of the triangle.
        triangle: usize,
        /// A corner (m) of the triangle.
        at: Vector3<f64>,
    },
    /// The triangles do not enclose a solid: edges belong to one triangle only, or triangles are oriented inconsistently.
    #[error(
        "the surface is not closed: {0}. The convex hull of the triangles is closed (TriangleSoup::convex_hull, hull=True in Python), and \
         TriangleSoup::solid fills them with tetrahedra"
    )]
    NotClosed(Box<SurfaceFaults>),
    /// The points of a convex hull lie in a plane to within rounding error, or there are fewer than four.
    #[error("the convex hull of {point_count} points has no volume")]
    FlatHull {
        /// Number of points.
        point_count: usize,
    },
    /// The volume of a connected component is zero to within rounding error.
    #[error(
        "the component of triangle {triangle} at {} m encloses {volume:.3e} m³ in a box of diagonal {diagonal:.3e} m, which is flat to round-off",
        point(at)
    )]
    Flat {
        /// The first triangle of the component.
        triangle: usize,
        /// A corner (m) of the triangle.
        at: Vector3<f64>,
        /// The enclosed volume (m³).
        volume: f64,
        /// Diagonal (m) of the bounding box of the component.
        diagonal: f64,
    },
    /// A connected component is oriented inwards but is not a cavity in another component.
    #[error(
        "the component of triangle {triangle} at {} m is turned inwards: it encloses {volume:.3e} m³, but is not a cavity, because it does \
         not lie inside another component; if all components are turned inwards, TriangleSoup::flipped reverses them (flip=True in Python)",
        point(at)
    )]
    Inward {
        /// The first triangle of the component.
        triangle: usize,
        /// A corner (m) of the triangle.
        at: Vector3<f64>,
        /// The enclosed volume (m³), which is negative.
        volume: f64,
    },
    /// A connected component is oriented inwards, as a cavity, but lies only partly inside other components.
    #[error(
        "the component of triangle {triangle} is turned inwards, as a cavity, but is only partly inside another component: it sticks out at \
         {} m; if it is not a cavity, TriangleSoup::with_outward_components reverses it",
        point(at)
    )]
    SticksOut {
        /// The first triangle of the component.
        triangle: usize,
        /// A point (m) of the component outside the others.
        at: Vector3<f64>,
    },
    /// The cavities have at least as much volume as the components around them.
    #[error(
        "the components enclose {volume:.3e} m³ together: cavities, which count as negative, leave nothing of the solid around them"
    )]
    NoVolume {
        /// Sum (m³) of the signed volumes of the components.
        volume: f64,
    },
    /// The surface is so large that its volume or one of its moments overflows double precision.
    #[error(
        "the box around the surface has the diagonal {diagonal:e} m, too much for volume and inertia in double precision"
    )]
    BeyondPrecision {
        /// Diagonal (m) of the bounding box of the vertices.
        diagonal: f64,
    },
}
