//! Targets and paths of a recording.

use super::document::Document;
use super::drawing::Triangles;
use super::materials::{Color, PATHS, TARGET, lit, mixed};
use super::precision::single;
use super::view::perpendicular_to;
use crate::scalar::portable::sin_cos;
use gltf_json::{Material, Node};
use nalgebra::Vector3;

/// A point (m) marked by a ball with a radius (m).
#[derive(Debug, Clone)]
pub(super) struct Target {
    pub name: String,
    pub point: Vector3<f64>,
    pub radius: f64,
}

/// A line through points (m).
#[derive(Debug, Clone)]
pub(super) struct Path {
    pub name: String,
    pub points: Vec<Vector3<f64>>,
}

/// Number of segments of the ball of a target from pole to pole.
const SEGMENTS: usize = 8;
const OPACITY: f32 = 0.6;

pub(super) fn add_targets(document: &mut Document, targets: &[Target]) {
    let meridian: Vec<[f64; 2]> = (0..=SEGMENTS)
        .map(|step| std::f64::consts::PI * step as f64 / SEGMENTS as f64)
        .map(sin_cos)
        .map(|(sine, cosine)| [sine, -cosine])
        .collect();
    let ball = Triangles::of_revolution(&meridian);
    for target in targets {
        document
            .data
            .set_subject(format!("target {:?}", target.name));
        let material = document.material(lit(TARGET, OPACITY));
        let primitive = ball.primitive(document, material);
        let mesh = document.mesh(vec![primitive]);
        document.node(Node {
            mesh: Some(mesh),
            name: Some(target.name.clone()),
            translation: Some(single(target.point.into())),
            scale: Some(single([target.radius; 3])),
            ..Node::default()
        });
    }
}

/// Adds paths as tubes with a radius (m). Their colors are interpolated between the two colors of [`PATHS`].
pub(super) fn add_paths(document: &mut Document, paths: &[Path], radius: f64) {
    for (index, path) in paths.iter().enumerate() {
        let fraction = (index + 1) as f64 / paths.len() as f64;
        let color = mixed(PATHS[0], PATHS[1], fraction);
        add_path(document, path, color, radius);
    }
}

fn add_path(document: &mut Document, path: &Path, color: Color, radius: f64) {
    document.data.set_subject(format!("path {:?}", path.name));
    let points = path.points.iter();
    document
        .data
        .check(points.flat_map(|&point| single(point.into())));
    let line = without_repetitions(&path.points);
    if line.len() < 2 {
        return;
    }
    let material = document.material(Material {
        double_sided: true,
        ..lit(color, 1.0)
    });
    let tube = tube(&line, radius).primitive(document, material);
    let mesh = document.mesh(vec![tube]);
    document.node(Node {
        mesh: Some(mesh),
        name: Some(path.name.clone()),
        ..Node::default()
    });
}

/// Points of a line, without points equal to the previous point.
fn without_repetitions(points: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let mut line = points.to_vec();
    line.dedup_by(|next, point| (*next - *point).norm() == 0.0);
    line
}

/// A tube around a line, with open ends. Consecutive points must differ. The cross-section is
/// rotated as little as possible between points. If the line reverses its direction, the faces
/// after this point are therefore oriented inward.
fn tube(line: &[Vector3<f64>], radius: f64) -> Triangles {
    let [mut across, mut third] = [Vector3::zeros(); 2];
    let mut rings = Vec::new();
    for (index, point) in line.iter().enumerate() {
        let along = direction(line, index);
        across = perpendicular_to(&along, &across);
        let normal = along.cross(&across);
        third = if normal.dot(&third) < 0.0 {
            -normal
        } else {
            normal
        };
        rings.push([across, third, -across, -third].map(|spoke| point + spoke * radius));
    }
    Triangles::between_rings(&rings)
}

/// Direction of a line at one of its points: from the previous point to the next point. If these two coincide, the direction from the
/// previous point to this point.
fn direction(line: &[Vector3<f64>], index: usize) -> Vector3<f64> {
    let [before, after] = [index.saturating_sub(1), (index + 1).min(line.len() - 1)];
    let chords = [line[after] - line[before], line[index] - line[before]];
    let directions = chords.iter().find_map(|chord| chord.try_normalize(0.0));
    directions.unwrap_or_else(Vector3::x)
}
