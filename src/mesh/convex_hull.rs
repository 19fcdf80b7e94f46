//! Convex hulls of points, by quickhull [Barber, Dobkin, Huhdanpaa 1996].
//!
//! The hull starts as a tetrahedron. A point outside the hull replaces the facets visible from it by a cone over their boundary, the
//! horizon. An exact predicate decides which facets are visible, so that the hull stays closed and convex. A distance decides only which
//! points count as outside.

use super::coordinates;
use crate::geometry::Aabb;
use nalgebra::Vector3;
use robust::{Coord3D, orient3d};
use rustc_hash::FxHashMap;

/// Distance below which a point does not extend the hull, relative to the power of two above the largest distance of a point from the
/// center of the bounding box.
const RELATIVE_TOLERANCE: f64 = 1e-10;

/// Points relative to the center are scaled to this size, and their coordinates are rounded to integers. Products of three then neither
/// overflow nor underflow, so that predicates are exact.
const SIZE_EXPONENT: i32 = 80;

/// Tolerance for scaled points.
const TOLERANCE: f64 = RELATIVE_TOLERANCE * (1_u128 << SIZE_EXPONENT) as f64;

/// Returns the triangles of the convex hull, counter-clockwise when seen from outside, or `None` if the points lie in a plane. The
/// points must be finite.
pub(super) fn triangles(points: &[Vector3<f64>]) -> Option<Vec<[usize; 3]>> {
    let points = scaled(points);
    let mut hull = Hull::of_tetrahedron(&points)?;
    while let Some(facet) = hull.waiting.pop() {
        let farthest = hull.facets[facet].as_ref().and_then(Facet::farthest);
        if let Some(point) = farthest {
            hull.extend(facet, point);
        }
    }
    let facets = hull.facets.into_iter().flatten();
    Some(facets.map(|facet| facet.corners).collect())
}

fn scaled(points: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let aabb = Aabb::around(points);
    let center = aabb.lower.zip_map(&aabb.upper, f64::midpoint);
    let offsets: Vec<Vector3<f64>> = points.iter().map(|point| point - center).collect();
    let (_, exponent) = libm::frexp(coordinates::reach(&offsets));
    let scaled = |x: f64| libm::scalbn(x, SIZE_EXPONENT - exponent).round();
    offsets.iter().map(|offset| offset.map(scaled)).collect()
}

struct Facet {
    corners: [usize; 3],
    /// Facet across the edge from corner k to corner k + 1.
    neighbors: [usize; 3],
    /// Points outside this facet, with their distances.
    outside: Vec<(f64, usize)>,
}

impl Facet {
    fn farthest(&self) -> Option<usize> {
        let farthest = self.outside.iter().max_by(|a, b| a.0.total_cmp(&b.0));
        farthest.map(|&(_, point)| point)
    }
}

struct Hull<'p> {
    points: &'p [Vector3<f64>],
    /// Facets. Removed facets are `None`.
    facets: Vec<Option<Facet>>,
    /// Facets that may have points outside.
    waiting: Vec<usize>,
}

