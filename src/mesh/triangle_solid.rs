//! The solid inside a closed surface of triangles: its volume and the orientation of its components.

use super::tet_mesh::FLATNESS;
use super::triangle_components::Components;
use super::{SurfaceError, coordinates};
use crate::geometry::Aabb;
use crate::scalar::portable::atan2;
use nalgebra::Vector3;
use std::cmp::Ordering;
use std::f64::consts::PI;

type Corners = [Vector3<f64>; 3];

/// Limit of the rounding error of a sum of solid angles.
const ANGLE_ERROR: f64 = 1e-3;

/// Directions of the axes and of the diagonals of a cube.
const DIRECTIONS: [[f64; 3]; 7] = [
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [1.0, 1.0, 1.0],
    [1.0, 1.0, -1.0],
    [1.0, -1.0, 1.0],
    [-1.0, 1.0, 1.0],
];

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
    let parts = parts(components, &corners_of)?;
    for (index, part) in parts.iter().enumerate() {
        if part.volume < 0.0 {
            part.check_cavity(index, &parts, &corners_of)?;
        }
    }
    let volume = parts.iter().map(|part| part.volume).sum();
    if volume > 0.0 {
        Ok(())
    } else {
        Err(SurfaceError::NoVolume { volume })
    }
}

/// Returns the triangles of each component of negative volume that is not a cavity.
pub(super) fn inward<'c>(
    vertices: &[Vector3<f64>],
    triangles: &[[usize; 3]],
    components: &'c Components,
) -> Result<Vec<&'c [usize]>, SurfaceError> {
    let corners_of = |triangle: usize| triangles[triangle].map(|vertex| vertices[vertex]);
    let parts = parts(components, &corners_of)?;
    let inward = parts.iter().enumerate().filter(|(index, part)| {
        part.volume < 0.0 && part.check_cavity(*index, &parts, &corners_of).is_err()
    });
    Ok(inward.map(|(_, part)| part.members).collect())
}

fn parts<'c>(
    components: &'c Components,
    corners_of: &impl Fn(usize) -> Corners,
) -> Result<Vec<Part<'c>>, SurfaceError> {
    let parts = components.iter();
    parts
        .map(|members| Part::new(members, corners_of))
        .collect()
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

    /// Checks that the other components surround this component.
    ///
    /// The solid angles of their triangles, seen from a point, add up to 4π inside, to 0 outside, and to an angle between on the surface.
    /// The points are the outermost centroids of the component's triangles. A point on the surface decides nothing.
    fn check_cavity(
        &self,
        index: usize,
        parts: &[Self],
        corners_of: &impl Fn(usize) -> Corners,
    ) -> Result<(), SurfaceError> {
        let (mut has_point_inside, mut outside) = (false, None);
        for point in self.outermost(corners_of) {
            let others = parts.iter().enumerate();
            let around = others.filter(|(part_index, part)| {
                *part_index != index && part.aabb.overlaps(&Aabb::around([&point]))
            });
            let members = around.flat_map(|(_, part)| part.members);
            let offsets =
                members.map(|&triangle| corners_of(triangle).map(|corner| corner - point));
            let angle: f64 = offsets.filter(|o| !is_flat(*o)).map(solid_angle).sum();
            has_point_inside |= angle > 4.0 * PI - ANGLE_ERROR;
            if angle < ANGLE_ERROR {
                outside.get_or_insert(point);
            }
        }
        let triangle = self.members[0];
        match outside {
            None => Ok(()),
            Some(at) if has_point_inside => Err(SurfaceError::SticksOut { triangle, at }),
            Some(_) => Err(SurfaceError::Inward {
                triangle,
                at: corners_of(triangle)[0],
                volume: self.volume,
            }),
        }
    }

    /// Returns the centroids of the triangles that are outermost in the directions of the axes and of the diagonals.
    fn outermost(&self, corners_of: &impl Fn(usize) -> Corners) -> Vec<Vector3<f64>> {
        let mut outermost: Vec<(f64, Vector3<f64>)> =
            vec![(f64::NEG_INFINITY, Vector3::zeros()); 2 * DIRECTIONS.len()];
        for &triangle in self.members {
            let [a, b, c] = corners_of(triangle);
            let centroid = (a + b + c) / 3.0;
            for (ends, direction) in outermost.as_chunks_mut::<2>().0.iter_mut().zip(DIRECTIONS) {
                let height = centroid.dot(&Vector3::from(direction));
                for (end, height) in ends.iter_mut().zip([height, -height]) {
                    if height > end.0 {
                        *end = (height, centroid);
                    }
                }
            }
        }
        let mut points: Vec<Vector3<f64>> = outermost.into_iter().map(|(_, point)| point).collect();
        points.sort_unstable_by(|a, b| a.iter().partial_cmp(b.iter()).unwrap_or(Ordering::Equal));
        points.dedup();
        points
    }
}

/// Returns true if the origin is in the plane of a triangle, to within rounding error. Its solid angle is then 0, or ±2π inside the triangle.
fn is_flat([a, b, c]: Corners) -> bool {
    a.dot(&b.cross(&c)).abs() <= FLATNESS * a.norm() * b.norm() * c.norm()
}

/// Computes the solid angle of a triangle seen from the origin. It is positive if the origin is on the inner side.
pub(super) fn solid_angle(corners: Corners) -> f64 {
    let [adjacent, opposite] = half_solid_angle(corners);
    2.0 * atan2(opposite, adjacent)
}

/// Computes a complex number whose angle is half the solid angle: the real part and the imaginary part (m³).
///
/// tan(Ω/2) = a·(b×c) / (r_a r_b r_c + a·b r_c + b·c r_a + c·a r_b), where r are the lengths [Van Oosterom, Strackee
/// 1983].
///
/// The products do not overflow, because [`check_moments`] limits the size.
pub(super) fn half_solid_angle([a, b, c]: Corners) -> [f64; 2] {
    let [r_a, r_b, r_c] = [a, b, c].map(|corner| corner.norm());
    let adjacent = r_a * r_b * r_c + a.dot(&b) * r_c + b.dot(&c) * r_a + c.dot(&a) * r_b;
    [adjacent, a.dot(&b.cross(&c))]
}
