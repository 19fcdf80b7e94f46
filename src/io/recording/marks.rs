//! Targets and paths.

use super::document::Document;
use super::drawing::{Triangles, single};
use super::materials::{PATHS, TARGET, lit, mixed};
use gltf_json::Node;
use nalgebra::Vector3;

/// A point that is marked by a ball.
#[derive(Debug, Clone)]
pub(super) struct Target {
    pub name: String,
    pub point: Vector3<f64>,
    pub radius: f64,
}

/// A line through points.
#[derive(Debug, Clone)]
pub(super) struct Path {
    pub name: String,
    pub points: Vec<Vector3<f64>>,
}

/// A vector that has less than this across a direction is along it.
const ALONG: f64 = 1e-6;
/// Segments of a marking ball from pole to pole.
const SEGMENTS: usize = 8;
const OPACITY: f32 = 0.6;

pub(super) fn add_targets(document: &mut Document, targets: &[Target]) {
    let meridian: Vec<[f64; 2]> = (0..=SEGMENTS)
        .map(|step| std::f64::consts::PI * step as f64 / SEGMENTS as f64)
        .map(|angle| [angle.sin(), -angle.cos()])
        .collect();
    let ball = Triangles::turned(&meridian);
    for target in targets {
        let material = document.material(lit(TARGET, OPACITY));
        let primitive = ball.primitive(document, material);
        let mesh = document.mesh(&target.name, vec![primitive]);
        document.node(Node {
            mesh: Some(mesh),
            name: Some(target.name.clone()),
            translation: Some(single(target.point.into())),
            scale: Some(single([target.radius; 3])),
            ..Node::default()
        });
    }
}

/// Adds paths as tubes of some radius (m), in colours from that of the first to that of the last.
pub(super) fn add_paths(document: &mut Document, paths: &[Path], radius: f64) {
    let lines = paths.iter().enumerate();
    for (place, path) in lines.filter(|(_, path)| path.points.len() > 1) {
        let color = mixed(PATHS[0], PATHS[1], (place + 1) as f64 / paths.len() as f64);
        let material = document.material(lit(color, 1.0));
        let tube = tube(&path.points, radius).primitive(document, material);
        let mesh = document.mesh(&path.name, vec![tube]);
        document.node(Node {
            mesh: Some(mesh),
            name: Some(path.name.clone()),
            ..Node::default()
        });
    }
}

/// A tube around a line, with open ends.
fn tube(line: &[Vector3<f64>], radius: f64) -> Triangles {
    let mut across = Vector3::zeros();
    let mut rings = Vec::new();
    for (place, point) in line.iter().enumerate() {
        let [before, after] = [place.saturating_sub(1), (place + 1).min(line.len() - 1)];
        let along = (line[after] - line[before]).try_normalize(0.0);
        let along = along.unwrap_or_else(Vector3::x);
        across = square_to(&along, &across);
        let third = along.cross(&across);
        rings.push([across, third, -across, -third].map(|spoke| point + spoke * radius));
    }
    Triangles::between_rings(&rings)
}

/// The direction across `along` that is nearest to `before`.
fn square_to(along: &Vector3<f64>, before: &Vector3<f64>) -> Vector3<f64> {
    let rejected = |vector: &Vector3<f64>| {
        let across = vector - along * along.dot(vector);
        across.try_normalize(ALONG)
    };
    let directions = [*before, Vector3::z(), Vector3::x()];
    directions
        .iter()
        .find_map(rejected)
        .unwrap_or_else(Vector3::y)
}
