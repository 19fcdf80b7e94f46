//! Shapes of bodies from collision geometries.

use super::UrdfError;
use super::collision::{Collision, Geometry};
use crate::contact::{RigidShape, Shape};
use crate::dynamics::BodyShape;
use crate::io::read_triangle_surface;
use crate::mesh::{MeshError, PressureField, SurfaceError, TetMesh, TriangleSurface, shapes};
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
    /// Rigid shape.
    Rigid,
    /// Compliant shape by [`shapes::star_shaped`]. The mesh must be star-shaped about its center.
    StarShaped,
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
    /// # Errors
    /// - If the file of a mesh cannot be found, or is neither STL nor OBJ.
    /// - If a mesh is not a closed surface.
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
                let surface = self.surface(&path, *scale)?;
                match options.meshes {
                    MeshShape::Rigid => return self.rigid(&surface),
                    MeshShape::StarShaped | MeshShape::None => shapes::star_shaped(&surface),
                }
            }
        };
        self.compliant(field)
    }

    fn rigid(&self, surface: &TriangleSurface) -> Result<BodyShape, UrdfError> {
        let vertices = self.in_link_frame(surface.vertices());
        let surface = TriangleSurface::new(vertices, surface.triangles().to_vec());
        let surface = surface.map_err(|source| UrdfError::Surface {
            at: self.at.clone(),
            source,
        })?;
        Ok(RigidShape::new(surface).into())
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
        let field = in_link_frame.map_err(|source| UrdfError::Field {
            at: self.at.clone(),
            source,
        })?;
        Ok(Shape::new(field).into())
    }

    fn surface(&self, path: &Path, scale: [f64; 3]) -> Result<TriangleSurface, UrdfError> {
        let surface = read_triangle_surface(path, 1.0).map_err(|source| UrdfError::MeshFile {
            at: self.at.clone(),
            source: Box::new(source),
        })?;
        scaled(&surface, scale).map_err(|source| UrdfError::Surface {
            at: self.at.clone(),
            source,
        })
    }
}

/// The surface with its coordinates multiplied by these factors. A mirrored triangle has its corners in reverse order, so that its outer
/// side stays outside.
fn scaled(surface: &TriangleSurface, scale: [f64; 3]) -> Result<TriangleSurface, SurfaceError> {
    let factors = Vector3::from(scale);
    let vertices = surface.vertices().iter();
    let vertices = vertices.map(|vertex| vertex.component_mul(&factors));
    let is_mirrored = scale.iter().filter(|factor| **factor < 0.0).count() % 2 == 1;
    let triangles = surface.triangles().iter().map(
        |&[a, b, c]| {
            if is_mirrored { [a, c, b] } else { [a, b, c] }
        },
    );
    TriangleSurface::new(vertices.collect(), triangles.collect())
}
