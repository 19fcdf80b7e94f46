//! The solid inside a closed surface of triangles: its volume, and which way round its components are.

use super::tet_mesh::FLATNESS;
use super::triangle_components::Components;
use super::{SurfaceError, coordinates};
use crate::geometry::Aabb;
use crate::scalar::portable::atan2;
use nalgebra::Vector3;
use std::f64::consts::TAU;

type Corners = [Vector3<f64>; 3];

/// A connected component, with the signed volume (m³) inside.
struct Part<'a> {
    members: &'a [usize],
    aabb: Aabb,
    volume: f64,
}

/// Volume (m³) inside triangles, by the divergence theorem: signed tetrahedra between them and a point, which should be in
/// the middle of them, so that little cancels.
pub(super) fn volume(point: Vector3<f64>, triangles: impl Iterator<Item = Corners>) -> f64 {
    let six_volumes = triangles.map(|corners| {
        let [a, b, c] = corners.map(|corner| corner - point);
        a.dot(&b.cross(&c))
    });
    six_volumes.sum::<f64>() / 6.0
}

/// Checks that every component encloses a volume, those with a negative one lie inside others, and all together have
/// a positive volume.
pub(super) fn check_volumes(
    vertices: &[Vector3<f64>],
    triangles: &[[usize; 3]],
    components: &Components,
) -> Result<(), SurfaceError> {
    let corners_of = |triangle: usize| triangles[triangle].map(|vertex| vertices[vertex]);
    let parts = components
        .iter()
        .map(|members| Part::new(members, &corners_of));
    let parts: Vec<Part<'_>> = parts.collect::<Result<_, _>>()?;
    for (index, part) in parts.iter().enumerate() {
        if part.volume < 0.0 && !part.is_inside_others(index, &parts, &corners_of) {
            return Err(SurfaceError::Inward {
                triangle: part.members[0],
                volume: part.volume,
            });
        }
    }
    let volume = parts.iter().map(|part| part.volume).sum();
    if volume > 0.0 {
        Ok(())
    } else {
        Err(SurfaceError::NoVolume { volume })
    }
}

/// Checks that the moments of a solid with so many triangles are finite.
pub(super) fn check_moments(
    vertices: &[Vector3<f64>],
    triangle_count: usize,
) -> Result<(), SurfaceError> {
    let aabb = Aabb::around(vertices);
    let diagonal = (aabb.upper - aabb.lower).norm();
    let size = coordinates::reach(vertices).max(diagonal);
    // No triangle adds more than the fifth power of the size to a second moment (m⁵).
    if (triangle_count as f64 * size.powi(5)).is_finite() {
        Ok(())
    } else {
        Err(SurfaceError::BeyondPrecision { diagonal })
    }
}

impl<'a> Part<'a> {
    fn new(
        members: &'a [usize],
        corners_of: &impl Fn(usize) -> Corners,
    ) -> Result<Self, SurfaceError> {
        let corners = || members.iter().map(|&triangle| corners_of(triangle));
        let all: Vec<Vector3<f64>> = corners().flatten().collect();
        let aabb = Aabb::around(&all);
        let volume = volume(aabb.center(), corners());
        let diagonal = (aabb.upper - aabb.lower).norm();
        // The measure of a flat tetrahedron. Not `<=`: NaN must not pass.
        if 6.0 * volume.abs() > FLATNESS * diagonal.powi(3) {
            return Ok(Self {
                members,
                aabb,
                volume,
            });
        }
        Err(SurfaceError::Flat {
            triangle: members[0],
            volume,
            diagonal,
        })
    }

    /// Whether the other components surround the middle of this one's first triangle: whether the solid angles of their
    /// triangles, seen from there, add up to 4π and not to 0.
    fn is_inside_others(
        &self,
        index: usize,
        parts: &[Self],
        corners_of: &impl Fn(usize) -> Corners,
    ) -> bool {
        let [a, b, c] = corners_of(self.members[0]);
        let point = (a + b + c) / 3.0;
        let others = parts.iter().enumerate();
        let around = others
            .filter(|(other, part)| *other != index && part.aabb.overlaps(&Aabb::around([&point])));
        let members = around.flat_map(|(_, part)| part.members);
        let angle: f64 = members
            .map(|&triangle| solid_angle(corners_of(triangle).map(|corner| corner - point)))
            .sum();
        // Half way between.
        angle > TAU
    }
}

/// Solid angle of a triangle seen from the origin, positive from inside.
///
/// With r for the lengths, tan(Ω/2) = a·(b×c) / (r_a r_b r_c + a·b r_c + b·c r_a + c·a r_b) [Van Oosterom, Strackee 1983].
///
/// The products do not overflow, because [`check_moments`] limits sizes.
pub(super) fn solid_angle([a, b, c]: Corners) -> f64 {
    let [r_a, r_b, r_c] = [a, b, c].map(|corner| corner.norm());
    let adjacent = r_a * r_b * r_c + a.dot(&b) * r_c + b.dot(&c) * r_a + c.dot(&a) * r_b;
    2.0 * atan2(a.dot(&b.cross(&c)), adjacent)
}
