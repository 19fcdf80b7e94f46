//! Arrows for forces and torques.

use super::document::Document;
use super::drawing::Triangles;
use super::frames::Frame;
use super::loads::{Load, Loads};
use super::materials::{Color, FORCE, TORQUE, lit};
use super::view::turn_between;
use gltf_json::animation::{Interpolation, Property};
use gltf_json::mesh::Mesh;
use gltf_json::{Index, Node};
use nalgebra::Vector3;

/// How an arrow looks: radii and heights from its tail to its tip, along z.
pub(super) struct Style {
    profile: &'static [[f64; 2]],
    color: Color,
    unit: &'static str,
}

/// One head.
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

/// Two heads.
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

/// Adds an arrow for each load, the longest of them of a given length (m).
pub(super) fn add(
    document: &mut Document,
    (style, loads): (&Style, &[Loads]),
    frames: &[Frame],
    length: f64,
) {
    let all = loads
        .iter()
        .flat_map(|loads| loads.by_frame.iter().flatten());
    let largest = all.map(|load| load.vector.norm()).fold(0.0, f64::max);
    if largest == 0.0 {
        return;
    }
    let material = document.material(lit(style.color, 1.0));
    let arrow = Triangles::turned(style.profile).primitive(document, material);
    let mesh = document.mesh("arrow", vec![arrow]);
    for load in loads {
        let name = format!(
            "{}, {length:.3e} m for {largest:.3e} {}",
            load.name, style.unit
        );
        add_arrow(
            document,
            (mesh, name),
            &load.by_frame,
            (frames, length / largest),
        );
    }
}

/// One arrow, invisible (at scale 0) where there is no load.
fn add_arrow(
    document: &mut Document,
    (mesh, name): (Index<Mesh>, String),
    loads: &[Option<Load>],
    (frames, scale): (&[Frame], f64),
) {
    let node = document.node(Node {
        mesh: Some(mesh),
        name: Some(name),
        scale: Some([0.0; 3]),
        ..Node::default()
    });
    let mut keys: Vec<(f64, Placement)> = Vec::new();
    for (frame, load) in frames.iter().zip(loads) {
        let last = keys.last().map(|key| key.1);
        let placement = placement(load.as_ref(), scale, last);
        if last != Some(placement) {
            keys.push((frame.time, placement));
        }
    }
    let times: Vec<f64> = keys.iter().map(|key| key.0).collect();
    let times = document.data.times(&times);
    let translations: Vec<_> = keys.iter().map(|key| key.1.0).collect();
    let rotations: Vec<_> = keys.iter().map(|key| key.1.1).collect();
    let scales: Vec<_> = keys.iter().map(|key| key.1.2).collect();
    let way = |property| (property, Interpolation::Step);
    document.animate(node, way(Property::Translation), times, &translations);
    document.animate(node, way(Property::Rotation), times, &rotations);
    document.animate(node, way(Property::Scale), times, &scales);
}

/// Where an arrow is; without a load it stays where it was last, at scale 0.
fn placement(load: Option<&Load>, scale: f64, last: Option<Placement>) -> Placement {
    let hidden = last.unwrap_or(([0.0; 3], [0.0, 0.0, 0.0, 1.0], [0.0; 3]));
    let Some(load) = load.filter(|load| load.vector.norm() > 0.0) else {
        return (hidden.0, hidden.1, [0.0; 3]);
    };
    let turn = turn_between(&Vector3::z(), &load.vector);
    let length = scale * load.vector.norm();
    (load.point.into(), turn.coords.into(), [length; 3])
}
