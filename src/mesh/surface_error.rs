/// The reason why triangles do not make a closed surface.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SurfaceError {
    /// There are fewer triangles than a solid can have.
    #[error("a closed surface needs at least 4 triangles, but {count} were given")]
    TooFewTriangles {
        /// Number of triangles given.
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
    /// A triangle is too thin to have an accurate normal.
    #[error(
        "triangle {triangle} has the area {area:e} m² over a longest edge of {longest_edge:e} m, which is a line to round-off"
    )]
    ThinTriangle {
        /// Index of the triangle.
        triangle: usize,
        /// Its area (m²).
        area: f64,
        /// Its longest edge (m).
        longest_edge: f64,
    },
    /// An edge belongs to one triangle only. The surface has a hole, or coincident vertices were not merged.
    #[error(
        "the surface is not closed: {edge_count} edges belong to one triangle only, among them that from vertex {} to vertex {} of triangle {triangle}",
        edge[0],
        edge[1]
    )]
    Open {
        /// Number of edges with one triangle.
        edge_count: usize,
        /// Index of a triangle with an open edge.
        triangle: usize,
        /// The vertices of the open edge.
        edge: [usize; 2],
    },
    /// More than two triangles meet in an edge.
    #[error(
        "{triangle_count} triangles, among them {first} and {second}, meet in the edge between vertices {} and {}, but only two can",
        edge[0],
        edge[1]
    )]
    CrowdedEdge {
        /// Number of triangles that share the edge.
        triangle_count: usize,
        /// Index of one triangle.
        first: usize,
        /// Index of another triangle.
        second: usize,
        /// The vertices of the edge.
        edge: [usize; 2],
    },
    /// Two triangles that share an edge have inconsistent orientations.
    #[error(
        "triangles {first} and {second} both run from vertex {} to vertex {}: one of them is turned the wrong way round",
        edge[0],
        edge[1]
    )]
    InconsistentOrientation {
        /// Index of one triangle.
        first: usize,
        /// Index of the other.
        second: usize,
        /// The vertices of the edge.
        edge: [usize; 2],
    },
    /// The volume of a connected component is zero to within rounding error.
    #[error(
        "the component of triangle {triangle} encloses {volume:.3e} m³ in a box of diagonal {diagonal:.3e} m, which is flat to round-off"
    )]
    Flat {
        /// The first triangle of the component.
        triangle: usize,
        /// The enclosed volume (m³).
        volume: f64,
        /// Diagonal (m) of the bounding box of the component.
        diagonal: f64,
    },
    /// A connected component is oriented inwards but is not a cavity in another component.
    #[error(
        "the component of triangle {triangle} is turned inwards: it encloses {volume:.3e} m³, and is no cavity, for it does not lie inside another component"
    )]
    Inward {
        /// The first triangle of the component.
        triangle: usize,
        /// The enclosed volume (m³), which is negative.
        volume: f64,
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

impl SurfaceError {
    /// Replaces the index of each vertex by the index in `original`.
    pub(super) fn with_vertices(mut self, original: &[usize]) -> Self {
        match &mut self {
            Self::NonFiniteCoordinate { vertex, .. } | Self::RepeatedVertex { vertex, .. } => {
                *vertex = original[*vertex];
            }
            Self::Open { edge, .. }
            | Self::CrowdedEdge { edge, .. }
            | Self::InconsistentOrientation { edge, .. } => {
                *edge = edge.map(|vertex| original[vertex]);
            }
            // The other errors have no vertex, or cannot occur after unused vertices are dropped.
            _ => {}
        }
        self
    }
}
