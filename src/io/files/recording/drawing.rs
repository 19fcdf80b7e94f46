//! Points, triangles and turns as glTF has them.

use super::document::Document;
use crate::scalar::portable::sin_cos;
use crate::spatial::Pose;
use gltf_json::mesh::{Mode, Primitive, Semantic};
use gltf_json::validation::Checked;
use gltf_json::{Accessor, Extras, Index, Material};
use nalgebra::{Isometry3, Vector3};
use rustc_hash::FxHashMap;
use std::f64::consts::TAU;

/// Corners of the cross-section of what is turned.
const SIDES: usize = 16;

/// Points (m) and the triangles between them, counter-clockwise seen from outside.
pub(super) struct Triangles {
    pub points: Vec<Vector3<f64>>,
    pub triangles: Vec<[u32; 3]>,
}

impl Triangles {
    /// Triangles of these vertices, without the vertices that none has.
    pub fn of_surface(vertices: &[Vector3<f64>], triangles: &[[usize; 3]]) -> Self {
        let mut places = FxHashMap::default();
        let mut points = Vec::new();
        let triangles = triangles.iter().map(|triangle| {
            triangle.map(|vertex| {
                *places.entry(vertex).or_insert_with(|| {
                    points.push(vertices[vertex]);
                    index(points.len() - 1)
                })
            })
        });
        let triangles = triangles.collect();
        Self { points, triangles }
    }

    /// A square in the plane z = 0 around the projection of a point, visible from above.
    pub fn tile(center: &Vector3<f64>, half_edge: f64) -> Self {
        let corner =
            |x: f64, y: f64| Vector3::new(center.x + x * half_edge, center.y + y * half_edge, 0.0);
        Self {
            points: vec![
                corner(-1.0, -1.0),
                corner(1.0, -1.0),
                corner(1.0, 1.0),
                corner(-1.0, 1.0),
            ],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
        }
    }

    /// What a line of (radius, height) turned about the z axis passes over, from below upwards.
    pub fn turned(profile: &[[f64; 2]]) -> Self {
        let ring = |&[radius, height]: &[f64; 2]| {
            std::array::from_fn::<_, SIDES, _>(|side| {
                let (sine, cosine) = sin_cos(TAU * side as f64 / SIDES as f64);
                Vector3::new(radius * cosine, radius * sine, height)
            })
        };
        Self::between_rings(&profile.iter().map(ring).collect::<Vec<_>>())
    }

    /// A tube over rings of corners, each counter-clockwise seen from the next one.
    pub fn between_rings<const N: usize>(rings: &[[Vector3<f64>; N]]) -> Self {
        let at = |ring: usize, side: usize| index(ring * N + side % N);
        let between = |ring, side| {
            let [a, b] = [at(ring, side), at(ring, side + 1)];
            let [c, d] = [at(ring + 1, side), at(ring + 1, side + 1)];
            [[a, b, d], [a, d, c]]
        };
        let gaps = 0..rings.len().saturating_sub(1);
        let quads = gaps.flat_map(|ring| (0..N).flat_map(move |side| between(ring, side)));
        Self {
            points: rings.as_flattened().to_vec(),
            triangles: quads.collect(),
        }
    }

    /// A primitive of one material.
    pub fn primitive(&self, document: &mut Document, material: Index<Material>) -> Primitive {
        let positions = document.data.positions(&self.points);
        let triangles = document.data.indices(&self.triangles.concat());
        primitive(Mode::Triangles, positions, triangles, material)
    }
}

/// Points joined to triangles or lines.
pub(super) fn primitive(
    mode: Mode,
    positions: Index<Accessor>,
    indices: Index<Accessor>,
    material: Index<Material>,
) -> Primitive {
    Primitive {
        attributes: [(Checked::Valid(Semantic::Positions), positions)].into(),
        indices: Some(indices),
        material: Some(material),
        mode: Checked::Valid(mode),
        targets: None,
        extensions: None,
        extras: Extras::default(),
    }
}

/// The number of a point.
#[expect(
    clippy::cast_possible_truncation,
    reason = "meshes and contact surfaces have fewer points than a u32 counts"
)]
pub(super) fn index(place: usize) -> u32 {
    place as u32
}

/// The rotation of a pose as a quaternion (x y z w).
pub(super) fn quaternion(pose: &Pose) -> [f64; 4] {
    Isometry3::from(*pose).rotation.coords.into()
}
