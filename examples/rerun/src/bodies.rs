//! Logging of the bodies: their surfaces once, their poses in every frame.

use crate::layout::WORLD;
use crate::palette;
use hydroelastic::dynamics::{Body, State, World};
use hydroelastic::mesh::TetMesh;
use hydroelastic::spatial::Pose;
use nalgebra::Vector3;
use rerun::{Mesh3D, RecordingStream, RecordingStreamResult, Rgba32, Transform3D, ViewCoordinates};

/// Logs the up axis, and the surface of every body in the body's frame.
pub fn log_shapes(recording: &RecordingStream, world: &World) -> RecordingStreamResult<()> {
    recording.log_static(WORLD, &ViewCoordinates::RIGHT_HAND_Z_UP())?;
    for body in world.bodies() {
        recording.log_static(path(body), &mesh(body))?;
    }
    Ok(())
}

/// Logs the poses of the bodies.
pub fn log_poses(
    recording: &RecordingStream,
    world: &World,
    state: &State,
) -> RecordingStreamResult<()> {
    for (body, body_state) in world.bodies().iter().zip(&state.bodies) {
        recording.log(path(body), &transform(&body_state.pose))?;
    }
    Ok(())
}

fn path(body: &Body) -> String {
    format!("{WORLD}/{}", body.name())
}

/// Returns the surface of a body. Triangles do not share vertices, so the facets are visible.
fn mesh(body: &Body) -> Mesh3D {
    let mesh = body.shape().field().mesh();
    let moves = body.inertia().is_some();
    let (mut corners, mut normals, mut colors) = (Vec::new(), Vec::new(), Vec::new());
    for triangle in triangles(mesh) {
        let [a, b, c] = triangle;
        let normal = (b - a).cross(&(c - a)).normalize();
        corners.extend(triangle.map(|corner| single(&corner)));
        normals.extend([single(&normal); 3]);
        colors.extend([color(&((a + b + c) / 3.0), moves); 3]);
    }
    Mesh3D::new(corners)
        .with_vertex_normals(normals)
        .with_vertex_colors(colors)
        .with_albedo_factor(palette::GLASS)
}

/// Yields the corners (m) of the surface triangles, counter-clockwise seen from outside.
fn triangles(mesh: &TetMesh) -> impl Iterator<Item = [Vector3<f64>; 3]> {
    let corners = |triangle: &[usize; 3]| triangle.map(|vertex| mesh.vertices()[vertex]);
    mesh.surface_triangles().iter().map(corners)
}

/// Returns the color of a point of a body. The octants of a moving body alternate between two colors, so its rotation is visible.
fn color(center: &Vector3<f64>, moves: bool) -> Rgba32 {
    match (moves, center.product() > 0.0) {
        (false, _) => palette::FIXED,
        (true, false) => palette::MOVING[0],
        (true, true) => palette::MOVING[1],
    }
}

fn transform(pose: &Pose) -> Transform3D {
    let columns: [[f32; 3]; 3] = pose.rotation().cast().into();
    Transform3D::from_translation_mat3x3(single(pose.translation()), columns)
}

/// Converts a vector to the single precision that the viewer uses.
pub fn single(vector: &Vector3<f64>) -> [f32; 3] {
    vector.cast().into()
}
