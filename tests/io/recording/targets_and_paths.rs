//! Targets and paths, shown as balls and tubes.

use super::recorded_worlds::{ELASTIC, SINGLE, assert_near, read_back, standing, tumbling};
use crate::support::glb::Mesh;
use hydroelastic::io::Recording;
use nalgebra::{Vector3, vector};
use std::f64::consts::SQRT_2;

#[test]
fn a_target_is_a_ball_around_its_point() {
    let world = tumbling(ELASTIC);
    let trajectory = standing(&world);
    let point = vector![0.3, -1.7, 0.1];
    let recording = Recording::new(&world, &trajectory).with_target("bull's eye", point, 0.05);
    let glb = read_back("target", &recording);
    let node = glb.node("bull's eye");
    let shown = glb.placement(node, 0.0);
    assert_near(&shown.translation, &point, SINGLE * point.amax());
    let ball = glb.mesh(node);
    for p in &ball.points {
        assert!((p.norm() * shown.scale.x - 0.05).abs() < SINGLE);
    }
    assert!(ball.volume() > 0.8 * 4.0 / 3.0 * std::f64::consts::PI);
}

/// Returns the mesh of a path through points.
fn tube(name: &str, points: &[Vector3<f64>]) -> Option<Mesh> {
    let world = tumbling(ELASTIC);
    let trajectory = standing(&world);
    let recording = Recording::new(&world, &trajectory);
    let glb = read_back(name, &recording.with_path("way", points.to_vec()));
    glb.nodes("way").first().map(|&node| glb.mesh(node))
}

#[test]
fn a_path_is_a_tube_around_its_line() {
    for (name, to) in [
        ("along_z", Vector3::z()),
        ("aslant", vector![0.6, 0.0, -0.8]),
    ] {
        let from = vector![0.1, 0.2, 0.3];
        let tube = tube(name, &[0.0, 0.5, 2.0].map(|along| from + to * along)).unwrap();
        let along: Vec<f64> = tube.points.iter().map(|p| (p - from).dot(&to)).collect();
        let ends = |extreme: fn(f64, f64) -> f64| along.iter().copied().reduce(extreme).unwrap();
        let tolerance = 4.0 * SINGLE;
        assert!(ends(f64::min).abs() < tolerance && (ends(f64::max) - 2.0).abs() < tolerance);
        let across = |p: &Vector3<f64>| (p - from).cross(&to).norm();
        let radius = across(&tube.points[0]);
        assert!(radius > 1e-3 && radius < 0.05, "{radius}");
        assert!(
            tube.points
                .iter()
                .all(|p| (across(p) - radius).abs() < tolerance)
        );
        // The section is a square, so each side is √2 times the radius.
        let sides = 4.0 * SQRT_2 * radius * 2.0;
        assert!(
            (tube.area() / sides - 1.0).abs() < 1e-5,
            "{} {sides}",
            tube.area()
        );
    }
}

#[test]
fn a_path_that_stays_for_a_while_has_the_same_tube() {
    let [a, b, c] = [
        vector![0.0, 0.0, 1.0],
        vector![0.0, 0.0, 2.0],
        vector![0.5, 0.0, 2.0],
    ];
    let moving = tube("moving", &[a, b, c]).unwrap();
    let staying = tube("staying", &[a, a, b, b, b, c, c]).unwrap();
    assert_eq!(moving.points, staying.points);
    assert_eq!(moving.triangles, staying.triangles);
}

#[test]
fn a_path_that_turns_back_keeps_its_thickness() {
    let [a, b] = [vector![0.1, 0.0, 1.0], vector![1.1, 0.0, 1.0]];
    let there = tube("there", &[a, b]).unwrap();
    let back = tube("and_back", &[a, b, a]).unwrap();
    assert!((back.area() / there.area() - 2.0).abs() < 1e-5);
}

#[test]
fn a_path_of_one_place_is_not_shown() {
    let point = vector![0.1, 0.2, 0.3];
    for (name, points) in [
        ("none", &[][..]),
        ("one", &[point]),
        ("same", &[point, point]),
    ] {
        assert!(tube(name, points).is_none());
    }
}
