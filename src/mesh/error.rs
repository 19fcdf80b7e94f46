use super::SurfaceError;

/// The reason why input does not make a tetrahedral mesh or a pressure field.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// There is no tetrahedron.
    #[error("a mesh needs at least one tetrahedron")]
    Empty,
    /// There are more tetrahedra or vertices than 32-bit indices can address.
    #[error("a mesh holds at most {limit} vertices and tetrahedra, but {count} were given")]
    TooLarge {
        /// The given number.
        count: usize,
        /// The largest number supported.
        limit: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error("vertex {vertex} has the coordinate {value}, but coordinates must be finite")]
    NonFiniteCoordinate {
        /// Index of the vertex.
        vertex: usize,
        /// The coordinate.
        value: f64,
    },
    /// A tetrahedron refers to a vertex that does not exist.
    #[error(
        "tetrahedron {tet} refers to vertex {vertex}, but the mesh has {vertex_count} vertices"
    )]
    VertexOutOfRange {
        /// Index of the tetrahedron.
        tet: usize,
        /// The invalid index.
        vertex: usize,
        /// Number of vertices of the mesh.
        vertex_count: usize,
    },
    /// A tetrahedron refers to the same vertex twice.
    #[error("tetrahedron {tet} refers to vertex {vertex} twice, but needs four different corners")]
    RepeatedVertex {
        /// Index of the tetrahedron.
        tet: usize,
        /// Index of the vertex.
        vertex: usize,
    },
    /// A tetrahedron is flat to within rounding error.
    #[error(
        "tetrahedron {tet} has the volume {volume:e} m³ over a longest edge of {longest_edge:e} m, which is flat to round-off"
    )]
    ZeroVolume {
        /// Index of the tetrahedron.
        tet: usize,
        /// Its volume (m³).
        volume: f64,
        /// Its longest edge (m).
        longest_edge: f64,
    },
    /// A vertex belongs to no tetrahedron.
    #[error("vertex {vertex} belongs to no tetrahedron")]
    UnusedVertex {
        /// Index of the vertex.
        vertex: usize,
    },
    /// A face is shared by more than two tetrahedra, or by two on the same side of it.
    #[error(
        "tetrahedra {first} and {second} overlap: they share the face of vertices {face:?}, but lie on the same side of it or share it with a third"
    )]
    OverlappingTets {
        /// Index of one tetrahedron.
        first: usize,
        /// Index of another tetrahedron.
        second: usize,
        /// The vertices of the face.
        face: [usize; 3],
    },
    /// The number of extents is not the number of vertices.
    #[error("a pressure field needs one extent per vertex: {vertex_count}, but has {extent_count}")]
    ExtentCount {
        /// Number of vertices.
        vertex_count: usize,
        /// Number of extents given.
        extent_count: usize,
    },
    /// An extent is negative, NaN or infinite.
    #[error("vertex {vertex} has the extent {value}, but extents must be finite and not negative")]
    InvalidExtent {
        /// Index of the vertex.
        vertex: usize,
        /// The extent.
        value: f64,
    },
    /// A vertex of the surface has an extent other than zero.
    #[error("vertex {vertex} lies on the surface, where the extent must be 0, but has {value}")]
    SurfaceExtent {
        /// Index of the vertex.
        vertex: usize,
        /// The extent.
        value: f64,
    },
    /// The gradient of the extent in a tetrahedron overflows double precision. The extents are too large or the
    /// tetrahedron is too small.
    #[error(
        "the extent in tetrahedron {tet} rises by more per meter than double precision can hold"
    )]
    SteepField {
        /// Index of the tetrahedron.
        tet: usize,
    },
    /// All four extents of a tetrahedron are zero, so it would never carry pressure.
    #[error(
        "tetrahedron {tet} has extent 0 at all four corners, so it would carry no pressure; TetMesh::with_inner_vertices puts a vertex inside each tetrahedron whose corners all lie on the surface"
    )]
    ZeroField {
        /// Index of the tetrahedron.
        tet: usize,
    },
    /// The inner point of a star-shaped solid is NaN or infinite.
    #[error("the inner point of a solid has the coordinate {value}, but must be finite")]
    NonFiniteInnerPoint {
        /// The coordinate.
        value: f64,
    },
    /// A triangle faces away from the inner point of a star-shaped solid.
    #[error(
        "triangle {triangle} cannot be seen from the inner point, which is {distance:.3e} m outside its plane: the solid is not star-shaped about that point"
    )]
    HiddenTriangle {
        /// Index of the triangle.
        triangle: usize,
        /// Distance (m) of the inner point outside the plane of the triangle.
        distance: f64,
    },
    /// The inner point of a star-shaped solid lies in the plane of a triangle to within rounding error, or the triangle
    /// is too small.
    #[error(
        "triangle {triangle} and the inner point span a volume of {volume:.3e} m³, which is flat to round-off: the triangle is too small, or the point lies in its plane"
    )]
    TriangleSeenEdgeOn {
        /// Index of the triangle.
        triangle: usize,
        /// Volume (m³) of the tetrahedron spanned by the triangle and the inner point.
        volume: f64,
    },
    /// The surface of a star-shaped solid winds around the inner point more than once.
    #[error("the surface surrounds the inner point {layers} times, but must do so once")]
    RepeatedSurface {
        /// Number of times the surface winds around the point.
        layers: f64,
    },
    /// A dimension or the resolution of a shape, a depth or a tolerance is not positive and finite.
    #[error("the {name} of a shape must be positive and finite, but is {value}")]
    InvalidDimension {
        /// Name of the dimension.
        name: &'static str,
        /// The value.
        value: f64,
    },
    /// The number of subdivisions, segments, sides or points of a ready-made shape is out of range.
    #[error("a shape takes {lowest} to {highest} {name}, not {found}")]
    InvalidResolution {
        /// Name of the number.
        name: &'static str,
        /// The given number.
        found: usize,
        /// Smallest number allowed.
        lowest: usize,
        /// Largest number allowed.
        highest: usize,
    },
    /// The resolution of a shape needs too many elements.
    #[error(
        "a resolution of {value} m needs too many elements: try at least {suggested} m, or fewer segments if the shape is a lathe"
    )]
    FineResolution {
        /// The resolution (m).
        value: f64,
        /// A larger resolution (m) to try.
        suggested: f64,
    },
    /// Two edges of an outline touch or cross, or one of them has no length.
    #[error(
        "edges {edges:?} of the outline touch or cross, but an outline must be a simple polygon (edge k joins points k and k + 1, and the last edge returns to point 0)"
    )]
    TouchingEdges {
        /// Indices of the edges.
        edges: [usize; 2],
    },
    /// A point of a profile lies on the axis or beyond it.
    #[error(
        "point {point} of the profile has the radius {radius} m: radii must be positive, or 0 at both the first and the last point"
    )]
    ProfileRadius {
        /// Index of the point.
        point: usize,
        /// Its radius (m).
        radius: f64,
    },
    /// The tube of a torus leaves no hole.
    #[error(
        "the tube of a torus has the radius {tube_radius} m, but must be thinner than the radius {radius} m of its center"
    )]
    ThickTube {
        /// Radius (m) of the center of the tube.
        radius: f64,
        /// Radius (m) of the tube.
        tube_radius: f64,
    },
    /// Two parts of a compound overlap.
    #[error(
        "parts {parts:?} of the compound overlap by {depth:.3e} m near {near:?} m, but parts may only touch"
    )]
    OverlappingParts {
        /// Indices of the parts.
        parts: [usize; 2],
        /// Depth (m) of the overlap of two tetrahedra.
        depth: f64,
        /// Center (m) of one of these tetrahedra in the body frame.
        near: [f64; 3],
    },
    /// The number of derivatives or rates is not the number of vertices or extents.
    #[error("{expected} {name} need as many derivatives or rates, but got {found}")]
    RateCount {
        /// Name of the differentiated quantity.
        name: &'static str,
        /// Number of derivatives or rates given.
        found: usize,
        /// Number of derivatives or rates needed.
        expected: usize,
    },
    /// A derivative or a rate is NaN or infinite.
    #[error("number {index} of the derivatives or rates of {name} is {value}, but must be finite")]
    NonFiniteRate {
        /// Name of the differentiated quantity.
        name: &'static str,
        /// Index of the vertex.
        index: usize,
        /// The derivative or rate.
        value: f64,
    },
    /// The triangles of a shape are not a closed surface.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
}
