//! Removal of triangles without area. A closed surface stays closed.

use super::surface_faults::Fault;
use super::triangle_checks::is_thin;
use nalgebra::Vector3;
use rustc_hash::FxHashMap;

/// Limit of the number of splits for each thin triangle of the input.
const MAX_SPLIT_COUNT: usize = 16;

/// Replaces thin triangles. Their corners lie on a line, with one corner b between the others a and c. The triangle across the edge from
/// a to c is split at b, and the thin triangle is dropped.
///
/// Also returns the thin triangles that remain. They have no neighbor across their longest edge, or two corners at nearly the same
/// position.
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
    let mut splitting = Splitting::of(vertices, triangles);
    splitting.run(thin);
    let triangles: Vec<[usize; 3]> = splitting.triangles.into_iter().flatten().collect();
    let remaining = triangles
        .iter()
        .map(corners)
        .filter(|corners| is_thin(*corners));
    let fault = Fault::of(remaining);
    (triangles, fault)
}

struct Splitting<'v> {
    vertices: &'v [Vector3<f64>],
    /// Triangles. Removed triangles are `None`.
    triangles: Vec<Option<[usize; 3]>>,
    /// Triangles with an edge in this direction. Some may have been removed.
    by_edge: FxHashMap<[usize; 2], Vec<usize>>,
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
        for edge in [[a, b], [b, c], [c, a]] {
            let triangles = self.by_edge.entry(edge).or_default();
            triangles.push(self.triangles.len());
        }
        self.triangles.push(Some([a, b, c]));
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
        let Some(beyond) = self.neighbor(index, [a, c]) else {
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

    /// Returns another triangle with this directed edge, preferably one with an area.
    fn neighbor(&self, index: usize, edge: [usize; 2]) -> Option<usize> {
        let candidates = self.by_edge.get(&edge)?.iter().copied();
        let present = candidates.filter(|&other| other != index && self.triangles[other].is_some());
        present.min_by_key(|&other| self.is_thin(other))
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
