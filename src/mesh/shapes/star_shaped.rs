use super::cored::CoredSurface;
use crate::geometry::Tetrahedron;
use crate::mesh::tet_mesh::is_flat;
use crate::mesh::triangle_solid::solid_angle;
use crate::mesh::{MeshError, PressureField, TriangleSurface};
use nalgebra::Vector3;
use std::f64::consts::PI;

/// Creates a field in the solid inside a closed surface, if every triangle is visible from the centroid of the volume.
/// Any convex solid qualifies. The extent is 1 at the centroid.
///
/// The mesh has one tetrahedron for each triangle, between the triangle and the center. The vertices of the surface
/// come first, in order, and the center last. [`TriangleSoup::closed`](crate::mesh::TriangleSoup::closed) makes a surface from triangles
/// that do not share vertices.
///
/// The center moves with the surface. [`TetMesh::mass_gradient`](crate::mesh::TetMesh::mass_gradient) converts derivatives with
/// respect to the center into derivatives with respect to the vertices, as for a center of mass.
///
/// If all faces are at the same distance from the center, as in a cube, the field is proportional to the distance to the surface.
/// Otherwise it rises more slowly from far faces than from near ones.
///
/// ```
/// use hydroelastic::mesh::{TriangleSurface, shapes};
/// use nalgebra::vector;
///
/// // A corner cut off a cube.
/// let vertices = vec![
///     vector![0.0, 0.0, 0.0], vector![0.1, 0.0, 0.0], vector![0.0, 0.1, 0.0], vector![0.0, 0.0, 0.1],
/// ];
/// let triangles = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
/// let corner = shapes::star_shaped(&TriangleSurface::new(vertices, triangles)?)?;
/// assert_eq!(corner.mesh().tet_count(), 4);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// Returns an error if a triangle is not visible from the center, or if the tetrahedron between a triangle and the
/// center is flat to within rounding error. Also returns an error if the surface winds around the center more than
/// once.
pub fn star_shaped(surface: &TriangleSurface) -> Result<PressureField, MeshError> {
    star_shaped_about(surface.center(), surface)
}

/// Fills the surface as [`star_shaped`] does, from a given inner point (m) instead of the center.
///
/// # Errors
/// Returns the errors of [`star_shaped`]. Also returns an error if the point is not finite.
pub fn star_shaped_about(
    inner_point: Vector3<f64>,
    surface: &TriangleSurface,
) -> Result<PressureField, MeshError> {
    if let Some(&value) = inner_point.iter().find(|value| !value.is_finite()) {
        return Err(MeshError::NonFiniteInnerPoint { value });
    }
    check_seen_from_inside(surface, &inner_point)?;
    check_layers(surface, &inner_point)?;
    CoredSurface {
        vertices: surface.vertices().to_vec(),
        triangles: surface.triangles().to_vec(),
        core_points: vec![inner_point; surface.vertices().len()],
        is_about_to_open: false,
    }
    .field()
}

/// Checks that every triangle faces the point with its inner side.
fn check_seen_from_inside(
    surface: &TriangleSurface,
    point: &Vector3<f64>,
) -> Result<(), MeshError> {
    let mut edge_on = None;
    for triangle in 0..surface.triangles().len() {
        let [a, b, c] = surface.corners(triangle);
        let corners = [*point, a, b, c];
        let tetrahedron = Tetrahedron { corners };
        if is_flat(&tetrahedron) {
            let volume = tetrahedron.signed_volume().abs();
            edge_on.get_or_insert(MeshError::TriangleSeenEdgeOn { triangle, volume });
            continue;
        }
        let distance = (point - a).dot(&(b - a).cross(&(c - a)).normalize());
        if distance > 0.0 {
            return Err(MeshError::HiddenTriangle { triangle, distance });
        }
    }
    edge_on.map_or(Ok(()), Err)
}

/// Checks that the surface winds around the point only once.
///
/// If the inner sides of all triangles of a closed surface face the point, every direction meets equally many
/// triangles. The sum of the solid angles over 4π is therefore the number of layers.
fn check_layers(surface: &TriangleSurface, point: &Vector3<f64>) -> Result<(), MeshError> {
    let corners = (0..surface.triangles().len()).map(|triangle| surface.corners(triangle));
    let solid_angles = corners.map(|corners| solid_angle(corners.map(|corner| corner - point)));
    let layers = (solid_angles.sum::<f64>() / (4.0 * PI)).round();
    if layers > 1.0 {
        return Err(MeshError::RepeatedSurface { layers });
    }
    Ok(())
}
