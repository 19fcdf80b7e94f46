//! Surfaces of the bodies, and their poses over time.

use super::document::Document;
use super::drawing::{Triangles, primitive, quaternion};
use super::frames::Frame;
use super::materials::{self, lit, unlit};
use super::precision::single;
use crate::dynamics::{BodyShape, BodyState, Model};
use gltf_json::animation::{Interpolation, Property};
use gltf_json::mesh::{Mesh, Mode};
use gltf_json::scene::UnitQuaternion;
use gltf_json::{Accessor, Index, Material, Node};
use nalgebra::Vector3;
use rustc_hash::FxHashMap;

/// Opacity of dynamic bodies. It is low because the contact surface inside must be visible.
const OPACITY: f32 = 0.45;
/// Opacity of fixed and kinematic bodies.
const SCENERY_OPACITY: f32 = 0.3;
const EDGE_OPACITY: f32 = 0.3;

/// Cosine of 15 degrees. An edge is hidden if the cosine of the angle between the adjacent normals is not below this value.
const SMOOTH: f64 = 0.966;

/// Accessors of the surface of a shape. Bodies with the same shape share them.
#[derive(Clone, Copy)]
struct Outline {
    points: Index<Accessor>,
    triangles: Index<Accessor>,
    /// Visible edges, or `None` if there are none.
    edges: Option<Index<Accessor>>,
}

/// Adds the bodies. Dynamic bodies have different colors.
pub(super) fn add(document: &mut Document, model: &Model, frames: &[Frame]) {
    let bodies = &model.bodies;
    if bodies.is_empty() {
        return;
    }
    let states: Vec<_> = frames.iter().map(|frame| frame.state).collect();
    let half_spaces = model.half_space_outlines(&states);
    let edge = document.material(unlit(materials::EDGES, EDGE_OPACITY));
    let times: Vec<f64> = frames.iter().map(|frame| frame.time).collect();
    let mut outlines: Vec<(&BodyShape, Option<Outline>)> = Vec::new();
    let mut colors = materials::BODIES.into_iter().cycle();
    for (index, body) in bodies.iter().enumerate() {
        document.data.set_subject(format!("body {:?}", body.name()));
        let skin = match body.inertia().and_then(|_| colors.next()) {
            Some(color) => lit(color, OPACITY),
            None => lit(materials::SCENERY, SCENERY_OPACITY),
        };
        let skin = document.material(skin);
        // The polygon of a half-space depends on its pose, so half-spaces share no outline.
        let is_half_space = matches!(body.shape(), BodyShape::HalfSpace(_));
        let known = outlines
            .iter()
            .find(|(shape, _)| !is_half_space && shape.is_same(body.shape()));
        let outline = match known {
            Some((_, outline)) => *outline,
            None => surface(body.shape(), &half_spaces[index])
                .map(|surface| Outline::of(&surface, document)),
        };
        outlines.push((body.shape(), outline));
        let mesh = outline.map(|outline| mesh(document, outline, [skin, edge]));
        let states: Vec<_> = frames
            .iter()
            .map(|frame| frame.state.bodies[index])
            .collect();
        let node = document.node(Node {
            mesh,
            name: Some(body.name().to_owned()),
            translation: Some(single((*states[0].position()).into())),
            rotation: Some(UnitQuaternion(single(quaternion(&states[0].pose)))),
            ..Node::default()
        });
        animate(document, node, &times, &states);
    }
}

/// Adds the mesh of a body: its surface, and its visible edges.
fn mesh(
    document: &mut Document,
    outline: Outline,
    [skin, edge]: [Index<Material>; 2],
) -> Index<Mesh> {
    let Outline {
        points,
        triangles,
        edges,
    } = outline;
    let skin = primitive(Mode::Triangles, points, triangles, skin);
    let edges = edges.map(|edges| primitive(Mode::Lines, points, edges, edge));
    let primitives = [skin].into_iter().chain(edges).collect();
    document.mesh(primitives)
}

/// Surface of a body, or `None` for a body without a shape and for a hidden half-space. `half_space` has the corners of a half-space.
fn surface(shape: &BodyShape, half_space: &[Vector3<f64>]) -> Option<Triangles> {
    Some(match shape {
        BodyShape::Compliant(shape) => {
            let mesh = shape.field().mesh();
            Triangles::of_surface(mesh.vertices(), mesh.surface_triangles())
        }
        BodyShape::Rigid(shape) => {
            let surface = shape.surface();
            Triangles::of_surface(surface.vertices(), surface.triangles())
        }
        BodyShape::HalfSpace(_) if !half_space.is_empty() => Triangles::of_polygon(half_space),
        BodyShape::HalfSpace(_) | BodyShape::None => return None,
    })
}

/// Animates the node of a body, if the body moves.
fn animate(document: &mut Document, node: Index<Node>, times: &[f64], states: &[BodyState]) {
    let positions: Vec<[f64; 3]> = states
        .iter()
        .map(|state| (*state.position()).into())
        .collect();
    let mut rotations: Vec<[f64; 4]> = states.iter().map(|state| quaternion(&state.pose)).collect();
    if moves(&positions) {
        let linear = (Property::Translation, Interpolation::Linear);
        document.animate(node, linear, times, &positions);
    }
    if moves(&rotations) {
        choose_nearest_signs(&mut rotations);
        let linear = (Property::Rotation, Interpolation::Linear);
        document.animate(node, linear, times, &rotations);
    }
}

/// Whether any keyframe differs from the first keyframe in at least one bit.
fn moves<const N: usize>(numbers: &[[f64; N]]) -> bool {
    let bits = |numbers: &[f64; N]| numbers.map(f64::to_bits);
    numbers.iter().any(|key| bits(key) != bits(&numbers[0]))
}

/// Negates each quaternion that has a negative scalar product with the previous quaternion.
/// Interpolation then takes the shorter rotation.
fn choose_nearest_signs(quaternions: &mut [[f64; 4]]) {
    for index in 1..quaternions.len() {
        let [previous, quaternion] = [quaternions[index - 1], quaternions[index]];
        let cosine: f64 = (0..4).map(|i| quaternion[i] * previous[i]).sum();
        if cosine < 0.0 {
            quaternions[index] = quaternion.map(|component| -component);
        }
    }
}

impl Outline {
    fn of(surface: &Triangles, document: &mut Document) -> Self {
        let edges = edges(surface);
        let edges = edges.as_flattened();
        Self {
            points: document.data.positions(&surface.points),
            triangles: document.data.indices(surface.triangles.as_flattened()),
            edges: (!edges.is_empty()).then(|| document.data.indices(edges)),
        }
    }
}

/// Edges between triangles that meet at an angle, sorted.
fn edges(surface: &Triangles) -> Vec<[u32; 2]> {
    let mut normals: FxHashMap<[u32; 2], Vec<Vector3<f64>>> = FxHashMap::default();
    for &[a, b, c] in &surface.triangles {
        let [p_a, p_b, p_c] = [a, b, c].map(|i| surface.points[i as usize]);
        let normal = (p_b - p_a).cross(&(p_c - p_a)).normalize();
        for [i, j] in [[a, b], [b, c], [c, a]] {
            normals
                .entry([i.min(j), i.max(j)])
                .or_default()
                .push(normal);
        }
    }
    let is_visible = |normals: &[Vector3<f64>]| {
        normals
            .windows(2)
            .all(|pair| pair[0].dot(&pair[1]) < SMOOTH)
    };
    normals.retain(|_, normals| is_visible(normals));
    let mut edges: Vec<_> = normals.into_keys().collect();
    edges.sort_unstable();
    edges
}
