use super::cored::{CoredSurface, core_size};
use super::{checked_round_dimensions, variables};
use crate::mesh::{MeshError, PressureField, ShapeRates};
use crate::scalar::portable::sin_cos;
use crate::scalar::{Scalar, lift, real_part};
use nalgebra::Vector3;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Smallest and largest number of sides of a capsule. The number of tetrahedra grows with its square.
const SEGMENTS: [usize; 2] = [3, 1_000];

/// Creates a capsule about the z axis: a cylinder of the given radius and length (m) with half balls at its ends. It is an inscribed
/// polyhedron with `segments` sides.
///
/// The length is the length of the cylinder alone, so the capsule is `length + 2 * radius` long. Its core is the axis of the cylinder. The
/// field is proportional to the distance to the surface, up to the deviation of the polyhedron from the capsule.
///
/// # Errors
/// Returns an error if a dimension is not positive and finite, or if there are fewer than 3 or more than 1,000 segments. Also returns an
/// error if the shape is so slender that tetrahedra are flat to within rounding error.
pub fn capsule(radius: f64, length: f64, segments: usize) -> Result<PressureField, MeshError> {
    let dimensions = checked_round_dimensions(radius, length, (segments, SEGMENTS))?;
    filled(dimensions, segments).field()
}

/// Computes the rates of change of a [`capsule`] with respect to its radius and its length (m).
///
/// # Errors
/// Returns the errors of [`capsule`].
pub fn capsule_rates(
    radius: f64,
    length: f64,
    segments: usize,
) -> Result<[ShapeRates; 2], MeshError> {
    let dimensions = checked_round_dimensions(radius, length, (segments, SEGMENTS))?;
    filled(variables(dimensions), segments).rates()
}

/// Creates the tetrahedra of the capsule with this radius and length (m).
fn filled<T: Scalar>([radius, length]: [T; 2], segments: usize) -> CoredSurface<T> {
    let half_length = length / 2.0;
    let [real_radius, real_length] = [radius, length].map(real_part);
    // The slimmest tetrahedra join an edge of a ring at an end of the cylinder to the core segment.
    let edge = 2.0 * real_radius * sin_cos(PI / segments as f64).0;
    let longest = real_length + 2.0 * real_radius;
    let half_core = core_size(half_length, 2.0 * edge * real_radius, longest);
    let zero = lift::<T>(0.0);
    let directions = directions(segments);
    let top_start = directions.len() / 2;
    let of_end = |index: usize, half: T| if index < top_start { -half } else { half };
    let vertices = directions.iter().enumerate().map(|(index, direction)| {
        let center = Vector3::new(zero, zero, of_end(index, half_length));
        center + direction.map(|x| radius * x)
    });
    let core_points =
        (0..directions.len()).map(|index| Vector3::new(zero, zero, of_end(index, half_core)));
    CoredSurface {
        vertices: vertices.collect(),
        triangles: triangles(segments),
        core_points: core_points.collect(),
        is_about_to_open: false,
    }
}

/// Number of rings of a half ball.
fn ring_count(segments: usize) -> usize {
    segments.div_ceil(4)
}

/// Directions from the center of the half ball to its vertices: the south pole, the rings from south to north and the north pole. Each half
/// ball has a ring at its equator.
fn directions(segments: usize) -> Vec<Vector3<f64>> {
    let count = ring_count(segments);
    let latitude = |step: usize| FRAC_PI_2 * step as f64 / count as f64;
    let south = (0..count).rev().map(|step| -latitude(step));
    let rings = south.chain((0..count).map(latitude)).flat_map(|latitude| {
        let (height, radius) = sin_cos(latitude);
        (0..segments).map(move |k| {
            let (sine, cosine) = sin_cos(TAU * k as f64 / segments as f64);
            Vector3::new(radius * cosine, radius * sine, height)
        })
    });
    let poles = [-Vector3::z(), Vector3::z()];
    let [south_pole, north_pole] = poles.map(std::iter::once);
    south_pole.chain(rings).chain(north_pole).collect()
}

/// Triangles of the fan around the south pole, of the bands between rings, and of the fan around the north pole.
fn triangles(segments: usize) -> Vec<[usize; 3]> {
    let band_count = 2 * ring_count(segments) - 1;
    let last_ring = 1 + band_count * segments;
    let north_pole = last_ring + segments;
    let next = |k: usize| (k + 1) % segments;
    let south = (0..segments).map(|k| [0, 1 + next(k), 1 + k]);
    let bands = (0..band_count).flat_map(|band| {
        let (low, high) = (1 + band * segments, 1 + (band + 1) * segments);
        (0..segments).flat_map(move |k| {
            [
                [low + k, low + next(k), high + next(k)],
                [low + k, high + next(k), high + k],
            ]
        })
    });
    let north = (0..segments).map(|k| [last_ring + k, last_ring + next(k), north_pole]);
    south.chain(bands).chain(north).collect()
}
