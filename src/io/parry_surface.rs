use crate::mesh::{MeshError, SurfaceError, TriangleSurface};
use nalgebra::Vector3;
use parry3d_f64::math::Vec3;
use parry3d_f64::shape::{Shape, ShapeType, TypedShape};

/// How many segments a circle can have: with fewer there is no solid, and with many more a sphere has more triangles than a
/// `u32` counts.
const SEGMENTS: std::ops::RangeInclusive<u32> = 4..=4096;

/// Why a shape of parry does not become a surface or a field.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ShapeError {
    /// There are no triangles around a shape of this kind.
    #[error(
        "a shape of the kind {kind:?} cannot become a surface: balls, cuboids, capsules, cylinders, cones, convex polyhedra \
         and triangle meshes can"
    )]
    Unsupported {
        /// What it is.
        kind: ShapeType,
    },
    /// An unusable number of segments.
    #[error("a circle takes {lowest} to {highest} segments, not {found}")]
    Segments {
        /// The number.
        found: u32,
        /// Smallest usable number.
        lowest: u32,
        /// Largest usable number.
        highest: u32,
    },
    /// The triangles are no closed surface turned outwards.
    #[error("the triangles of the shape are no usable surface: {0}")]
    Surface(#[from] SurfaceError),
    /// The surface cannot be filled from the center of its volume.
    #[error("the surface of the shape cannot be filled with tetrahedra: {0}")]
    Field(#[from] MeshError),
}

/// The surface of a shape of parry (m), for a rigid body: a ball, cuboid, capsule, cylinder, cone, convex polyhedron, or a
/// triangle mesh that is closed and turned outwards.
///
/// Balls, capsules, cylinders and cones become polyhedra inside of them, with `segments` (4 to 4096) to a circle and about
/// half as many from pole to pole. For the other shapes the number means nothing, and any from 4 to 4096 will do. Vertices at
/// exactly the same place become one.
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
/// If the shape is of another kind, the number of segments unusable, or [`TriangleSurface::from_soup`] refuses the triangles.
pub fn surface_from_shape(shape: &dyn Shape, segments: u32) -> Result<TriangleSurface, ShapeError> {
    if !SEGMENTS.contains(&segments) {
        return Err(ShapeError::Segments {
            found: segments,
            lowest: *SEGMENTS.start(),
            highest: *SEGMENTS.end(),
        });
    }
    // An even number, for a capsule has half of them in each cap.
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
    let position = |vertex: u32| {
        let Vec3 { x, y, z } = vertices[vertex as usize];
        Vector3::new(x, y, z)
    };
    let soup: Vec<_> = triangles.iter().map(|t| t.map(position)).collect();
    Ok(TriangleSurface::from_soup(&soup)?)
}
