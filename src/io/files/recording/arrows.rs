//! Arrows for forces and torques.

use super::document::Document;
use super::drawing::Triangles;
use super::frames::Frame;
use super::loads::{Load, Loads, largest};
use super::materials::{Color, FORCE, TORQUE, lit};
use super::precision::single;
use super::view::rotation_between;
use gltf_json::animation::{Interpolation, Property};
use gltf_json::mesh::Mesh;
use gltf_json::scene::UnitQuaternion;
use gltf_json::{Index, Node};
use nalgebra::Vector3;

/// Appearance of an arrow.
pub(super) struct Style {
    /// Radii and heights from the tail to the tip along z, relative to the length.
    profile: &'static [[f64; 2]],
    color: Color,
    unit: &'static str,
}

/// Arrow with one head.
pub(super) const FORCES: Style = Style {
    profile: &[
        [0.0, 0.0],
        [0.02, 0.0],
        [0.02, 0.8],
        [0.06, 0.8],
        [0.0, 1.0],
    ],
    color: FORCE,
    unit: "N",
};

/// Arrow with two heads.
pub(super) const TORQUES: Style = Style {
    profile: &[
        [0.0, 0.0],
        [0.02, 0.0],
        [0.02, 0.65],
        [0.06, 0.65],
        [0.02, 0.82],
        [0.06, 0.82],
        [0.0, 1.0],
    ],
    color: TORQUE,
    unit: "N m",
};

/// Translation, rotation (x y z w) and scale of an arrow.
type Placement = ([f64; 3], [f64; 4], [f64; 3]);

/// Adds an arrow for each load. `length` is the length (m) of the arrow of the largest vector.
pub(super) fn add(
    document: &mut Document,
    style: &Style,
    loads: &[Loads],
    frames: &[Frame],
    length: f64,
) {
    let largest = largest(loads);
    if largest == 0.0 {
        return;
    }
    let material = document.material(lit(style.color, 1.0));
    let arrow = Triangles::of_revolution(style.profile).primitive(document, material);
    let mesh = document.mesh(vec![arrow]);
    for Loads { name, by_frame } in loads {
        document.data.set_subject(format!("the arrow {name:?}"));
        let name = format!("{name}, {length:.3e} m for {largest:.3e} {}", style.unit);
        let keys = keys(by_frame, frames, |vector| {
            length * (vector.norm() / largest)
        });
        add_arrow(document, mesh, name, &keys);
    }
}

/// Keyframes of an arrow: the times (s) at which its placement changes, and the new placements.
fn keys(
    loads: &[Option<Load>],
    frames: &[Frame],
    length: impl Fn(&Vector3<f64>) -> f64,
) -> Vec<(f64, Placement)> {
    let mut keys: Vec<(f64, Placement)> = Vec::new();
    for (frame, load) in frames.iter().zip(loads) {
        let last = keys.last().map(|key| key.1);
        let shown = load.filter(|load| load.vector.norm() > 0.0);
        let placement = shown.map_or_else(
            || hidden(last),
            |load| placement(&load, length(&load.vector)),
        );
        if last != Some(placement) {
            keys.push((frame.time, placement));
        }
    }
    keys
}

/// Placement of an arrow of a given length (m) that shows a load.
fn placement(load: &Load, length: f64) -> Placement {
    let rotation = rotation_between(&Vector3::z(), &load.vector);
    (load.point.into(), rotation.coords.into(), [length; 3])
}

/// Placement of an arrow without a load: the last placement, with scale 0.
fn hidden(last: Option<Placement>) -> Placement {
    let (translation, rotation, _) = last.unwrap_or(([0.0; 3], [0.0, 0.0, 0.0, 1.0], [0.0; 3]));
    (translation, rotation, [0.0; 3])
}

fn add_arrow(document: &mut Document, mesh: Index<Mesh>, name: String, keys: &[(f64, Placement)]) {
    let translations: Vec<_> = keys.iter().map(|key| key.1.0).collect();
    let rotations: Vec<_> = keys.iter().map(|key| key.1.1).collect();
    let scales: Vec<_> = keys.iter().map(|key| key.1.2).collect();
    let node = document.node(Node {
        mesh: Some(mesh),
        name: Some(name),
        translation: Some(single(translations[0])),
        rotation: Some(UnitQuaternion(single(rotations[0]))),
        scale: Some(single(scales[0])),
        ..Node::default()
    });
    let times: Vec<f64> = keys.iter().map(|key| key.0).collect();
    let stepwise = |property| (property, Interpolation::Step);
    document.animate(node, stepwise(Property::Translation), &times, &translations);
    document.animate(node, stepwise(Property::Rotation), &times, &rotations);
    document.animate(node, stepwise(Property::Scale), &times, &scales);
}
