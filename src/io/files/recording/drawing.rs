//! Triangle meshes and rotations in the conventions of glTF.

use super::document::Document;
use crate::scalar::portable::sin_cos;
use crate::spatial::Pose;
use gltf_json::mesh::{Mode, Primitive, Semantic};
use gltf_json::validation::Checked;
use gltf_json::{Accessor, Extras, Index, Material};
use nalgebra::{Isometry3, Vector3};
use rustc_hash::FxHashMap;
use std::f64::consts::TAU;

/// Number of corners of the cross-section of a surface of revolution.
const SIDES: usize = 16;

/// Points (m) and triangles, counterclockwise seen from outside.
pub(super) struct Triangles {
    pub points: Vec<Vector3<f64>>,
    pub triangles: Vec<[u32; 3]>,
}

impl Triangles {
    /// Creates the triangles of a surface, without its unused vertices.
    pub fn of_surface(vertices: &[Vector3<f64>], triangles: &[[usize; 3]]) -> Self {
        let mut indices = FxHashMap::default();
        let mut points = Vec::new();
        let triangles = triangles.iter().map(|triangle| {
            triangle.map(|vertex| {
                *indices.entry(vertex).or_insert_with(|| {
                    points.push(vertices[vertex]);
                    index(points.len() - 1)
                })
            })
        });
        let triangles = triangles.collect();
        Self { points, triangles }
    }

    /// Creates a fan of triangles from a convex polygon.
    pub fn of_polygon(corners: &[Vector3<f64>]) -> Self {
        let fan = (2..corners.len()).map(|corner| [0, index(corner - 1), index(corner)]);
        Self {
            points: corners.to_vec(),
            triangles: fan.collect(),
        }
    }

    /// Creates a surface of revolution about the z axis. The profile is a line of (radius, height), from bottom to top.
    pub fn of_revolution(profile: &[[f64; 2]]) -> Self {
        let ring = |&[radius, height]: &[f64; 2]| {
            std::array::from_fn::<_, SIDES, _>(|side| {
                let (sine, cosine) = sin_cos(TAU * side as f64 / SIDES as f64);
                Vector3::new(radius * cosine, radius * sine, height)
            })
        };
        Self::between_rings(&profile.iter().map(ring).collect::<Vec<_>>())
    }

    /// Creates a tube over rings of corners. Each ring is counterclockwise seen from the next ring.
    pub fn between_rings<const N: usize>(rings: &[[Vector3<f64>; N]]) -> Self {
        let corner = |ring: usize, side: usize| index(ring * N + side % N);
        let quad = |ring, side| {
            let [a, b] = [corner(ring, side), corner(ring, side + 1)];
            let [c, d] = [corner(ring + 1, side), corner(ring + 1, side + 1)];
            [[a, b, d], [a, d, c]]
        };
        let gaps = 0..rings.len().saturating_sub(1);
        let quads = gaps.flat_map(|ring| (0..N).flat_map(move |side| quad(ring, side)));
        Self {
            points: rings.as_flattened().to_vec(),
            triangles: quads.collect(),
        }
    }

    /// Adds the triangles to a document and returns a primitive of one material.
    pub fn primitive(&self, document: &mut Document, material: Index<Material>) -> Primitive {
        let positions = document.data.positions(&self.points);
        let triangles = document.data.indices(&self.triangles.concat());
        primitive(Mode::Triangles, positions, triangles, material)
    }
}

/// Returns a primitive of triangles or lines between points.
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

/// Converts the index of a point to `u32`.
#[expect(
    clippy::cast_possible_truncation,
    reason = "meshes and contact surfaces have fewer points than a u32 counts"
)]
pub(super) fn index(point: usize) -> u32 {
    point as u32
}

/// Rotation of a pose as a quaternion (x y z w).
pub(super) fn quaternion(pose: &Pose) -> [f64; 4] {
    Isometry3::from(*pose).rotation.coords.into()
}
