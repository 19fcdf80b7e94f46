//! Up direction, size of the scene, and camera.

use super::document::Document;
use super::precision::single;
use crate::dynamics::Body;
use gltf_json::camera::{Camera as GltfCamera, Perspective, Type};
use gltf_json::scene::UnitQuaternion as GltfQuaternion;
use gltf_json::validation::Checked;
use gltf_json::{Extras, Node};
use nalgebra::{UnitQuaternion, Vector3};

/// Vertical field of view (rad).
const FIELD_OF_VIEW: f32 = 0.7;
/// Distance of the near plane, relative to the distance of the point that the camera looks at.
const NEAR_PLANE: f64 = 1e-2;
/// A unit vector is parallel to a direction if its perpendicular component is below this value.
const PARALLEL: f64 = 1e-6;

/// Position of the camera, and the point that it looks at (m).
#[derive(Debug, Clone, Copy)]
pub(super) struct Camera {
    pub eye: Vector3<f64>,
    pub point: Vector3<f64>,
}

impl Camera {
    /// Distance (m) between the camera and the point, if it is too small. The distance of the near plane must be a positive normal number
    /// in single precision.
    pub fn too_near(&self) -> Option<f64> {
        let distance = (self.eye - self.point).norm();
        let [nearest] = single([NEAR_PLANE * distance]);
        (nearest < f32::MIN_POSITIVE).then_some(distance)
    }

    /// Adds the camera. The image is upright. If the camera looks along `up`, the y direction is up in the image.
    pub fn add_to(&self, document: &mut Document, up: &Vector3<f64>) {
        document.data.set_subject("the camera");
        // A glTF camera looks along its negative z axis, and y is up.
        let backwards = self.eye - self.point;
        let upwards = perpendicular_to(&backwards.normalize(), up);
        let rotation = UnitQuaternion::face_towards(&backwards, &upwards);
        let [near] = single([NEAR_PLANE * backwards.norm()]);
        let camera = document.camera(GltfCamera {
            name: None,
            type_: Checked::Valid(Type::Perspective),
            perspective: Some(Perspective {
                aspect_ratio: None,
                yfov: FIELD_OF_VIEW,
                zfar: None,
                znear: near,
                extensions: None,
                extras: Extras::default(),
            }),
            orthographic: None,
            extensions: None,
            extras: Extras::default(),
        });
        document.node(Node {
            camera: Some(camera),
            name: Some("camera".to_owned()),
            translation: Some(single(self.eye.into())),
            rotation: Some(GltfQuaternion(single(rotation.coords.into()))),
            ..Node::default()
        });
    }
}

/// Up direction: opposite to gravity, or z without gravity.
pub(super) fn up(gravity: &Vector3<f64>) -> Vector3<f64> {
    (-gravity).try_normalize(0.0).unwrap_or_else(Vector3::z)
}

/// Quaternion (x y z w) that rotates a direction to y.
pub(super) fn to_y_up(up: &Vector3<f64>) -> [f32; 4] {
    single(rotation_between(up, &Vector3::y()).coords.into())
}

/// Shortest rotation from one direction to another.
pub(super) fn rotation_between(from: &Vector3<f64>, to: &Vector3<f64>) -> UnitQuaternion<f64> {
    UnitQuaternion::rotation_between(from, to).unwrap_or_else(|| {
        // Opposite directions: half a turn about any perpendicular axis.
        let across = from.cross(&Vector3::x());
        let across = across
            .try_normalize(f64::EPSILON)
            .unwrap_or_else(Vector3::y);
        UnitQuaternion::from_scaled_axis(across * std::f64::consts::PI)
    })
}

/// Unit vector perpendicular to `along` that is nearest to `wanted`, or to y or z if `wanted` is parallel to `along`.
pub(super) fn perpendicular_to(along: &Vector3<f64>, wanted: &Vector3<f64>) -> Vector3<f64> {
    let rejected = |vector: &Vector3<f64>| {
        let across = vector - along * along.dot(vector);
        across.try_normalize(PARALLEL)
    };
    let candidates = [*wanted, Vector3::y(), Vector3::z()];
    let across = candidates.iter().find_map(rejected);
    across.unwrap_or_else(Vector3::x)
}

/// Length of the longest arrow (m): the largest diagonal of the bounding box of a dynamic body. It
/// is the largest diagonal of all bodies if no body is dynamic, and 1 if there are no bodies.
pub(super) fn arrow_length(bodies: &[Body]) -> f64 {
    let largest = |is_dynamic: bool| {
        let bodies = bodies.iter();
        let bodies = bodies.filter(|body| body.inertia().is_some() == is_dynamic);
        bodies.filter_map(diagonal).reduce(f64::max)
    };
    largest(true).or_else(|| largest(false)).unwrap_or(1.0)
}

/// Diagonal (m) of the bounding box of a body, or `None` for a half-space and for a body without a shape.
pub(super) fn diagonal(body: &Body) -> Option<f64> {
    let bounds = body.shape().bounds();
    bounds.map(|bounds| 2.0 * bounds.half_extents().norm())
}
