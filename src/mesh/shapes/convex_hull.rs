use super::star_shaped;
use crate::mesh::{MeshError, PressureField, TriangleSoup};
use nalgebra::Vector3;

/// Creates a field in the convex hull of points (m), by [`star_shaped()`]. The extent is 1 at the centroid.
///
/// ```
/// use hydroelastic::mesh::shapes;
/// use nalgebra::Vector3;
///
/// let corner = |k: u32| Vector3::new(k & 1, k >> 1 & 1, k >> 2).map(f64::from);
/// let points: Vec<_> = (0..8).map(corner).collect();
/// assert!((shapes::convex_hull(&points)?.mesh().volume() - 1.0).abs() < 1e-14);
/// # Ok::<(), hydroelastic::mesh::MeshError>(())
/// ```
///
/// # Errors
/// Returns the errors of [`TriangleSoup::convex_hull`], [`TriangleSoup::closed`] and [`star_shaped()`].
pub fn convex_hull(points: &[Vector3<f64>]) -> Result<PressureField, MeshError> {
    let points = TriangleSoup {
        vertices: points.to_vec(),
        triangles: Vec::new(),
    };
    star_shaped(&points.convex_hull()?.closed()?)
}
