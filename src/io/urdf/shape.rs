//! Shapes of bodies from collision geometries.

use super::UrdfError;
use super::collision::{Collision, Geometry};
use crate::contact::{RigidShape, Shape};
use crate::dynamics::BodyShape;
use crate::io::Placement;
use crate::io::files::read_in_file_axes;
use crate::mesh::{
    MeshError, PressureField, SurfaceError, TetMesh, TriangleSoup, TriangleSurface, shapes,
};
use nalgebra::Vector3;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Options of [`Collision::shape`].
#[derive(Debug, Clone, PartialEq)]
pub struct ShapeOptions {
    /// Folders of packages, by name. Empty by default.
    pub packages: BTreeMap<String, PathBuf>,
    /// Subdivisions k of a sphere, which has 20·4ᵏ triangles. The default is 2.
    pub subdivisions: usize,
    /// Number of sides of a cylinder or a capsule. The default is 16.
    pub segments: usize,
    /// Shapes of meshes. The default is rigid.
    pub meshes: MeshShape,
}

/// Kind of the shape that is made of a mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum MeshShape {
    /// Rigid shape of the surface. A surface that is turned inwards is flipped. If [`TriangleSoup::closed`] still returns an error, the
    /// shape is the convex hull.
    Rigid,
    /// Rigid shape of the convex hull.
    Hull,
    /// Compliant shape by [`shapes::star_shaped`]. The mesh must be star-shaped about the center of its volume.
    StarShaped,
    /// Compliant shape of the convex hull, by [`shapes::convex_hull`].
    CompliantHull,
    /// No shape. The mesh file is not read.
    None,
}

impl Default for ShapeOptions {
    fn default() -> Self {
        Self {
            packages: BTreeMap::new(),
            subdivisions: 2,
            segments: 16,
            meshes: MeshShape::Rigid,
        }
    }
}

impl Collision {
    /// Shape of the geometry, in the frame of the link. Boxes, spheres, cylinders and capsules become compliant shapes.
    ///
    /// The up axis that a COLLADA or glTF file states is ignored, as by other readers of URDF.
    ///
    /// # Errors
    /// - If [`read_triangles`](crate::io::read_triangles) cannot read the file of a mesh.
    /// - If `options.meshes` needs a closed surface or a convex hull that the mesh does not have.
    /// - If a compliant shape cannot be made of the geometry.
    pub fn shape(&self, options: &ShapeOptions) -> Result<BodyShape, UrdfError> {
        let field = match &self.geometry {
            Geometry::Box { lengths } => shapes::cuboid(*lengths),
            Geometry::Sphere { radius } => shapes::icosphere(*radius, options.subdivisions),
            Geometry::Cylinder { radius, length } => {
                shapes::cylinder(*radius, *length, options.segments)
            }
            Geometry::Capsule { radius, length } => {
                shapes::capsule(*radius, *length, options.segments)
            }
            Geometry::Mesh { .. } if options.meshes == MeshShape::None => {
                return Ok(BodyShape::None);
            }
            Geometry::Mesh { scale, .. } => {
                let path = self.mesh_path(&options.packages)?.unwrap_or_default();
                let soup = self.soup(&path, *scale)?;
                return self.mesh_shape(soup, options.meshes);
            }
        };
        self.compliant(field)
    }

    /// Shape of a mesh in the link frame.
    fn mesh_shape(&self, soup: TriangleSoup, kind: MeshShape) -> Result<BodyShape, UrdfError> {
        let surface = match kind {
            MeshShape::Rigid => closed_or_hull(&soup),
            MeshShape::Hull | MeshShape::CompliantHull => hull(&soup),
            MeshShape::StarShaped | MeshShape::None => soup.closed(),
        };
        let surface = surface.map_err(|source| UrdfError::Surface {
            at: self.at.clone(),
            source,
        })?;
        if matches!(kind, MeshShape::Rigid | MeshShape::Hull) {
            return Ok(RigidShape::new(surface).into());
        }
        let field = shapes::star_shaped(&surface).map_err(|source| self.field_error(source))?;
        Ok(Shape::new(field).into())
    }

    fn field_error(&self, source: MeshError) -> UrdfError {
        UrdfError::Field {
            at: self.at.clone(),
            source,
        }
    }

    fn in_link_frame(&self, points: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
        let points = points.iter();
        points
            .map(|point| self.origin.transformed_point(point))
            .collect()
    }

    fn compliant(&self, field: Result<PressureField, MeshError>) -> Result<BodyShape, UrdfError> {
        let in_link_frame = field.and_then(|field| {
            let (mesh, extents) = (field.mesh(), field.extents().to_vec());
            let mesh = TetMesh::new(self.in_link_frame(mesh.vertices()), mesh.tets().to_vec())?;
            PressureField::new(mesh, extents)
        });
        let field = in_link_frame.map_err(|source| self.field_error(source))?;
        Ok(Shape::new(field).into())
    }

    /// Triangles of a file, in the link frame.
    fn soup(&self, path: &Path, scale: [f64; 3]) -> Result<TriangleSoup, UrdfError> {
        let (soup, _) = read_in_file_axes(path).map_err(|source| UrdfError::MeshFile {
            at: self.at.clone(),
            source: Box::new(source),
        })?;
        let placement = Placement {
            scale: scale.into(),
            pose: self.origin,
            ..Placement::default()
        };
        Ok(placement.placed(soup))
    }
}

/// Closed surface of the triangles, flipped if it is turned inwards. If they are not closed, the surface of their convex hull.
fn closed_or_hull(soup: &TriangleSoup) -> Result<TriangleSurface, SurfaceError> {
    soup.clone().closed().or_else(|error| {
        let reversed = match error {
            SurfaceError::Inward { .. } => soup.clone().flipped().closed(),
            _ => Err(error.clone()),
        };
        reversed.or_else(|_| hull(soup)).map_err(|_| error)
    })
}

fn hull(soup: &TriangleSoup) -> Result<TriangleSurface, SurfaceError> {
    soup.convex_hull()?.closed()
}
