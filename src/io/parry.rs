use crate::geometry::Aabb;
use crate::io::ShapeError;
use crate::mesh::{PressureField, TetMesh, TriangleSurface, shapes};
use crate::spatial::Pose;
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use parry3d_f64::math::{Pose3, Rot3, Vec3};
use parry3d_f64::shape::{ConvexPolyhedron, TriMesh};
use parry3d_f64::transformation::{ConvexHullError, try_convex_hull};

/// How far outside its hull a point may lie, as a fraction of the extent of all points: far above the
/// rounding of the normal of a thin triangle.
const CONTAINED: f64 = 1e-6;

/// Why points have no convex hull that can be a body.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum HullError {
    /// A coordinate is NaN or infinite.
    #[error("point {point} has the coordinate {value}, but coordinates must be finite")]
    NonFiniteCoordinate {
        /// Index of the point.
        point: usize,
        /// The coordinate.
        value: f64,
    },
    /// parry finds no hull: there are too few points, or they lie in a line or a plane.
    #[error("no convex hull was found of {point_count} points")]
    NoHull {
        /// How many points there are.
        point_count: usize,
        /// What parry says.
        source: ConvexHullError,
    },
    /// parry's hull is no usable solid: the points lie in a plane or almost so, or make triangles without
    /// area.
    #[error("the convex hull of {point_count} points is not usable")]
    Shape {
        /// How many points there are.
        point_count: usize,
        /// Why not.
        source: ShapeError,
    },
    /// parry's hull leaves a point out.
    #[error("the convex hull that was found leaves point {point} outside, by {distance:.3e} m")]
    Outside {
        /// Index of the point.
        point: usize,
        /// How far (m) it lies outside the plane of a triangle.
        distance: f64,
    },
}

/// The field of a convex polyhedron of parry (m), by [`shapes::star_shaped`].
///
/// # Errors
/// If a coordinate is not finite, or the polyhedron is so slender that tetrahedra are flat to round-off.
pub fn field_from_polyhedron(polyhedron: &ConvexPolyhedron) -> Result<PressureField, ShapeError> {
    let (vertices, triangles) = polyhedron.to_trimesh();
    star_shaped(&vertices, &triangles)
}

/// The field of the solid inside a triangle mesh of parry (m), by [`TriangleSurface::welded`] and [`shapes::star_shaped`].
///
/// # Errors
/// If [`TriangleSurface::welded`] or [`shapes::star_shaped`] fails.
pub fn field_from_trimesh(mesh: &TriMesh) -> Result<PressureField, ShapeError> {
    star_shaped(mesh.vertices(), mesh.indices())
}

/// The field of the convex hull of points (m), which parry computes, by [`shapes::star_shaped`].
///
/// That the hull contains all points, to a millionth of their extent, is checked: each point against each
/// triangle, which takes a time as their numbers multiplied.
///
/// # Errors
/// If a coordinate is not finite, the points span no volume, or parry's hull is not right. Rows of points
/// that lie in one line or plane only up to round-off can make it so.
pub fn field_from_hull(points: &[Vector3<f64>]) -> Result<PressureField, HullError> {
    for (point, position) in points.iter().enumerate() {
        if let Some(&value) = position.iter().find(|value| !value.is_finite()) {
            return Err(HullError::NonFiniteCoordinate { point, value });
        }
    }
    let point_count = points.len();
    let parry_points: Vec<Vec3> = points.iter().map(|p| Vec3::new(p.x, p.y, p.z)).collect();
    let hull = try_convex_hull(&parry_points);
    let (vertices, triangles) = hull.map_err(|source| HullError::NoHull {
        point_count,
        source,
    })?;
    let field = star_shaped(&vertices, &triangles).map_err(|source| HullError::Shape {
        point_count,
        source,
    })?;
    check_contains(field.mesh(), points)?;
    Ok(field)
}

/// Checks that no point lies outside the plane of a surface triangle.
fn check_contains(mesh: &TetMesh, points: &[Vector3<f64>]) -> Result<(), HullError> {
    let aabb = Aabb::around(points);
    let allowed = CONTAINED * (aabb.upper - aabb.lower).norm();
    for triangle in mesh.surface_triangles() {
        let [a, b, c] = triangle.map(|vertex| mesh.vertices()[vertex]);
        let normal = (b - a).cross(&(c - a)).normalize();
        for (point, position) in points.iter().enumerate() {
            let distance = (position - a).dot(&normal);
            if distance > allowed {
                return Err(HullError::Outside { point, distance });
            }
        }
    }
    Ok(())
}

fn star_shaped(vertices: &[Vec3], triangles: &[[u32; 3]]) -> Result<PressureField, ShapeError> {
    let vertices = vertices.iter().map(|v| Vector3::new(v.x, v.y, v.z));
    let triangles = triangles.iter().map(|t| t.map(|vertex| vertex as usize));
    let surface = TriangleSurface::welded(vertices.collect(), triangles.collect())?;
    Ok(shapes::star_shaped(&surface)?)
}

/// The same pose with its rotation as a matrix. Its numbers are taken as they are, and checked where a
/// body is made of it, as those of an [`Isometry3`] are.
impl From<Pose3> for Pose {
    fn from(pose: Pose3) -> Self {
        let Rot3 { x, y, z, w } = pose.rotation;
        let orientation = UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z));
        let origin = pose.translation;
        let translation = Translation3::new(origin.x, origin.y, origin.z);
        Self::from(Isometry3::from_parts(translation, orientation))
    }
}

/// The same pose with its rotation as a quaternion of length 1; of the two that stand for a rotation it
/// may be either.
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
