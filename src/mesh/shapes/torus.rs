use super::cored::CoredSurface;
use super::{check_resolution, checked_lengths, variables};
use crate::mesh::{MeshError, PressureField, ShapeRates};
use crate::scalar::Scalar;
use crate::scalar::portable::sin_cos;
use nalgebra::Vector3;
use std::f64::consts::TAU;

/// Smallest and largest number of segments and of sides of a torus.
const LIMITS: [usize; 2] = [3, 10_000];

/// Creates a torus about the z axis. The center of the tube is a circle of the given `radius` (m), and the tube has the radius
/// `tube_radius` (m). The polyhedron has `segments` steps around the axis and `sides` around the tube.
///
/// The extent is 1 on the center of the tube. It is proportional to the distance to the surface, up to the deviation of the polyhedron from
/// the torus.
///
/// # Errors
/// Returns an error if a radius is not positive and finite, if the tube is not thinner than the radius, or if there are fewer than 3 or more
/// than 10,000 segments or sides.
pub fn torus(
    radius: f64,
    tube_radius: f64,
    segments: usize,
    sides: usize,
) -> Result<PressureField, MeshError> {
    let dimensions = checked([radius, tube_radius], [segments, sides])?;
    filled(dimensions, [segments, sides]).field()
}

/// Computes the rates of change of a [`torus`] with respect to its radius and the radius of its tube (m).
///
/// # Errors
/// Returns the errors of [`torus`].
pub fn torus_rates(
    radius: f64,
    tube_radius: f64,
    segments: usize,
    sides: usize,
) -> Result<[ShapeRates; 2], MeshError> {
    let dimensions = checked([radius, tube_radius], [segments, sides])?;
    filled(variables(dimensions), [segments, sides]).rates()
}

fn checked([radius, tube_radius]: [f64; 2], counts: [usize; 2]) -> Result<[f64; 2], MeshError> {
    let dimensions = checked_lengths([("radius", radius), ("tube radius", tube_radius)])?;
    for (name, count) in ["segments", "sides"].into_iter().zip(counts) {
        check_resolution(name, count, LIMITS)?;
    }
    if tube_radius >= radius {
        return Err(MeshError::ThickTube {
            radius,
            tube_radius,
        });
    }
    Ok(dimensions)
}

/// Creates the surface and the core of the torus with these radii (m).
fn filled<T: Scalar>(
    [radius, tube_radius]: [T; 2],
    [segments, sides]: [usize; 2],
) -> CoredSurface<T> {
    let turns = |count: usize| move |step: usize| sin_cos(TAU * step as f64 / count as f64);
    let places = || (0..segments).flat_map(|segment| (0..sides).map(move |side| (segment, side)));
    let vertex = |segment: usize, from_axis: T, height: T| {
        let (sine, cosine) = turns(segments)(segment);
        Vector3::new(from_axis * cosine, from_axis * sine, height)
    };
    let vertices = places().map(|(segment, side)| {
        let (sine, cosine) = turns(sides)(side);
        vertex(segment, radius + tube_radius * cosine, tube_radius * sine)
    });
    let core_points = places().map(|(segment, _)| vertex(segment, radius, radius * 0.0));
    let triangles = places().flat_map(|(segment, side)| {
        let index =
            |right: usize, up: usize| (segment + right) % segments * sides + (side + up) % sides;
        let [a, b, c, d] = [index(0, 0), index(1, 0), index(1, 1), index(0, 1)];
        [[a, b, c], [a, c, d]]
    });
    CoredSurface {
        vertices: vertices.collect(),
        triangles: triangles.collect(),
        core_points: core_points.collect(),
        is_about_to_open: false,
    }
}
