//! The scene around the motion: up axis, camera, shared meshes, an empty world, and reproducible bytes.

use super::recorded_worlds::{
    ELASTIC, SINGLE, SINGLE_TURN, SLOWDOWN, assert_near, file, read_back, rollout, rubbing,
    standing, tumbling,
};
use gltf_json::mesh::Semantic;
use gltf_json::validation::Checked;
use hydroelastic::dynamics::World;
use hydroelastic::io::Recording;
use nalgebra::{Vector3, vector};
use std::fs;

#[test]
fn up_is_against_gravity() {
    for (name, gravity, up) in [
        ("minus_z", vector![0.0, 0.0, -9.81], Vector3::z()),
        ("plus_x", vector![1.6, 0.0, 0.0], -Vector3::x()),
        ("plus_y", vector![0.0, 9.81, 0.0], -Vector3::y()),
        ("minus_y", vector![0.0, -9.81, 0.0], Vector3::y()),
        (
            "slanted",
            vector![3.0, 2.0, -6.0],
            vector![-3.0, -2.0, 6.0] / 7.0,
        ),
        ("weightless", Vector3::zeros(), Vector3::z()),
    ] {
        let world = tumbling(ELASTIC).with_gravity(gravity).unwrap();
        let glb = read_back(name, &Recording::new(&world, &standing(&world)));
        let [top] = glb.root.scenes[0].nodes[..] else {
            panic!("expected one root node")
        };
        let shown = glb.placement(top, 0.0).rotation * up;
        assert_near(&shown, &Vector3::y(), SINGLE_TURN);
        let children = glb.root.get(top).unwrap().children.as_ref().unwrap();
        assert_eq!(children.len() + 1, glb.root.nodes.len());
    }
}

#[test]
fn bodies_of_one_shape_share_its_numbers() {
    let world = tumbling(ELASTIC);
    let glb = read_back("shared", &Recording::new(&world, &standing(&world)));
    let numbers = |body| {
        let primitives = glb.primitives(glb.node(body)).iter();
        let positions = |attributes: &std::collections::BTreeMap<_, _>| {
            attributes[&Checked::Valid(Semantic::Positions)]
        };
        let numbers = primitives.map(|p| (positions(&p.attributes), p.indices.unwrap()));
        numbers.collect::<Vec<_>>()
    };
    assert_eq!(numbers("ball"), numbers("twin"));
    assert_ne!(numbers("ball"), numbers("block"));
    let [skin, edges] = &numbers("block")[..] else {
        panic!("expected a surface and edges")
    };
    assert_eq!(skin.0, edges.0);
    let block = glb.mesh(glb.node("block"));
    assert!((block.volume() / 6e-3 - 1.0).abs() < 1e-6);
    // The twelve edges have two indices each, so no diagonal is visible.
    assert_eq!(glb.root.get(edges.1).unwrap().count.0, 24);
}

#[test]
fn a_camera_looks_at_its_point_upright() {
    let world = tumbling(ELASTIC);
    let trajectory = standing(&world);
    let point = vector![0.2, 0.1, 0.3];
    for (name, eye) in [
        ("from_the_side", vector![1.5, -2.0, 0.8]),
        ("from_above", point + Vector3::z() * 3.0),
        ("from_below", point - Vector3::z() * 3.0),
    ] {
        let recording = Recording::new(&world, &trajectory).seen_from(eye, point);
        let glb = read_back(name, &recording);
        let shown = glb.placement(glb.node("camera"), 0.0);
        assert_near(&shown.translation, &eye, SINGLE * eye.amax());
        let looks = shown.rotation * -Vector3::z();
        assert_near(&looks, &(point - eye).normalize(), SINGLE_TURN);
        let right = shown.rotation * Vector3::x();
        assert!(right.z.abs() < SINGLE_TURN, "the camera is tilted");
        assert!(
            (shown.rotation * Vector3::y()).z > -SINGLE_TURN,
            "the camera is upside down"
        );
    }
}

#[test]
fn an_empty_world_has_an_empty_scene() {
    let world = World::new(Vec::new()).unwrap();
    let glb = read_back("empty", &Recording::new(&world, &rollout(&world)));
    assert_eq!(glb.root.nodes.len(), 1);
    assert!(glb.root.animations.is_empty() && glb.binary.is_empty());
}

#[test]
fn a_recording_is_the_same_bytes_each_time() {
    let bytes = |name| {
        let world = tumbling(rubbing());
        let trajectory = rollout(&world);
        let recording = Recording::new(&world, &trajectory).slowed(SLOWDOWN);
        read_back(name, &recording);
        fs::read(file(&format!("{name}.glb"))).unwrap()
    };
    assert!(bytes("first") == bytes("second"));
}
