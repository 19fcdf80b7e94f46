//! Regions of space that tetrahedra can fill.

use super::winding::WindingNumbers;
use crate::bvh::Bvh;
use crate::geometry::{Aabb, Foot, Triangle};
use crate::mesh::surface_distance::nearest;
use crate::mesh::triangle_checks::is_thin;
use crate::parallel;
use nalgebra::Vector3;

/// Number of halvings of an edge that find where it leaves a region: the last one is below the rounding error.
const HALVINGS: usize = 52;

/// Number of halvings of an edge that leaves a region through a hole, whose place has no derivative.
const HALVINGS_IN_HOLES: usize = 24;

/// Smallest difference of two places of an edge, relative to its length, that are not the same.
const SAME_PLACE: f64 = 1e-9;

/// Winding number above which a point is inside.
const INSIDE: f64 = 0.5;

/// Difference from an integer up to which a winding number counts as an integer. This tolerance exceeds the error of the dipole
/// approximation. Far from holes, winding numbers are integers.
const NEARLY_WHOLE: f64 = 0.1;

/// Cosine of the angle between two normals above which the triangles are in one plane.
pub(super) const SAME_PLANE: f64 = 1.0 - 1e-12;

/// The solid inside a closed boundary. Queries are answered for many points at once, in threads.
pub(super) trait Region: Sync {
    /// Returns the box (m) outside of which there is nothing of the region.
    fn bounds(&self) -> Aabb;

    /// Returns lower bounds of the distances (m) of the points to the boundary.
    fn clearances(&self, points: &[Vector3<f64>]) -> Vec<f64>;

    /// Returns which points are inside. Points beyond the bounds are never inside.
    fn contains(&self, points: &[Vector3<f64>]) -> Vec<bool>;

    /// Returns for each center whether the ball of this radius (m) is inside. Returns `None` for a ball that the boundary may cross.
    fn balls_inside(&self, centers: &[Vector3<f64>], radius: f64) -> Vec<Option<bool>> {
        let clearances = self.clearances(centers);
        let clear: Vec<usize> = (0..centers.len())
            .filter(|&ball| clearances[ball] > radius)
            .collect();
        let clear_centers: Vec<_> = clear.iter().map(|&ball| centers[ball]).collect();
        let mut are_inside = vec![None; centers.len()];
        for (ball, is_inside) in clear.into_iter().zip(self.contains(&clear_centers)) {
            are_inside[ball] = Some(is_inside);
        }
        are_inside
    }

    /// Returns where segments from a point inside to a point outside leave the region.
    fn crossings(&self, segments: &[Segment]) -> Vec<Crossing> {
        halved(segments, HALVINGS, |points| self.contains(points))
    }
}

/// A segment from a point inside a region to a point outside (m).
pub(super) type Segment = [Vector3<f64>; 2];

/// The place at which a segment leaves a region.
#[derive(Debug, Clone, Copy)]
pub(super) struct Crossing {
    /// Position along the segment, from 0 inside to 1 outside.
    pub share: f64,
    /// The triangle that the segment crosses, and the barycentric coordinates of the place. There is none if the boundary has no
    /// triangles, or if the segment leaves through a hole.
    pub triangle: Option<(usize, [f64; 3])>,
    /// Unit normal of the triangle, or zero if there is none.
    pub normal: Vector3<f64>,
    /// Whether the place is on an edge between triangles that are not in one plane.
    pub is_at_tie: bool,
}

/// Returns where the segments leave a region, by halving.
fn halved(
    segments: &[Segment],
    count: usize,
    contains: impl Fn(&[Vector3<f64>]) -> Vec<bool>,
) -> Vec<Crossing> {
    let mut ranges = vec![[0.0, 1.0]; segments.len()];
    for _ in 0..count {
        let middles = segments.iter().zip(&ranges);
        let middles: Vec<_> = middles
            .map(|([from, to], [a, b])| from.lerp(to, f64::midpoint(*a, *b)))
            .collect();
        for (range, is_inside) in ranges.iter_mut().zip(contains(&middles)) {
            let middle = f64::midpoint(range[0], range[1]);
            range[usize::from(!is_inside)] = middle;
        }
    }
    let crossing = |[from, to]: [f64; 2]| Crossing {
        share: f64::midpoint(from, to),
        triangle: None,
        normal: Vector3::zeros(),
        is_at_tie: false,
    };
    ranges.into_iter().map(crossing).collect()
}

/// Returns a lower bound of the distance (m) from a point to a box. For a point inside, returns the negative distance to the nearest face.
fn signed_box_distance(bounds: &Aabb, point: &Vector3<f64>) -> f64 {
    (bounds.lower - point).sup(&(point - bounds.upper)).max()
}

/// The region inside triangles: the points around which they wind, in either direction. Overlapping parts are united.
pub(super) struct InsideTriangles {
    triangles: Vec<Triangle>,
    /// Bounds of all triangles, including degenerate ones.
    bounds: Aabb,
    bvh: Bvh<usize>,
    winding: WindingNumbers,
}

impl InsideTriangles {
    /// Prepares the queries in O(n log n) time. There must be a triangle with an area. Triangles without an area only extend the
    /// bounds, because their winding numbers at points on them are rounding errors.
    pub fn new(corners: impl Iterator<Item = [Vector3<f64>; 3]>) -> Self {
        let triangles: Vec<_> = corners.map(Triangle::new).collect();
        let corners = triangles.iter().map(|triangle| *triangle.corners());
        let bounds = Aabb::around(triangles.iter().flat_map(Triangle::corners));
        let with_area = corners
            .enumerate()
            .filter(|(_, corners)| !is_thin(*corners));
        let bvh = Bvh::new(with_area);
        Self {
            winding: WindingNumbers::of(&bvh, &triangles),
            triangles,
            bounds,
            bvh,
        }
    }

