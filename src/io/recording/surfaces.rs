//! The contact surfaces, coloured by pressure.
//!
//! A contact surface has other polygons in every frame, so each frame that shows one has a mesh of
//! its own, visible (at scale 1 instead of 0) until the next one takes its place.

use super::document::Document;
use super::drawing::{Triangles, index};
use super::frames::Frame;
use super::materials::{pressure_color, unlit};
use crate::contact::ContactPolygon;
use gltf_json::animation::{Interpolation, Property};
use gltf_json::mesh::Semantic;
use gltf_json::validation::Checked;
use gltf_json::{Index, Material, Node};
use nalgebra::Vector3;
use rustc_hash::FxHashMap;
use std::ops::Range;

/// So many contact surfaces at most; each then stands for several frames.
const LARGEST_COUNT: usize = 240;

/// Corners nearer to each other than this, relative to the largest coordinate, are one: several times
/// the rounding of single precision.
const WELDED: f64 = 1e-6;

/// A contact surface as triangles with colours.
struct Colored {
    surface: Triangles,
    colors: Vec<[u8; 4]>,
}

/// Adds the contact surfaces of all frames.
pub(super) fn add(document: &mut Document, frames: &[Frame]) {
    let peak = frames.iter().flat_map(polygons).map(peak_pressure);
    let peak = peak.fold(f64::MIN_POSITIVE, f64::max);
    let material = document.material(unlit([255; 3], 1.0));
    for shown in shown(frames) {
        let colored = Colored::of(&frames[shown.start], peak);
        let name = format!("contact surface, brightest at {peak:.3e} Pa");
        let node = colored.add_to(document, &name, material);
        show(document, node, frames, &shown);
    }
}

/// For each contact surface the frames it is shown in, the first of them its own.
fn shown(frames: &[Frame]) -> Vec<Range<usize>> {
    let touching: Vec<usize> = (0..frames.len())
        .filter(|&place| !frames[place].contacts.is_empty())
        .collect();
    let every = touching.len().div_ceil(LARGEST_COUNT).max(1);
    let runs = touching.chunk_by(|place, next| *next == place + 1);
    runs.flat_map(|run| run.chunks(every))
        .map(|places| places[0]..places[places.len() - 1] + 1)
        .collect()
}

/// Makes a node visible in some frames.
fn show(document: &mut Document, node: Index<Node>, frames: &[Frame], shown: &Range<usize>) {
    let mut keys = vec![(frames[shown.start].time, 1.0)];
    if shown.start > 0 {
        keys.insert(0, (frames[0].time, 0.0));
    }
    if let Some(after) = frames.get(shown.end) {
        keys.push((after.time, 0.0));
    }
    let (times, scales): (Vec<f64>, Vec<[f64; 3]>) = keys
        .into_iter()
        .map(|(time, scale)| (time, [scale; 3]))
        .unzip();
    let times = document.data.times(&times);
    document.animate(node, (Property::Scale, Interpolation::Step), times, &scales);
}

fn polygons<'a>(frame: &'a Frame) -> impl Iterator<Item = &'a ContactPolygon> {
    frame
        .contacts
        .iter()
        .flat_map(|contact| &contact.surface.polygons)
}

fn peak_pressure(polygon: &ContactPolygon) -> f64 {
    let corners = polygon.outline.corners().iter();
    corners
        .map(|corner| polygon.pressure_at(corner))
        .fold(0.0, f64::max)
}

impl Colored {
    /// All contact surfaces of a frame, brightest at the peak pressure (Pa).
    fn of(frame: &Frame, peak: f64) -> Self {
        let corners = polygons(frame).flat_map(|polygon| polygon.outline.corners());
        let largest = corners.fold(0.0, |largest: f64, corner| largest.max(corner.amax()));
        let cell = (WELDED * largest).max(f64::MIN_POSITIVE);
        let mut colored = Self {
            surface: Triangles {
                points: Vec::new(),
                triangles: Vec::new(),
            },
            colors: Vec::new(),
        };
        let mut places = FxHashMap::default();
        for polygon in polygons(frame) {
            let place = |corner: &Vector3<f64>| {
                let near = corner.map(|coordinate| (coordinate / cell).round().to_bits());
                *places.entry(near).or_insert_with(|| {
                    let pressure = polygon.pressure_at(corner) / peak;
                    colored.push(*corner, pressure_color(pressure))
                })
            };
            let corners: Vec<u32> = polygon.outline.corners().iter().map(place).collect();
            colored.fill(&corners);
        }
        colored
    }

    fn push(&mut self, corner: Vector3<f64>, color: [u8; 4]) -> u32 {
        self.surface.points.push(corner);
        self.colors.push(color);
        index(self.colors.len() - 1)
    }

    /// A convex polygon as a fan of triangles.
    fn fill(&mut self, corners: &[u32]) {
        let [first, rest @ ..] = corners else { return };
        let fan = rest.windows(2).map(|side| [*first, side[0], side[1]]);
        let is_flat = |[a, b, c]: &[u32; 3]| a == b || b == c || a == c;
        self.surface
            .triangles
            .extend(fan.filter(|triangle| !is_flat(triangle)));
    }

    /// Invisible where nothing is animated.
    fn add_to(
        &self,
        document: &mut Document,
        name: &str,
        material: Index<Material>,
    ) -> Index<Node> {
        let colors = document.data.colors(&self.colors);
        let mut primitive = self.surface.primitive(document, material);
        let semantic = Checked::Valid(Semantic::Colors(0));
        primitive.attributes.insert(semantic, colors);
        let mesh = document.mesh(name, vec![primitive]);
        document.node(Node {
            mesh: Some(mesh),
            name: Some(name.to_owned()),
            scale: Some([0.0; 3]),
            ..Node::default()
        })
    }
}
