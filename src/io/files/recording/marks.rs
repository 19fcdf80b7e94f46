//! Targets and paths.

use super::document::Document;
use super::drawing::Triangles;
use super::materials::{Color, PATHS, TARGET, lit, mixed};
use super::precision::single;
use super::view::square_to;
use crate::scalar::portable::sin_cos;
use gltf_json::{Material, Node};
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

/// Segments of a marking ball from pole to pole.
const SEGMENTS: usize = 8;
const OPACITY: f32 = 0.6;

pub(super) fn add_targets(document: &mut Document, targets: &[Target]) {
    let meridian: Vec<[f64; 2]> = (0..=SEGMENTS)
        .map(|step| std::f64::consts::PI * step as f64 / SEGMENTS as f64)
        .map(sin_cos)
        .map(|(sine, cosine)| [sine, -cosine])
        .collect();
    let ball = Triangles::turned(&meridian);
    for target in targets {
        document.data.begin(format!("target {:?}", target.name));
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

/// Adds paths as tubes of some radius (m), in colors from that of the first to that of the last.
pub(super) fn add_paths(document: &mut Document, paths: &[Path], radius: f64) {
    for (place, path) in paths.iter().enumerate() {
        let color = mixed(PATHS[0], PATHS[1], (place + 1) as f64 / paths.len() as f64);
        add_path(document, path, color, radius);
    }
}

fn add_path(document: &mut Document, path: &Path, color: Color, radius: f64) {
    document.data.begin(format!("path {:?}", path.name));
    let points = path.points.iter();
    document
        .data
        .check(points.flat_map(|&point| single(point.into())));
    let line = without_stays(&path.points);
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

/// The points that differ from the one before.
fn without_stays(points: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let mut line = points.to_vec();
    line.dedup_by(|next, point| (*next - *point).norm() == 0.0);
    line
}

/// A tube around a line, with open ends; no point is the one before. Its spokes change as little as they can
/// from point to point, so it is inside out where the line goes back.
fn tube(line: &[Vector3<f64>], radius: f64) -> Triangles {
    let [mut across, mut third] = [Vector3::zeros(); 2];
    let mut rings = Vec::new();
    for (place, point) in line.iter().enumerate() {
        let along = direction(line, place);
        across = square_to(&along, &across);
        let beside = along.cross(&across);
        third = if beside.dot(&third) < 0.0 {
            -beside
        } else {
            beside
        };
        rings.push([across, third, -across, -third].map(|spoke| point + spoke * radius));
    }
    Triangles::between_rings(&rings)
}

/// The direction of a line at one of its points: from the one before to the one after, or, where it turns
/// back, from the one before to it.
fn direction(line: &[Vector3<f64>], place: usize) -> Vector3<f64> {
    let [before, after] = [place.saturating_sub(1), (place + 1).min(line.len() - 1)];
    let chords = [line[after] - line[before], line[place] - line[before]];
    let directions = chords.iter().find_map(|chord| chord.try_normalize(0.0));
    directions.unwrap_or_else(Vector3::x)
}