    fn nearest_triangle(&self, point: &Vector3<f64>) -> (usize, f64) {
        nearest(point, &self.bvh, |triangle| &self.triangles[triangle])
    }

    /// Returns the triangle closest to a point, its distance (m) and its closest point.
    pub fn nearest(&self, point: &Vector3<f64>) -> (usize, f64, Foot) {
        let (triangle, distance) = self.nearest_triangle(point);
        (triangle, distance, self.triangles[triangle].foot_of(point))
    }

    /// Returns the normal of a triangle. It is NaN for a degenerate triangle.
    pub fn normal(&self, triangle: usize) -> &Vector3<f64> {
        self.triangles[triangle].normal()
    }

    /// Returns the absolute value of the winding number around a point.
    fn winding_number(&self, point: &Vector3<f64>) -> f64 {
        self.winding.at(point, &self.bvh, &self.triangles).abs()
    }

    /// Returns a lower bound of the distance (m) from a point to the triangles with an area and to the bounds.
    fn clearance(&self, point: &Vector3<f64>) -> f64 {
        let distance = self.nearest_triangle(point).1;
        distance.min(signed_box_distance(&self.bounds, point).abs())
    }

    /// Returns whether a point is inside. Points beyond the bounds of the triangles are outside. Their winding number is not used, because
    /// it can exceed [`INSIDE`] if the triangles have holes.
    fn contains(&self, point: &Vector3<f64>) -> bool {
        signed_box_distance(&self.bounds, point) <= 0.0 && self.winding_number(point) >= INSIDE
    }

    /// Returns where a segment leaves the region through a triangle, if it does.
    fn crossing(&self, segment: &Segment) -> Option<Crossing> {
        let mut hits = Vec::new();
        self.bvh.visit_overlapping(&Aabb::around(segment), |index| {
            if let Some((share, shares)) = self.triangles[index].hit_by(segment) {
                hits.push((share, index, shares));
            }
        });
        hits.sort_by(|a, b| {
            (a.0, a.1)
                .partial_cmp(&(b.0, b.1))
                .unwrap_or(std::cmp::Ordering::Equal)
        });
        let all = hits.clone();
        hits.dedup_by(|next, hit| next.0 - hit.0 < SAME_PLACE);
        let [from, to] = segment;
        let leaves = |index: usize| match hits.get(index + 1) {
            None => true,
            Some(next) => !self.contains(&from.lerp(to, f64::midpoint(hits[index].0, next.0))),
        };
        let index = (0..hits.len()).find(|&index| leaves(index))?;
        let (share, triangle, shares) = hits[index];
        let normal = *self.normal(triangle);
        let is_same_place = |hit: f64| (hit - share).abs() < SAME_PLACE;
        let is_rival = |other: usize| self.normal(other).dot(&normal) < SAME_PLANE;
        Some(Crossing {
            share,
            triangle: Some((triangle, shares)),
            normal,
            is_at_tie: all
                .iter()
                .any(|&(hit, other, _)| is_same_place(hit) && is_rival(other)),
        })
    }
}

impl Region for InsideTriangles {
    fn bounds(&self) -> Aabb {
        self.bounds
    }

    fn clearances(&self, points: &[Vector3<f64>]) -> Vec<f64> {
        parallel::map(points, |point| self.clearance(point))
    }

    fn contains(&self, points: &[Vector3<f64>]) -> Vec<bool> {
        parallel::values_of(points.len(), |index| self.contains(&points[index]))
    }

    /// Also returns `None` if the winding number is not close to an integer. If the triangles have holes, the winding number varies away from
    /// the triangles, also inside of a ball.
    fn balls_inside(&self, centers: &[Vector3<f64>], radius: f64) -> Vec<Option<bool>> {
        parallel::map(centers, |center| {
            if self.clearance(center) <= radius {
                return None;
            }
            let winding_number = self.winding_number(center);
            let is_whole = (winding_number - winding_number.round()).abs() < NEARLY_WHOLE;
            let is_within = signed_box_distance(&self.bounds, center) <= 0.0;
            is_whole.then_some(is_within && winding_number >= INSIDE)
        })
    }

    fn crossings(&self, segments: &[Segment]) -> Vec<Crossing> {
        let contains = |points: &[Vector3<f64>]| Region::contains(self, points);
        parallel::values_of(segments.len(), |index| {
            let crossing = self.crossing(&segments[index]);
            crossing
                .unwrap_or_else(|| halved(&segments[index..=index], HALVINGS_IN_HOLES, contains)[0])
        })
    }
}

/// The region in a box in which a function is negative. The function is a lower bound of the distance (m) to the boundary in absolute
/// value.
pub(super) struct WhereNegative<F> {
    pub bounds: Aabb,
    pub distances: F,
}

impl<F: Fn(&[Vector3<f64>]) -> Vec<f64> + Sync> Region for WhereNegative<F> {
    fn bounds(&self) -> Aabb {
        self.bounds
    }

    fn clearances(&self, points: &[Vector3<f64>]) -> Vec<f64> {
        let distances = points.iter().zip((self.distances)(points));
        distances
            .map(|(point, distance)| distance.max(signed_box_distance(&self.bounds, point)).abs())
            .collect()
    }

    fn contains(&self, points: &[Vector3<f64>]) -> Vec<bool> {
        let distances = points.iter().zip((self.distances)(points));
        distances
            .map(|(point, distance)| {
                distance < 0.0 && signed_box_distance(&self.bounds, point) <= 0.0
            })
            .collect()
    }
}
