//! Contact surfaces, colored by pressure.
//!
//! The polygons of a contact surface change from frame to frame. Each shown contact surface therefore has its own mesh, which is
//! visible (scale 1) in one or several frames, and hidden (scale 0) in the other frames.

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

/// Maximum number of meshes. If more frames have contacts, each mesh is shown in several frames.
const MAX_MESH_COUNT: usize = 240;

/// Cell size for merging corners, relative to the largest coordinate. It is several times the rounding of single precision.
const WELD_TOLERANCE: f64 = 1e-6;

/// A contact surface as colored triangles.
struct Colored {
    surface: Triangles,
    colors: Vec<[u8; 4]>,
}

/// Adds the contact surfaces of all frames, except surfaces that are too small for single
/// precision.
pub(super) fn add(document: &mut Document, frames: &[Frame]) {
    document.data.set_subject("the contact surfaces");
    let peak = frames.iter().flat_map(polygons).map(peak_pressure);
    let peak = peak.fold(f64::MIN_POSITIVE, f64::max);
    let name = format!("contact surface, brightest at {peak:.3e} Pa");
    let mut material = None;
    for group in frame_groups(frames) {
        let colored = Colored::of(&frames[group[0]], peak);
        if !colored.surface.triangles.is_empty() {
            let white = || document.material(unlit([255; 3], 1.0));
            let material = *material.get_or_insert_with(white);
            let mesh = colored.mesh(document, material);
            show(document, mesh, &name, frames, &group);
        }
    }
}

/// Groups of frames that share a mesh, by index. The mesh is the contact surface of the first frame of the group.
fn frame_groups(frames: &[Frame]) -> Vec<Vec<usize>> {
    let touching: Vec<usize> = (0..frames.len())
        .filter(|&index| !frames[index].contacts.is_empty())
        .collect();
    let mut intervals: Vec<&[usize]> = touching.chunk_by(|a, b| a + 1 == *b).collect();
    if intervals.len() > MAX_MESH_COUNT {
        // A mesh must be shared by several intervals of contact.
        intervals = vec![&touching];
    }
    let chunks_of = |size: usize| intervals.iter().flat_map(move |frames| frames.chunks(size));
    let size = (1..=touching.len()).find(|&size| chunks_of(size).count() <= MAX_MESH_COUNT);
    chunks_of(size.unwrap_or(1))
        .map(<[usize]>::to_vec)
        .collect()
}

/// Adds a mesh that is visible in the frames of a group. The group is sorted.
fn show(document: &mut Document, mesh: Index<Mesh>, name: &str, frames: &[Frame], group: &[usize]) {
    let mut keys: Vec<(f64, bool)> = Vec::new();
    for (index, frame) in frames.iter().enumerate() {
        let is_visible = group.binary_search(&index).is_ok();
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
    let stepwise = (Property::Scale, Interpolation::Step);
    document.animate(node, stepwise, &times, &scales);
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
    /// Creates the colored triangles of all contact surfaces of a frame. The brightest color is that of the peak pressure (Pa).
    fn of(frame: &Frame, peak: f64) -> Self {
        let corners = polygons(frame).flat_map(|polygon| polygon.outline.corners());
        let largest = corners.fold(0.0, |largest: f64, corner| largest.max(corner.amax()));
        let cell = (WELD_TOLERANCE * largest).max(f64::MIN_POSITIVE);
        let mut colored = Self {
            surface: Triangles {
                points: Vec::new(),
                triangles: Vec::new(),
            },
            colors: Vec::new(),
        };
        let mut indices = FxHashMap::default();
        for polygon in polygons(frame) {
            let merged_index = |corner: &Vector3<f64>| {
                // Adding 0.0 converts -0.0 to 0.0, so that both have the same bits.
                let cell_of_corner = corner.map(|x| ((x / cell).round() + 0.0).to_bits());
                *indices.entry(cell_of_corner).or_insert_with(|| {
                    let pressure = polygon.pressure_at(corner) / peak;
                    colored.push(*corner, pressure_color(pressure))
                })
            };
            let corners = polygon.outline.corners().iter().map(merged_index);
            let corners: Vec<u32> = corners.collect();
            colored.fill(&corners);
        }
        colored
    }

    fn push(&mut self, corner: Vector3<f64>, color: [u8; 4]) -> u32 {
        self.surface.points.push(corner);
        self.colors.push(color);
        index(self.colors.len() - 1)
    }

    /// Appends a convex polygon as a fan of triangles.
    fn fill(&mut self, corners: &[u32]) {
        let [first, rest @ ..] = corners else { return };
        let fan = rest.windows(2).map(|side| [*first, side[0], side[1]]);
        let is_degenerate = |[a, b, c]: &[u32; 3]| a == b || b == c || a == c;
        self.surface
            .triangles
            .extend(fan.filter(|triangle| !is_degenerate(triangle)));
    }

    /// Adds the triangles to a document as a mesh of one material.
    fn mesh(&self, document: &mut Document, material: Index<Material>) -> Index<Mesh> {
        let colors = document.data.colors(&self.colors);
        let mut primitive = self.surface.primitive(document, material);
        let semantic = Checked::Valid(Semantic::Colors(0));
        primitive.attributes.insert(semantic, colors);
        document.mesh(vec![primitive])
    }
}
