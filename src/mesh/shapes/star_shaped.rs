use super::closed_surface::ClosedSurface;
use super::cored::CoredSurface;
use crate::geometry::Tetrahedron;
use crate::mesh::tet_mesh::is_flat;
use crate::mesh::{MeshError, PressureField};
use crate::scalar::portable::atan2;
use nalgebra::Vector3;
use std::f64::consts::PI;

/// The solid inside a closed surface of triangles, all of which can be seen from the center of its
/// volume; convex solids are such. Its field has extent 1 at that center.
///
/// As [`star_shaped_about`] does, this takes vertices (m) and triangles counter-clockwise seen from
/// outside. It makes a tetrahedron of each triangle and the center. Vertices at exactly the same place
/// become one, so that triangles may come each with corners of its own, and vertices that no triangle
/// uses are left out, whatever their numbers.
///
/// The surface's vertices come first in the mesh, without those left out, and the center last. It moves with them: derivatives by
/// it are passed on by [`TetMesh::mass_gradient`](crate::mesh::TetMesh::mass_gradient), as those by a center of mass.
///
/// In the solid whose faces are all at the same distance from the center, such as a cube, the field is
/// proportional to the distance to the surface; in others it rises more slowly from the far faces than from the near ones.
///
/// ```
/// use hydroelastic::mesh::shapes;
/// use nalgebra::vector;
///
/// // The corner of a cube, cut off.
/// let vertices = vec![
///     vector![0.0, 0.0, 0.0], vector![0.1, 0.0, 0.0], vector![0.0, 0.1, 0.0], vector![0.0, 0.0, 0.1],
/// ];
/// let triangles = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
/// let corner = shapes::star_shaped(vertices, triangles)?;
/// assert_eq!(corner.mesh().tet_count(), 4);
/// # Ok::<(), hydroelastic::mesh::MeshError>(())
/// ```
///
/// # Errors
/// If a coordinate is not finite, an index out of range or repeated; if the surface is open, or its
/// triangles are turned different ways or inwards; if a triangle cannot be seen from the center, or is so
/// flat or so nearly in a plane with the center that the tetrahedron between them is flat to round-off; or if
/// the solid is so large that its volume is beyond double precision.
pub fn star_shaped(
    vertices: Vec<Vector3<f64>>,
    triangles: Vec<[usize; 3]>,
) -> Result<PressureField, MeshError> {
    let surface = ClosedSurface::new(vertices, triangles)?;
    let center = surface.center;
    filled(surface, center)
}

/// As [`star_shaped`], seen from a point (m) of one's choice, which has extent 1.
///
/// # Errors
/// As [`star_shaped`], or if the point is not finite.
pub fn star_shaped_about(
    inner_point: Vector3<f64>,
    vertices: Vec<Vector3<f64>>,
    triangles: Vec<[usize; 3]>,
) -> Result<PressureField, MeshError> {
    if let Some(&value) = inner_point.iter().find(|value| !value.is_finite()) {
        return Err(MeshError::NonFiniteInnerPoint { value });
    }
    filled(ClosedSurface::new(vertices, triangles)?, inner_point)
}

/// The surface filled to a point, if that sees every triangle once.
fn filled(surface: ClosedSurface, inner_point: Vector3<f64>) -> Result<PressureField, MeshError> {
    check_seen_from_inside(&surface, &inner_point)?;
    check_layers(&surface, &inner_point)?;
    let ClosedSurface {
        vertices,
        triangles,
        ..
    } = surface;
    CoredSurface {
        core_points: vec![inner_point; vertices.len()],
        vertices,
        triangles,
        is_about_to_open: false,
    }
    .field()
}

/// Checks that the point sees each triangle from inside.
fn check_seen_from_inside(surface: &ClosedSurface, point: &Vector3<f64>) -> Result<(), MeshError> {
    let mut edge_on = None;
    for (triangle, vertices) in surface.triangles.iter().enumerate() {
        let [a, b, c] = vertices.map(|vertex| surface.vertices[vertex]);
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

/// Checks that the point sees one triangle in every direction.
///
/// A closed surface whose triangles are all seen from inside covers the sphere of directions equally
/// often everywhere, so that the sum of their solid angles, over 4π, is the number of layers.
fn check_layers(surface: &ClosedSurface, point: &Vector3<f64>) -> Result<(), MeshError> {
    let solid_angle = |vertices: &[usize; 3]| {
        solid_angle_of(vertices.map(|vertex| surface.vertices[vertex] - point))
    };
    let solid_angles = surface.triangles.iter().map(solid_angle);
    let layers = (solid_angles.sum::<f64>() / (4.0 * PI)).round();
    if layers > 1.0 {
        return Err(MeshError::RepeatedSurface { layers });
    }
    Ok(())
}

/// The solid angle of a triangle seen from the origin, positive from inside, by the formula of van
/// Oosterom and Strackee: tan(Ω/2) = a·(b×c)/(|a||b||c| + (a·b)|c| + (b·c)|a| + (c·a)|b|).
fn solid_angle_of(corners: [Vector3<f64>; 3]) -> f64 {
    // Of length one, or products of lengths would leave the range of f64.
    let [a, b, c] = corners.map(|corner| corner.normalize());
    let numerator = a.dot(&b.cross(&c));
    2.0 * atan2(numerator, 1.0 + a.dot(&b) + b.dot(&c) + c.dot(&a))
}
