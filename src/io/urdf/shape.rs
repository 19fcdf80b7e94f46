//! Shapes of bodies from collision geometries.

use super::collision::{Collision, Geometry};
use super::{UrdfError, UrdfWarning};
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
    /// Rigid shape of the surface. A surface that is turned inwards is flipped, or else its components that are turned inwards. If
    /// [`TriangleSoup::closed`] still returns an error, the shape consists of the convex hulls of the connected components. If a component
    /// is flat, the shape is the convex hull of all triangles. Each of these changes is reported.
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
    /// Shape of the geometry, in the frame of the link. Boxes, spheres, cylinders and capsules become compliant shapes. Also returns
    /// changes and properties of the surface of a mesh that may be mistakes.
    ///
    /// The up axis that a COLLADA or glTF file states is ignored, as by other readers of URDF.
    ///
    /// # Errors
    /// - If [`read_triangles`](crate::io::read_triangles) cannot read the file of a mesh.
    /// - If `options.meshes` needs a closed surface or a convex hull that the mesh does not have.
    /// - If a compliant shape cannot be made of the geometry.
    pub fn shape(
        &self,
        options: &ShapeOptions,
    ) -> Result<(BodyShape, Vec<UrdfWarning>), UrdfError> {
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
                return Ok((BodyShape::None, Vec::new()));
            }
            Geometry::Mesh { scale, .. } => {
                let path = self.mesh_path(&options.packages)?.unwrap_or_default();
                let soup = self.soup(&path, *scale)?;
                return self.mesh_shape(soup, options.meshes);
            }
        };
        Ok((self.compliant(field)?, Vec::new()))
    }

    /// Shape of a mesh in the link frame, and changes and properties of its surface that may be mistakes.
    fn mesh_shape(
        &self,
        soup: TriangleSoup,
        kind: MeshShape,
    ) -> Result<(BodyShape, Vec<UrdfWarning>), UrdfError> {
        let surface = match kind {
            MeshShape::Rigid => self.closed_or_hull(&soup),
            MeshShape::Hull | MeshShape::CompliantHull => hull(&soup).map(|hull| (hull, None)),
            MeshShape::StarShaped | MeshShape::None => soup.closed().map(|surface| (surface, None)),
        };
        let (surface, change) = surface.map_err(|source| UrdfError::Surface {
            at: self.at.clone(),
            source,
        })?;
        let properties = surface.warnings().into_iter();
        let properties = properties.map(|warning| UrdfWarning::Surface {
            at: self.at.clone(),
            warning,
        });
        let warnings = change.into_iter().chain(properties).collect();
        if matches!(kind, MeshShape::Rigid | MeshShape::Hull) {
            return Ok((RigidShape::new(surface).into(), warnings));
        }
        let field = shapes::star_shaped(&surface).map_err(|source| self.field_error(source))?;
        Ok((Shape::new(field).into(), warnings))
    }

    /// Closed surface of the triangles, with components reversed that are turned inwards. If the surface is still not closed, returns the
    /// convex hulls of the components, or the convex hull of all triangles. Also returns a report of the change.
    fn closed_or_hull(
        &self,
        soup: &TriangleSoup,
    ) -> Result<(TriangleSurface, Option<UrdfWarning>), SurfaceError> {
        let error = match soup.clone().closed() {
            Ok(surface) => return Ok((surface, None)),
            Err(error) => error,
        };
        let at = self.at.clone();
        if let SurfaceError::Inward { .. } | SurfaceError::SticksOut { .. } = error
            && let Some((surface, component_count)) = outwards(soup)
        {
            let change = UrdfWarning::Reversed {
                at,
                component_count,
            };
            return Ok((surface, Some(change)));
        }
        let Ok(surface) = component_hulls(soup).or_else(|_| hull(soup)) else {
            return Err(error);
        };
        let change = UrdfWarning::Hull {
            at,
            hull_count: surface.component_count(),
            source: error,
        };
        Ok((surface, Some(change)))
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

/// Surface with all components reversed, or else with those reversed that are turned inwards, and the number of reversed components.
fn outwards(soup: &TriangleSoup) -> Option<(TriangleSurface, usize)> {
    if let Ok(surface) = soup.clone().flipped().closed() {
        let component_count = surface.component_count();
        return Some((surface, component_count));
    }
    let (soup, component_count) = soup.with_outward_components().ok()?;
    Some((soup.closed().ok()?, component_count))
}

fn component_hulls(soup: &TriangleSoup) -> Result<TriangleSurface, SurfaceError> {
    let mut hulls = TriangleSoup::default();
    for hull in soup.component_hulls()? {
        let first = hulls.vertices.len();
        let triangles = hull.triangles.iter();
        hulls
            .triangles
            .extend(triangles.map(|triangle| triangle.map(|vertex| first + vertex)));
        hulls.vertices.extend(hull.vertices);
    }
    hulls.closed()
}

fn hull(soup: &TriangleSoup) -> Result<TriangleSurface, SurfaceError> {
    soup.convex_hull()?.closed()
}
