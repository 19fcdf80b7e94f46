use super::cored::{CoredSurface, core_size};
use super::{check_resolution, checked_lengths};
use crate::mesh::{MeshError, PressureField};
use nalgebra::Vector3;
use std::f64::consts::{PI, TAU};

/// Sides a cylinder may have.
const SEGMENTS: [usize; 2] = [3, 100_000];

/// A cylinder about the z axis with the given radius and length (m), as a prism of `segments`
/// sides inscribed in it. Its field is the distance to the surface of the prism, over the largest
/// distance: the radius of the circle inscribed in the base, or half the length if that is less.
///
/// The points farthest from the surface form a segment of the axis (a long cylinder), a polygon
/// across it (a short one) or a point, and each face is joined to its part of them.
///
/// # Errors
/// If a dimension is not positive and finite, there are fewer than 3 segments or over 100,000, or
/// the shape is so slender that tetrahedra are flat to round-off.
pub fn cylinder(radius: f64, length: f64, segments: usize) -> Result<PressureField, MeshError> {
    let [radius, length] = checked_lengths([("radius", radius), ("length", length)])?;
    check_resolution("segments", segments, SEGMENTS)?;
    let inscribed = radius * (PI / segments as f64).cos();
    let depth = inscribed.min(length / 2.0);
    // The slimmest tetrahedra stand on a triangle of the core polygon, or join an edge of the ring
    // to the core segment.
    let (edge, longest) = (
        2.0 * radius * (PI / segments as f64).sin(),
        radius.max(length),
    );
    let core_radius = radius * (1.0 - depth / inscribed);
    let core_triangle = core_radius * (TAU / segments as f64).sin();
    let core_radius = core_size(core_radius, core_triangle * depth, longest);
    let core_half_length = core_size(length / 2.0 - depth, 2.0 * edge * inscribed, longest);
    CoredSurface {
        vertices: prism_vertices(radius, length / 2.0, segments),
        triangles: prism_triangles(segments),
        core_points: prism_vertices(core_radius, core_half_length, segments),
    }
    .field()
}

/// The middle of the bottom, the bottom ring, the middle of the top, the top ring.
fn prism_vertices(radius: f64, half_length: f64, segments: usize) -> Vec<Vector3<f64>> {
    [-half_length, half_length]
        .iter()
        .flat_map(|&z| {
            let ring = (0..segments).map(move |k| {
                let (sine, cosine) = (TAU * k as f64 / segments as f64).sin_cos();
                Vector3::new(radius * cosine, radius * sine, z)
            });
            std::iter::once(Vector3::new(0.0, 0.0, z)).chain(ring)
        })
        .collect()
}

/// Two fans and the sides, each side split in two.
fn prism_triangles(segments: usize) -> Vec<[usize; 3]> {
    let top = segments + 1;
    (0..segments)
        .flat_map(|k| {
            let (here, next) = (1 + k, 1 + (k + 1) % segments);
            [
                [0, next, here],
                [top, top + here, top + next],
                [here, next, top + next],
                [here, top + next, top + here],
            ]
        })
        .collect()
}
