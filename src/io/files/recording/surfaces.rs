//! The contact surfaces, colored by pressure.
//!
//! A contact surface has other polygons in every frame, so each that is shown has a mesh of its own,
//! visible (at scale 1 instead of 0) in the frames that it stands for.

use super::document::Document;
use super::drawing::{Triangles, index};
use super::frames::Frame;
use super::materials::{pressure_color, unlit};
use super::precision::single;
use crate::contact::ContactPolygon;
use gltf_json::animation::{Interpolation, Property};
use gltf_json::mesh::{Mesh, Semantic};
use gltf_json::validation::Checked;
use gltf_json::{Index, Material, Node};
use nalgebra::Vector3;
use rustc_hash::FxHashMap;

/// So many contact surfaces at most; each then stands for several frames.
const LARGEST_COUNT: usize = 240;

/// Corners nearer to each other than this, relative to the largest coordinate, are one: several times
/// the rounding of single precision.
const WELDED: f64 = 1e-6;

/// A contact surface as triangles with colors.
struct Colored {
    surface: Triangles,
    colors: Vec<[u8; 4]>,
}

/// Adds the contact surfaces of all frames; not those too small for single precision.
pub(super) fn add(document: &mut Document, frames: &[Frame]) {
    document.data.begin("the contact surfaces");
    let peak = frames.iter().flat_map(polygons).map(peak_pressure);
    let peak = peak.fold(f64::MIN_POSITIVE, f64::max);
    let name = format!("contact surface, brightest at {peak:.3e} Pa");
    let mut material = None;
    for places in shown(frames) {
        let colored = Colored::of(&frames[places[0]], peak);
        if !colored.surface.triangles.is_empty() {
            let white = || document.material(unlit([255; 3], 1.0));
            let material = *material.get_or_insert_with(white);
            let mesh = colored.mesh(document, material);
            show(document, mesh, &name, frames, &places);
        }
    }
}

/// For each contact surface the frames it is shown in, the first of them its own.
fn shown(frames: &[Frame]) -> Vec<Vec<usize>> {
    let touching: Vec<usize> = (0..frames.len())
        .filter(|&place| !frames[place].contacts.is_empty())
        .collect();
    let mut touches: Vec<&[usize]> = touching.chunk_by(|a, b| a + 1 == *b).collect();
    if touches.len() > LARGEST_COUNT {
        // One surface has to stand for several touches.
        touches = vec![&touching];
    }
    let cut = |every: usize| touches.iter().flat_map(move |touch| touch.chunks(every));
    let every = (1..=touching.len()).find(|&every| cut(every).count() <= LARGEST_COUNT);
    cut(every.unwrap_or(1)).map(<[usize]>::to_vec).collect()
}

/// Adds a mesh that is visible in some frames.
fn show(
    document: &mut Document,
    mesh: Index<Mesh>,
    name: &str,
    frames: &[Frame],
    places: &[usize],
) {
    let mut keys: Vec<(f64, bool)> = Vec::new();
    for (place, frame) in frames.iter().enumerate() {
        let is_visible = places.binary_search(&place).is_ok();
        if keys.last().is_none_or(|key| key.1 != is_visible) {
            keys.push((frame.time, is_visible));
        }
    }
    let scale = |key: &(f64, bool)| [f64::from(u8::from(key.1)); 3];
    let scales: Vec<_> = keys.iter().map(scale).collect();
    let times: Vec<_> = keys.iter().map(|key| key.0).collect();
    let node = document.node(Node {
        mesh: Some(mesh),
        name: Some(name.to_owned()),
        scale: Some(single(scales[0])),
        ..Node::default()
    });
    let way = (Property::Scale, Interpolation::Step);
    document.animate(node, way, &times, &scales);
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
                // Plus zero: there are two zeros.
                let near = corner.map(|x| ((x / cell).round() + 0.0).to_bits());
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

    /// The mesh of one material.
    fn mesh(&self, document: &mut Document, material: Index<Material>) -> Index<Mesh> {
        let colors = document.data.colors(&self.colors);
        let mut primitive = self.surface.primitive(document, material);
        let semantic = Checked::Valid(Semantic::Colors(0));
        primitive.attributes.insert(semantic, colors);
        document.mesh(vec![primitive])
    }
}
