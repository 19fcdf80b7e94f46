use crate::geometry::Aabb;
use crate::io::ShapeError;
use crate::mesh::{PressureField, TetMesh, TriangleSurface, shapes};
use crate::spatial::Pose;
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use parry3d_f64::math::{Pose3, Rot3, Vec3};
use parry3d_f64::shape::{ConvexPolyhedron, TriMesh};
use parry3d_f64::transformation::{ConvexHullError, try_convex_hull};

/// Allowed distance of a point from its hull, relative to the diagonal of the bounding box of all points. It is far above the rounding
/// error of the normal of a thin triangle.
const CONTAINMENT_TOLERANCE: f64 = 1e-6;

/// Reason why the convex hull of points cannot be a body.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum HullError {
    /// A coordinate is NaN or infinite.
    #[error("point {point} has the coordinate {value}, but coordinates must be finite")]
    NonFiniteCoordinate {
        /// Index of the point.
        point: usize,
        /// Value of the coordinate.
        value: f64,
    },
    /// parry found no hull. There are too few points, or they lie in a line or a plane.
    #[error("no convex hull was found of {point_count} points")]
    NoHull {
        /// Number of points.
        point_count: usize,
        /// Error of parry.
        source: ConvexHullError,
    },
    /// The hull is not a usable solid. The points are nearly coplanar, or the hull has degenerate triangles.
    #[error("the convex hull of {point_count} points is not usable")]
    Shape {
        /// Number of points.
        point_count: usize,
        /// Cause.
        source: ShapeError,
    },
    /// The hull does not contain all points.
    #[error("point {point} is {distance:.3e} m outside the convex hull that was found")]
    Outside {
        /// Index of the point.
        point: usize,
        /// Distance (m) of the point from the plane of a triangle.
        distance: f64,
    },
}

/// Pressure field of a convex polyhedron of parry (m), from [`shapes::star_shaped`].
///
/// # Errors
/// - If a coordinate is not finite.
/// - If the polyhedron is so thin that tetrahedra are flat to round-off.
pub fn field_from_polyhedron(polyhedron: &ConvexPolyhedron) -> Result<PressureField, ShapeError> {
    let (vertices, triangles) = polyhedron.to_trimesh();
    star_shaped(&vertices, &triangles)
}

/// Pressure field of the solid inside a triangle mesh of parry (m), from [`TriangleSurface::welded`] and [`shapes::star_shaped`].
///
/// # Errors
/// If [`TriangleSurface::welded`] or [`shapes::star_shaped`] fails.
pub fn field_from_trimesh(mesh: &TriMesh) -> Result<PressureField, ShapeError> {
    star_shaped(mesh.vertices(), mesh.indices())
}

/// Pressure field of the convex hull of points (m), from [`shapes::star_shaped`]. parry computes the hull.
///
/// The function checks that the hull contains all points, to a millionth of the diagonal of their bounding box. The cost of this check
/// is the number of points times the number of triangles.
///
/// # Errors
/// - If a coordinate is not finite.
/// - If the points span no volume.
/// - If the hull of parry is wrong, which can happen if several points are collinear or coplanar only up to round-off.
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
    let allowed = CONTAINMENT_TOLERANCE * (aabb.upper - aabb.lower).norm();
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
