use super::cored::{CoredSurface, core_size, is_about_to_open, least};
use super::{checked_round_dimensions, variables};
use crate::mesh::{MeshError, PressureField, ShapeRates};
use crate::scalar::portable::sin_cos;
use crate::scalar::{Scalar, lift, real_part};
use nalgebra::Vector3;
use std::f64::consts::{PI, TAU};

/// Smallest and largest number of sides of a cylinder.
const SEGMENTS: [usize; 2] = [3, 100_000];

/// Creates a cylinder about the z axis with the given radius and length (m), as an inscribed prism with `segments`
/// sides.
///
/// The field is the distance to the surface of the prism divided by the largest distance. The largest distance is the
/// smaller of half the length and the radius of the circle inscribed in the base.
///
/// The points farthest from the surface form a segment of the axis (in a long cylinder), a polygon across it (in a
/// short one) or a point. Each face is joined to its part of this core.
///
/// # Errors
/// Returns an error if a dimension is not positive and finite, or if there are fewer than 3 or more than 100,000
/// segments. Also returns an error if the shape is so slender that tetrahedra are flat to within rounding error.
pub fn cylinder(radius: f64, length: f64, segments: usize) -> Result<PressureField, MeshError> {
    let dimensions = checked_round_dimensions(radius, length, (segments, SEGMENTS))?;
    filled(dimensions, segments).field()
}

/// Computes the rates of change of a [`cylinder`] with respect to its radius and its length (m).
///
/// If the length is twice the radius of the circle inscribed in the base, the core is a point. It gains a dimension as
/// soon as one of the two changes, so [`ShapeRates::ambiguous`] lists it. Its rates keep it a point, which is exact for
/// a change of scale alone.
///
/// # Errors
/// Returns the errors of [`cylinder`].
pub fn cylinder_rates(
    radius: f64,
    length: f64,
    segments: usize,
) -> Result<[ShapeRates; 2], MeshError> {
    let dimensions = checked_round_dimensions(radius, length, (segments, SEGMENTS))?;
    filled(variables(dimensions), segments).rates()
}

/// Creates the tetrahedra of the prism with this radius and length (m).
fn filled<T: Scalar>([radius, length]: [T; 2], segments: usize) -> CoredSurface<T> {
    let (sine_of_half, cosine_of_half) = sin_cos(PI / segments as f64);
    let inscribed = radius * cosine_of_half;
    let half_length = length / 2.0;
    let depth = least(&[inscribed, half_length]);
    let core = [
        radius * (lift::<T>(1.0) - depth / inscribed),
        half_length - depth,
    ];
    // The slimmest tetrahedra have a triangle of the core polygon as a face, or join an edge of the ring to the core
    // segment.
    let (edge, longest) = (
        2.0 * real_part(radius) * sine_of_half,
        real_part(radius).max(real_part(length)),
    );
    let core_triangle = real_part(core[0]) * sin_cos(TAU / segments as f64).0;
    let across = [
        core_triangle * real_part(depth),
        2.0 * edge * real_part(inscribed),
    ];
    let solid = [0, 1].map(|i| core_size(core[i], across[i], longest));
    let opens = |i: usize| is_about_to_open(real_part(core[i]), solid[i], real_part(depth));
    CoredSurface {
        vertices: prism_vertices(radius, half_length, segments),
        triangles: prism_triangles(segments),
        core_points: prism_vertices(solid[0], solid[1], segments),
        is_about_to_open: opens(0) && opens(1),
    }
}

/// Returns the center of the bottom, the bottom ring, the center of the top and the top ring.
fn prism_vertices<T: Scalar>(radius: T, half_length: T, segments: usize) -> Vec<Vector3<T>> {
    [-half_length, half_length]
        .iter()
        .flat_map(|&z| {
            let ring = (0..segments).map(move |k| {
                let (sine, cosine) = sin_cos(TAU * k as f64 / segments as f64);
                Vector3::new(radius * cosine, radius * sine, z)
            });
            std::iter::once(Vector3::new(lift(0.0), lift(0.0), z)).chain(ring)
        })
        .collect()
}

/// Returns the triangles of the bottom and top fans and of the sides. Each side is divided in two.
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
