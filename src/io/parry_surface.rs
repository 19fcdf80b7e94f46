use crate::mesh::{MeshError, SurfaceError, TriangleSoup, TriangleSurface};
use nalgebra::Vector3;
use parry3d_f64::math::Vec3;
use parry3d_f64::shape::{Shape, ShapeType, TypedShape};

/// Valid numbers of segments of a circle. With fewer segments the shape is not a solid. With many
/// more, the number of triangles of a sphere would exceed a `u32`.
const SEGMENT_RANGE: std::ops::RangeInclusive<u32> = 4..=4096;

/// Reason why a shape of parry cannot be converted to a surface or a pressure field.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ShapeError {
    /// Shapes of this kind have no triangulation.
    #[error(
        "a shape of the kind {kind:?} cannot become a surface: balls, cuboids, capsules, cylinders, cones, convex polyhedra \
         and triangle meshes can"
    )]
    Unsupported {
        /// Kind of the shape.
        kind: ShapeType,
    },
    /// The number of segments is out of range.
    #[error("a circle must have {lowest} to {highest} segments, not {found}")]
    Segments {
        /// Number of segments.
        found: u32,
        /// Smallest valid number.
        lowest: u32,
        /// Largest valid number.
        highest: u32,
    },
    /// The triangles are not a closed surface with outward orientation.
    #[error("the triangles of the shape are not a usable surface: {0}")]
    Surface(#[from] SurfaceError),
    /// The surface cannot be filled with tetrahedra from its centroid.
    #[error("the surface of the shape cannot be filled with tetrahedra: {0}")]
    Field(#[from] MeshError),
}

/// Surface (m) of a shape of parry, for a rigid body. The shape is a ball, cuboid, capsule, cylinder, cone, convex polyhedron, or a
/// closed triangle mesh with outward orientation.
///
/// Balls, capsules, cylinders and cones are approximated by inscribed polyhedra, with `segments` (4 to 4096) per circle and about half
/// as many from pole to pole. The other shapes ignore `segments`, but it must still be in range. The triangles are repaired as by
/// [`TriangleSoup::closed`].
///
/// ```
/// use hydroelastic::io::surface_from_shape;
/// use parry3d_f64::{math::Vec3, shape::Cuboid};
///
/// let table = surface_from_shape(&Cuboid::new(Vec3::new(0.5, 0.4, 0.02)), 4)?;
/// assert_eq!(table.triangles().len(), 12);
/// # Ok::<(), hydroelastic::io::ShapeError>(())
/// ```
///
/// # Errors
/// - If the shape is of another kind.
/// - If the number of segments is out of range.
/// - If [`TriangleSoup::closed`] returns an error.
pub fn surface_from_shape(shape: &dyn Shape, segments: u32) -> Result<TriangleSurface, ShapeError> {
    if !SEGMENT_RANGE.contains(&segments) {
        return Err(ShapeError::Segments {
            found: segments,
            lowest: *SEGMENT_RANGE.start(),
            highest: *SEGMENT_RANGE.end(),
        });
    }
    // The number is even, because each cap of a capsule has half of the segments.
    let from_pole_to_pole = segments.div_ceil(4) * 2;
    let (vertices, triangles) = match shape.as_typed_shape() {
        TypedShape::Ball(ball) => ball.to_trimesh(segments, from_pole_to_pole),
        TypedShape::Cuboid(cuboid) => cuboid.to_trimesh(),
        TypedShape::Capsule(capsule) => capsule.to_trimesh(segments, from_pole_to_pole),
        TypedShape::Cylinder(cylinder) => cylinder.to_trimesh(segments),
        TypedShape::Cone(cone) => cone.to_trimesh(segments),
        TypedShape::ConvexPolyhedron(polyhedron) => polyhedron.to_trimesh(),
        TypedShape::TriMesh(mesh) => (mesh.vertices().to_vec(), mesh.indices().to_vec()),
        _ => {
            let kind = shape.shape_type();
            return Err(ShapeError::Unsupported { kind });
        }
    };
    Ok(soup(&vertices, &triangles).closed()?)
}

/// Triangles of parry.
pub(super) fn soup(vertices: &[Vec3], triangles: &[[u32; 3]]) -> TriangleSoup {
    let vertices = vertices.iter().map(|v| Vector3::new(v.x, v.y, v.z));
    let triangles = triangles.iter().map(|t| t.map(|vertex| vertex as usize));
    TriangleSoup {
        vertices: vertices.collect(),
        triangles: triangles.collect(),
    }
}