impl<'p> Hull<'p> {
    /// Returns the tetrahedron of four points that are far from each other, with all points assigned to its facets, or `None` if the
    /// points lie in a plane.
    fn of_tetrahedron(points: &'p [Vector3<f64>]) -> Option<Self> {
        let farthest = |distance: &dyn Fn(&Vector3<f64>) -> f64| {
            let distances = points.iter().map(distance).enumerate();
            let farthest = distances.max_by(|a, b| a.1.total_cmp(&b.1));
            farthest.filter(|(_, distance)| *distance > TOLERANCE)
        };
        let first = *points.first()?;
        let (a, _) = farthest(&|point| (point - first).norm())?;
        let origin = points[a];
        let (b, _) = farthest(&|point| (point - origin).norm())?;
        let along = (points[b] - origin).normalize();
        let (c, _) = farthest(&|point| along.cross(&(point - origin)).norm())?;
        let normal = along.cross(&(points[c] - origin)).normalize();
        let (d, _) = farthest(&|point| normal.dot(&(point - origin)).abs())?;
        let mut hull = Self {
            points,
            facets: Vec::new(),
            waiting: Vec::new(),
        };
        let [b, c] = match hull.height([a, b, c], d) {
            0.0 => return None,
            height if height > 0.0 => [c, b],
            _ => [b, c],
        };
        let neighbors = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];
        let corners = [[a, b, c], [b, a, d], [c, b, d], [a, c, d]];
        for (corners, neighbors) in corners.into_iter().zip(neighbors) {
            hull.add(corners, neighbors);
        }
        hull.assign((0..points.len()).collect(), 0);
        Some(hull)
    }

    fn add(&mut self, corners: [usize; 3], neighbors: [usize; 3]) {
        self.facets.push(Some(Facet {
            corners,
            neighbors,
            outside: Vec::new(),
        }));
    }

    /// Returns a number that is positive if a point is outside the plane of a facet, and has the exact sign.
    fn height(&self, corners: [usize; 3], point: usize) -> f64 {
        let [a, b, c, d] = [corners[0], corners[1], corners[2], point].map(|index| {
            let [x, y, z] = self.points[index].into();
            Coord3D { x, y, z }
        });
        -orient3d(a, b, c, d)
    }

    /// Assigns each point to the first facet, from index `start` on, that has it on its outer side. Points within the tolerance are
    /// dropped.
    fn assign(&mut self, points: Vec<usize>, start: usize) {
        let new = start..self.facets.len();
        for point in points {
            let outside = new.clone().find_map(|index| {
                let corners = self.facets[index].as_ref()?.corners;
                let height = self.height(corners, point);
                let [a, b, c] = corners.map(|corner| self.points[corner]);
                let distance = height / (b - a).cross(&(c - a)).norm();
                (height > 0.0 && distance > TOLERANCE).then_some((index, distance))
            });
            if let Some((index, distance)) = outside
                && let Some(facet) = &mut self.facets[index]
            {
                facet.outside.push((distance, point));
            }
        }
        self.waiting.extend(new);
    }

    /// Replaces the facets visible from a point. `facet` is one of them.
    fn extend(&mut self, facet: usize, point: usize) {
        let start = self.facets.len();
        let (horizon, orphans) = self.remove_visible(facet, point);
        let new = || (start..).zip(&horizon);
        let starting: FxHashMap<usize, usize> = new().map(|(k, (edge, _))| (edge[0], k)).collect();
        let ending: FxHashMap<usize, usize> = new().map(|(k, (edge, _))| (edge[1], k)).collect();
        let facet_of = |facets: &FxHashMap<usize, usize>, vertex: usize| {
            facets.get(&vertex).copied().unwrap_or_default()
        };
        for (index, &([from, to], beyond)) in new() {
            self.add(
                [from, to, point],
                [beyond, facet_of(&starting, to), facet_of(&ending, from)],
            );
            if let Some(beyond) = &mut self.facets[beyond] {
                let edge = beyond.corners.iter().position(|&corner| corner == to);
                beyond.neighbors[edge.unwrap_or_default()] = index;
            }
        }
        self.assign(orphans, start);
    }

    /// Removes the facets visible from a point. Returns the edges of the horizon with the facets beyond them, and the points that
    /// were outside the removed facets.
    fn remove_visible(
        &mut self,
        facet: usize,
        point: usize,
    ) -> (Vec<([usize; 2], usize)>, Vec<usize>) {
        let (mut horizon, mut orphans) = (Vec::new(), Vec::new());
        let mut visible = vec![facet];
        while let Some(facet) = visible.pop() {
            let Some(facet) = self.facets[facet].take() else {
                continue;
            };
            orphans.extend(facet.outside.iter().map(|&(_, orphan)| orphan));
            for (edge, neighbor) in facet.neighbors.into_iter().enumerate() {
                let Some(beyond) = &self.facets[neighbor] else {
                    continue;
                };
                if self.height(beyond.corners, point) > 0.0 {
                    visible.push(neighbor);
                } else {
                    let ends = [facet.corners[edge], facet.corners[(edge + 1) % 3]];
                    horizon.push((ends, neighbor));
                }
            }
        }
        orphans.retain(|&orphan| orphan != point);
        (horizon, orphans)
    }
}
