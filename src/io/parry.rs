use super::parry_surface::soup;
use crate::io::ShapeError;
use crate::mesh::{PressureField, shapes};
use crate::spatial::Pose;
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use parry3d_f64::math::{Pose3, Rot3, Vec3};
use parry3d_f64::shape::{ConvexPolyhedron, TriMesh};

/// Pressure field of a convex polyhedron of parry (m), from [`shapes::star_shaped`].
///
/// # Errors
/// - If a coordinate is not finite.
/// - If the polyhedron is so thin that tetrahedra are flat to round-off.
pub fn field_from_polyhedron(polyhedron: &ConvexPolyhedron) -> Result<PressureField, ShapeError> {
    let (vertices, triangles) = polyhedron.to_trimesh();
    star_shaped(&vertices, &triangles)
}

/// Pressure field of the solid inside a triangle mesh of parry (m), from
/// [`TriangleSoup::closed`](crate::mesh::TriangleSoup::closed) and [`shapes::star_shaped`].
///
/// # Errors
/// If `TriangleSoup::closed` or [`shapes::star_shaped`] returns an error.
pub fn field_from_trimesh(mesh: &TriMesh) -> Result<PressureField, ShapeError> {
    star_shaped(mesh.vertices(), mesh.indices())
}

fn star_shaped(vertices: &[Vec3], triangles: &[[u32; 3]]) -> Result<PressureField, ShapeError> {
    let surface = soup(vertices, triangles).closed()?;
    Ok(shapes::star_shaped(&surface)?)
}

/// Converts the rotation to a matrix. The numbers are not validated here, but by the constructors of bodies, as for an [`Isometry3`].
impl From<Pose3> for Pose {
    fn from(pose: Pose3) -> Self {
        let Rot3 { x, y, z, w } = pose.rotation;
        let orientation = UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z));
        let origin = pose.translation;
        let translation = Translation3::new(origin.x, origin.y, origin.z);
        Self::from(Isometry3::from_parts(translation, orientation))
    }
}

/// Converts the rotation to a unit quaternion with arbitrary sign.
impl From<Pose> for Pose3 {
    fn from(pose: Pose) -> Self {
        let isometry = Isometry3::from(pose);
        let [x, y, z, w] = isometry.rotation.coords.into();
        let origin = isometry.translation;
        Self::from_parts(
            Vec3::new(origin.x, origin.y, origin.z),
            Rot3::from_xyzw(x, y, z, w),
        )
    }
}
