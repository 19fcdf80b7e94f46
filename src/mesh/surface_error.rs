/// Why triangles do not make a closed surface.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SurfaceError {
    /// Fewer triangles than any solid has.
    #[error("a closed surface needs at least 4 triangles, but {count} were given")]
    TooFewTriangles {
        /// How many were given.
        count: usize,
    },
    /// More triangles or vertices than 32-bit indices can name.
    #[error("a surface holds at most {limit} vertices and triangles, but {count} were given")]
    TooLarge {
        /// What was given.
        count: usize,
        /// What fits.
        limit: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error("vertex {vertex} has the coordinate {value}, but coordinates must be finite")]
    NonFiniteCoordinate {
        /// Index of the vertex; where each triangle has corners of its own, corner k of triangle t has the index 3t + k.
        vertex: usize,
        /// The coordinate.
        value: f64,
    },
    /// A triangle names a vertex that does not exist.
    #[error("triangle {triangle} refers to vertex {vertex}, but there are {vertex_count} vertices")]
    VertexOutOfRange {
        /// Index of the triangle.
        triangle: usize,
        /// The index it refers to.
        vertex: usize,
        /// How many vertices there are.
        vertex_count: usize,
    },
    /// A triangle names a vertex twice, or two vertices that were merged because they are at the same place.
    #[error(
        "triangle {triangle} has two corners at vertex {vertex}, but needs three different corners"
    )]
    RepeatedVertex {
        /// Index of the triangle.
        triangle: usize,
        /// The vertex.
        vertex: usize,
    },
    /// A vertex belongs to no triangle.
    #[error("vertex {vertex} belongs to no triangle")]
    UnusedVertex {
        /// Index of the vertex.
        vertex: usize,
    },
    /// A triangle has no normal to speak of.
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
    /// Edges that belong to one triangle only: the surface has holes, or vertices at the same place are not one.
    #[error(
        "the surface is not closed: {edge_count} edges belong to one triangle only, among them that from vertex {} to vertex {} of triangle {triangle}",
        edge[0],
        edge[1]
    )]
    Open {
        /// How many such edges there are.
        edge_count: usize,
        /// A triangle with such an edge.
        triangle: usize,
        /// The vertices of that edge.
        edge: [usize; 2],
    },
    /// More than two triangles meet in an edge.
    #[error(
        "{triangle_count} triangles, among them {first} and {second}, meet in the edge between vertices {} and {}, but only two can",
        edge[0],
        edge[1]
    )]
    CrowdedEdge {
        /// How many triangles meet there.
        triangle_count: usize,
        /// One of them.
        first: usize,
        /// Another.
        second: usize,
        /// The vertices of the edge.
        edge: [usize; 2],
    },
    /// Two triangles that share an edge are turned different ways.
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
    /// A connected component encloses no volume to speak of.
    #[error(
        "the component of triangle {triangle} encloses {volume:.3e} m³ in a box of diagonal {diagonal:.3e} m, which is flat to round-off"
    )]
    Flat {
        /// The first triangle of the component.
        triangle: usize,
        /// The volume (m³) inside.
        volume: f64,
        /// Diagonal (m) of the component's box.
        diagonal: f64,
    },
    /// A connected component is turned inwards without being a cavity in another.
    #[error(
        "the component of triangle {triangle} is turned inwards: it encloses {volume:.3e} m³, and is no cavity, for it does not lie inside another component"
    )]
    Inward {
        /// The first triangle of the component.
        triangle: usize,
        /// The volume (m³) inside, negative.
        volume: f64,
    },
    /// The cavities have as much volume as the components around them, or more.
    #[error(
        "the components enclose {volume:.3e} m³ together: cavities, which count as negative, leave nothing of the solid around them"
    )]
    NoVolume {
        /// The sum (m³) of the components' volumes.
        volume: f64,
    },
    /// The surface is so large that its volume, or a moment of it, is beyond double precision.
    #[error(
        "the box around the surface has the diagonal {diagonal:e} m, too much for volume and inertia in double precision"
    )]
    BeyondPrecision {
        /// Diagonal (m) of the smallest box around the vertices.
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
            // The other errors name no vertex, or cannot occur after unused vertices are dropped.
            _ => {}
        }
        self
    }
}
