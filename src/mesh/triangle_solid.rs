//! The solid inside a closed surface of triangles: its volume and the orientation of its components.

use super::tet_mesh::FLATNESS;
use super::triangle_components::Components;
use super::{SurfaceError, coordinates};
use crate::geometry::Aabb;
use crate::scalar::portable::atan2;
use nalgebra::Vector3;
use std::f64::consts::TAU;

type Corners = [Vector3<f64>; 3];

/// A connected component with its bounding box and the enclosed signed volume (m³).
struct Part<'a> {
    members: &'a [usize],
    aabb: Aabb,
    volume: f64,
}

/// Computes the volume (m³) inside triangles by the divergence theorem, as a sum of signed tetrahedra with apex `point`. A point near the
/// center of the solid keeps cancellation small.
pub(super) fn volume(point: Vector3<f64>, triangles: impl Iterator<Item = Corners>) -> f64 {
    let six_volumes = triangles.map(|corners| {
        let [a, b, c] = corners.map(|corner| corner - point);
        a.dot(&b.cross(&c))
    });
    six_volumes.sum::<f64>() / 6.0
}

/// Checks the enclosed volumes: none is flat, components of negative volume lie inside others, and the sum is positive.
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
                at: corners_of(part.members[0])[0],
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

/// Checks that the moments of a solid of this size and number of triangles are finite.
pub(super) fn check_moments(
    vertices: &[Vector3<f64>],
    triangle_count: usize,
) -> Result<(), SurfaceError> {
    let aabb = Aabb::around(vertices);
    let diagonal = (aabb.upper - aabb.lower).norm();
    let size = coordinates::reach(vertices).max(diagonal);
    // One triangle adds at most the fifth power of the size to a second moment (m⁵).
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
        // The tolerance is that of a flat tetrahedron. The comparison is not `<=`, so that NaN is rejected.
        if 6.0 * volume.abs() > FLATNESS * diagonal.powi(3) {
            return Ok(Self {
                members,
                aabb,
                volume,
            });
        }
        Err(SurfaceError::Flat {
            triangle: members[0],
            at: all[0],
            volume,
            diagonal,
        })
    }

    /// Returns true if the other components surround the centroid of this component's first triangle.
    ///
    /// The solid angles of their triangles, seen from the centroid, then add up to 4π instead of 0.
    fn is_inside_others(
        &self,
        index: usize,
        parts: &[Self],
        corners_of: &impl Fn(usize) -> Corners,
    ) -> bool {
        let [a, b, c] = corners_of(self.members[0]);
        let point = (a + b + c) / 3.0;
        let others = parts.iter().enumerate();
        let around = others.filter(|(part_index, part)| {
            *part_index != index && part.aabb.overlaps(&Aabb::around([&point]))
        });
        let members = around.flat_map(|(_, part)| part.members);
        let angle: f64 = members
            .map(|&triangle| solid_angle(corners_of(triangle).map(|corner| corner - point)))
            .sum();
        // The threshold is halfway between 0 and 4π.
        angle > TAU
    }
}

/// Computes the solid angle of a triangle seen from the origin. It is positive if the origin is on the inner side.
///
/// tan(Ω/2) = a·(b×c) / (r_a r_b r_c + a·b r_c + b·c r_a + c·a r_b), where r are the lengths [Van Oosterom, Strackee
/// 1983].
///
/// The products do not overflow, because [`check_moments`] limits the size.
pub(super) fn solid_angle([a, b, c]: Corners) -> f64 {
    let [r_a, r_b, r_c] = [a, b, c].map(|corner| corner.norm());
    let adjacent = r_a * r_b * r_c + a.dot(&b) * r_c + b.dot(&c) * r_a + c.dot(&a) * r_b;
    2.0 * atan2(a.dot(&b.cross(&c)), adjacent)
}
