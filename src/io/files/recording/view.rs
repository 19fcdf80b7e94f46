//! Up, sizes and the camera.

use super::document::Document;
use super::precision::single;
use crate::dynamics::Body;
use gltf_json::camera::{Camera as GltfCamera, Perspective, Type};
use gltf_json::scene::UnitQuaternion as GltfQuaternion;
use gltf_json::validation::Checked;
use gltf_json::{Extras, Node};
use nalgebra::{UnitQuaternion, Vector3};

/// Vertical angle of view (rad).
const VIEW: f32 = 0.7;
/// The nearest distance seen, as a part of that to the point looked at.
const NEAREST: f64 = 1e-2;
/// A unit vector that has less than this across a direction is along it.
const ALONG: f64 = 1e-6;

/// Where the scene is seen from, and the point looked at (m).
#[derive(Debug, Clone, Copy)]
pub(super) struct Camera {
    pub eye: Vector3<f64>,
    pub point: Vector3<f64>,
}

impl Camera {
    /// How far (m) the camera is from the point, if that is so near that single precision does not have the
    /// nearest distance seen, as it has to be positive.
    pub fn too_near(&self) -> Option<f64> {
        let distance = (self.eye - self.point).norm();
        let [nearest] = single([NEAREST * distance]);
        (nearest < f32::MIN_POSITIVE).then_some(distance)
    }

    /// Adds the camera, upright, or with y up in its picture if it looks along `up`.
    pub fn add_to(&self, document: &mut Document, up: &Vector3<f64>) {
        document.data.begin("the camera");
        // A camera of glTF looks against its z axis; y is up.
        let backwards = self.eye - self.point;
        let upwards = square_to(&backwards.normalize(), up);
        let turn = UnitQuaternion::face_towards(&backwards, &upwards);
        let [near] = single([NEAREST * backwards.norm()]);
        let camera = document.camera(GltfCamera {
            name: None,
            type_: Checked::Valid(Type::Perspective),
            perspective: Some(Perspective {
                aspect_ratio: None,
                yfov: VIEW,
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
            rotation: Some(GltfQuaternion(single(turn.coords.into()))),
            ..Node::default()
        });
    }
}

/// Against gravity, or z without it.
pub(super) fn up(gravity: &Vector3<f64>) -> Vector3<f64> {
    (-gravity).try_normalize(0.0).unwrap_or_else(Vector3::z)
}

/// The quaternion (x y z w) that turns a direction into y.
pub(super) fn to_y_up(up: &Vector3<f64>) -> [f32; 4] {
    single(turn_between(up, &Vector3::y()).coords.into())
}

/// The shortest turn from one direction to another.
pub(super) fn turn_between(from: &Vector3<f64>, to: &Vector3<f64>) -> UnitQuaternion<f64> {
    UnitQuaternion::rotation_between(from, to).unwrap_or_else(|| {
        // Opposite directions: half a turn about any axis across.
        let across = from.cross(&Vector3::x());
        let across = across
            .try_normalize(f64::EPSILON)
            .unwrap_or_else(Vector3::y);
        UnitQuaternion::from_scaled_axis(across * std::f64::consts::PI)
    })
}

/// The direction across `along` that is nearest to `wanted`, or to y or z if `wanted` is along it.
pub(super) fn square_to(along: &Vector3<f64>, wanted: &Vector3<f64>) -> Vector3<f64> {
    let rejected = |vector: &Vector3<f64>| {
        let across = vector - along * along.dot(vector);
        across.try_normalize(ALONG)
    };
    let candidates = [*wanted, Vector3::y(), Vector3::z()];
    let across = candidates.iter().find_map(rejected);
    across.unwrap_or_else(Vector3::x)
}

/// Length of the longest arrow (m): the diagonal of the box around the largest body that forces move; of
/// the largest of all if there is none, or 1 without bodies.
pub(super) fn arrow_length(bodies: &[Body]) -> f64 {
    let largest = |moves: bool| {
        let bodies = bodies.iter();
        let bodies = bodies.filter(|body| body.inertia().is_some() == moves);
        bodies.filter_map(diagonal).reduce(f64::max)
    };
    largest(true).or_else(|| largest(false)).unwrap_or(1.0)
}

/// Diagonal (m) of the box around a body, if it has an end.
pub(super) fn diagonal(body: &Body) -> Option<f64> {
    let bounds = body.shape().bounds();
    bounds.map(|bounds| 2.0 * bounds.half_extents().norm())
}
