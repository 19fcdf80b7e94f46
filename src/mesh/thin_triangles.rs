//! Removal of triangles without area. A closed surface stays closed.

use super::surface_faults::Fault;
use super::triangle_checks::is_thin;
use crate::geometry::Aabb;
use nalgebra::Vector3;
use rustc_hash::FxHashMap;

/// Limit of the number of splits for each thin triangle of the input.
const MAX_SPLIT_COUNT: usize = 16;

/// Limit of the heights of the thin triangles of the input, relative to the diagonal of the result. A spike of small width and very large
/// length exceeds it, because its triangles are thin although it is as wide as the rest of the surface.
const MAX_HEIGHT: f64 = 1e-6;

/// Replaces thin triangles. Their corners lie on a line, with one corner b between the others a and c. The triangle across the edge from
/// a to c is split at b, and the thin triangle is dropped.
///
/// Also returns the thin triangles that remain. They have no neighbor across their longest edge, or two corners at nearly the same
/// position. If the thin triangles of the input are too wide to be removed, all triangles stay.
pub(super) fn split(
    vertices: &[Vector3<f64>],
    triangles: Vec<[usize; 3]>,
) -> (Vec<[usize; 3]>, Option<Fault<3>>) {
    let corners = |triangle: &[usize; 3]| triangle.map(|vertex| vertices[vertex]);
    let thin: Vec<usize> = (0..triangles.len())
        .filter(|&index| is_thin(corners(&triangles[index])))
        .collect();
    if thin.is_empty() {
        return (triangles, None);
    }
    let thin_corners = || thin.iter().map(|&index| corners(&triangles[index]));
    let height = thin_corners().map(height).fold(0.0, f64::max);
    let fault = Fault::of(thin_corners());
    let mut splitting = Splitting::of(vertices, triangles.clone());
    splitting.run(thin);
    let rest: Vec<[usize; 3]> = splitting.triangles.into_iter().flatten().collect();
    let used = rest.as_flattened().iter().map(|&vertex| &vertices[vertex]);
    if !rest.is_empty() && height > MAX_HEIGHT * 2.0 * Aabb::around(used).half_extents().norm() {
        return (triangles, fault);
    }
    let triangles = rest;
    let remaining = triangles
        .iter()
        .map(corners)
        .filter(|corners| is_thin(*corners));
    let fault = Fault::of(remaining);
    (triangles, fault)
}

/// Returns the height (m) of a triangle over its longest edge.
fn height([a, b, c]: [Vector3<f64>; 3]) -> f64 {
    let longest_edge = (b - a).norm().max((c - b).norm()).max((a - c).norm());
    // The height of equal points is 0.
    (b - a).cross(&(c - a)).norm() / longest_edge.max(f64::MIN_POSITIVE)
}

struct Splitting<'v> {
    vertices: &'v [Vector3<f64>],
    /// Triangles. Removed triangles are `None`.
    triangles: Vec<Option<[usize; 3]>>,
    /// Triangles with an edge in this direction: those with an area, and thin ones. Some may have been removed.
    by_edge: FxHashMap<[usize; 2], [Vec<usize>; 2]>,
}

impl<'v> Splitting<'v> {
    fn of(vertices: &'v [Vector3<f64>], triangles: Vec<[usize; 3]>) -> Self {
        let mut splitting = Self {
            vertices,
            triangles: Vec::new(),
            by_edge: FxHashMap::default(),
        };
        for triangle in triangles {
            splitting.add(triangle);
        }
        splitting
    }

    fn add(&mut self, [a, b, c]: [usize; 3]) {
        let index = self.triangles.len();
        self.triangles.push(Some([a, b, c]));
        let kind = usize::from(self.is_thin(index));
        for edge in [[a, b], [b, c], [c, a]] {
            self.by_edge.entry(edge).or_default()[kind].push(index);
        }
    }

    /// Removes these thin triangles, and thin triangles that result from splits.
    fn run(&mut self, mut thin: Vec<usize>) {
        let mut splits_left = MAX_SPLIT_COUNT * thin.len();
        while let Some(index) = thin.pop()
            && splits_left > 0
        {
            splits_left -= 1;
            let before = self.triangles.len();
            self.remove(index);
            let added = before..self.triangles.len();
            thin.extend(added.filter(|&new| self.is_thin(new)));
        }
    }

    /// Removes a thin triangle if it has a neighbor across its longest edge.
    fn remove(&mut self, index: usize) {
        let Some(triangle) = self.triangles[index] else {
            return;
        };
        let [a, b, c] = self.longest_edge_last(triangle);
        let Some(beyond) = self.neighbor([a, c]) else {
            return;
        };
        let neighbor = self.triangles[beyond].take().unwrap_or_default();
        self.triangles[index] = None;
        let apex = neighbor.into_iter().find(|vertex| ![a, c].contains(vertex));
        let apex = apex.unwrap_or(b);
        if apex != b {
            self.add([a, b, apex]);
            self.add([b, c, apex]);
        }
    }

    /// Returns a triangle with this directed edge, preferably one with an area.
    fn neighbor(&mut self, edge: [usize; 2]) -> Option<usize> {
        let lists = self.by_edge.get_mut(&edge)?;
        lists.iter_mut().find_map(|list| {
            while let Some(&last) = list.last()
                && self.triangles[last].is_none()
            {
                list.pop();
            }
            list.last().copied()
        })
    }

    fn is_thin(&self, index: usize) -> bool {
        self.triangles[index].is_some_and(|corners| is_thin(corners.map(|v| self.vertices[v])))
    }

    /// Rotates the corners so that the longest edge runs from the last corner to the first.
    fn longest_edge_last(&self, [a, b, c]: [usize; 3]) -> [usize; 3] {
        let length = |[from, .., to]: [usize; 3]| (self.vertices[to] - self.vertices[from]).norm();
        let rotations = [[a, b, c], [b, c, a], [c, a, b]];
        let longest = { rotations }
            .into_iter()
            .max_by(|left, right| length(*left).total_cmp(&length(*right)));
        longest.unwrap_or([a, b, c])
    }
}
