//! Merging of vertices, and removal of the vertices that are then unused and the triangles that then cancel.

use super::SurfaceWarning;
use crate::geometry::Aabb;
use nalgebra::Vector3;
use rustc_hash::{FxHashMap, FxHashSet};
use std::collections::BTreeMap;

/// Positions of vertices (m), and vertex indices of triangles.
pub(super) type Triangles = (Vec<Vector3<f64>>, Vec<[usize; 3]>);

/// Number of small cells along an axis for each tolerance. It exceeds √3, so that the vertices of a small cell are within the tolerance.
const CELLS_PER_TOLERANCE: f64 = 1.74;

/// Number of a small cell up to which the rounding error of the number is negligible.
const MAX_CELL: f64 = (1_u64 << 40) as f64;

/// Size of a large cell, relative to the tolerance. It exceeds the size of the searched box, which thus overlaps at most 8 large cells.
const LARGE_CELL_SIZE: f64 = 4.0;

/// Distance of the search around the vertices of a small cell, relative to the tolerance. The excess covers rounding errors.
const SEARCH: f64 = 1.01;

/// Triangles with merged vertices.
pub(super) struct Welded {
    pub triangles: Triangles,
    /// Report on the vertices that moved.
    pub warning: Option<SurfaceWarning>,
}

/// Merges vertices within a tolerance (m), as [`TriangleSoup::welded`](super::TriangleSoup::welded) does. All indices must be in range,
/// and all used vertices finite.
pub(super) fn welded(
    vertices: &[Vector3<f64>],
    triangles: &[[usize; 3]],
    tolerance: f64,
) -> Welded {
    let mut first = first_at_positions(vertices);
    let mut warning = None;
    if tolerance > 0.0 {
        let mut used: Vec<usize> = triangles.as_flattened().to_vec();
        for vertex in &mut used {
            *vertex = first[*vertex];
        }
        used.sort_unstable();
        used.dedup();
        let mut sets = DisjointSets::of(&used);
        sets.connect(vertices, tolerance);
        warning = sets.moved(vertices);
        for vertex in &mut first {
            *vertex = sets.first_of(*vertex);
        }
    }
    let merged = triangles.iter().map(|corners| corners.map(|v| first[v]));
    let has_three_corners = |&[a, b, c]: &[usize; 3]| a != b && b != c && c != a;
    let triangles = without_opposites(merged.filter(has_three_corners).collect());
    Welded {
        triangles: without_unused(vertices.to_vec(), &triangles),
        warning,
    }
}

/// Returns the first vertex with exactly the same position as each vertex.
fn first_at_positions(vertices: &[Vector3<f64>]) -> Vec<usize> {
    let mut first_at_position = FxHashMap::default();
    let first_at = |(vertex, position): (usize, &Vector3<f64>)| {
        *first_at_position
            .entry(position_key(position))
            .or_insert(vertex)
    };
    vertices.iter().enumerate().map(first_at).collect()
}

/// Returns a key that is equal for two points if and only if all their coordinates are equal.
pub(super) fn position_key(point: &Vector3<f64>) -> [u64; 3] {
    // Adding 0 maps −0 to +0, so that both zeros have the same bits.
    std::array::from_fn(|axis| (point[axis] + 0.0).to_bits())
}

/// Disjoint sets of vertices. Each set is a tree whose root is its lowest vertex.
struct DisjointSets {
    /// Next vertex on the path to the root. The root is its own parent.
    parents: FxHashMap<usize, usize>,
    vertices: Vec<usize>,
}

impl DisjointSets {
    fn of(vertices: &[usize]) -> Self {
        Self {
            parents: vertices.iter().map(|&vertex| (vertex, vertex)).collect(),
            vertices: vertices.to_vec(),
        }
    }

    /// Returns the first vertex of the set of a vertex, or the vertex itself if it is in no set.
    fn first_of(&mut self, mut vertex: usize) -> usize {
        while let Some(&parent) = self.parents.get(&vertex)
            && parent != vertex
        {
            let next = self.parents.get(&parent).copied().unwrap_or(parent);
            self.parents.insert(vertex, next);
            vertex = next;
        }
        vertex
    }

    /// Connects all pairs of vertices within the tolerance (m).
    ///
    /// The vertices of a small cell are connected without a test. A grid of large cells limits the search for other small cells nearby,
    /// so that the time does not depend on the number of vertices in a cell.
    fn connect(&mut self, positions: &[Vector3<f64>], tolerance: f64) {
        let origin = Aabb::around(self.vertices.iter().map(|&v| &positions[v])).lower;
        let mut groups = self.connect_small_cells(positions, (origin, tolerance));
        if tolerance == 0.0 {
            return;
        }
        let large_cells = |aabb: &Aabb| {
            let [lower, upper] = [aabb.lower, aabb.upper]
                .map(|corner| ((corner - origin) / (LARGE_CELL_SIZE * tolerance)).map(f64::floor));
            let is_upper = |corner: u8, axis: usize| corner >> axis & 1 == 1;
            let is_new =
                move |&corner: &u8| (0..3).all(|k| !is_upper(corner, k) || lower[k] < upper[k]);
            let side =
                move |corner: u8, axis| if is_upper(corner, axis) { upper } else { lower }[axis];
            (0..8)
                .filter(is_new)
                .map(move |corner| position_key(&Vector3::from_fn(|axis, _| side(corner, axis))))
        };
        let mut cells: FxHashMap<[u64; 3], Vec<usize>> = FxHashMap::default();
        for index in 0..groups.len() {
            let aabb = Aabb::around(&groups[index].points);
            for cell in large_cells(&aabb.inflated(SEARCH * tolerance)) {
                for &other in cells.get(&cell).into_iter().flatten() {
                    self.connect_groups(&mut groups, [index, other], tolerance);
                }
            }
            for cell in large_cells(&aabb) {
                cells.entry(cell).or_default().push(index);
            }
        }
    }

    /// Connects the vertices of each small cell. If a cell has too large a number, its vertices are connected only at equal positions.
    fn connect_small_cells(
        &mut self,
        positions: &[Vector3<f64>],
        (origin, tolerance): (Vector3<f64>, f64),
    ) -> Vec<Group> {
        let mut groups: Vec<Group> = Vec::new();
        let mut by_cell = FxHashMap::default();
        for vertex in self.vertices.clone() {
            let position = positions[vertex];
            let offset = position - origin;
            let cell = (offset * CELLS_PER_TOLERANCE / tolerance).map(f64::floor);
            let is_cell = cell.iter().all(|number| *number < MAX_CELL);
            let key = (
                is_cell,
                position_key(if is_cell { &cell } else { &position }),
            );
            let group = *by_cell.entry(key).or_insert(groups.len());
            match groups.get_mut(group) {
                Some(group) => {
                    group.points.push(position);
                    self.union([group.vertex, vertex]);
                }
                None => groups.push(Group {
                    vertex,
                    points: vec![position],
                }),
            }
        }
        groups
    }

    /// Connects two groups if a vertex of one is within the tolerance (m) of a vertex of the other.
    fn connect_groups(&mut self, groups: &mut [Group], pair: [usize; 2], tolerance: f64) {
        let Ok([a, b]) = groups.get_disjoint_mut(pair) else {
            return;
        };
        if self.first_of(a.vertex) != self.first_of(b.vertex)
            && are_near(&mut a.points, &mut b.points, tolerance)
        {
            self.union([a.vertex, b.vertex]);
        }
    }

    fn union(&mut self, vertices: [usize; 2]) {
        let [a, b] = vertices.map(|vertex| self.first_of(vertex));
        self.parents.insert(a.max(b), a.min(b));
    }

    /// Reports the number of vertices that are not the first of their set, and their largest distance (m) from the first.
    fn moved(&mut self, positions: &[Vector3<f64>]) -> Option<SurfaceWarning> {
        let (mut vertex_count, mut distance) = (0, 0.0_f64);
        for vertex in self.vertices.clone() {
            let first = self.first_of(vertex);
            if first != vertex {
                vertex_count += 1;
                distance = distance.max((positions[vertex] - positions[first]).norm());
            }
        }
        (vertex_count > 0).then_some(SurfaceWarning::Welded {
            vertex_count,
            distance,
        })
    }
}

/// The vertices of a small cell.
struct Group {
    /// One of the vertices.
    vertex: usize,
    /// Positions (m) of the vertices.
    points: Vec<Vector3<f64>>,
}

/// Returns true if a point of one list is within a distance (m) of a point of the other list. Neither list may be empty.
///
/// The longer list is halved until the boxes around the lists are too far from each other.
fn are_near(a: &mut [Vector3<f64>], b: &mut [Vector3<f64>], distance: f64) -> bool {
    if (a[0] - b[0]).norm() <= distance {
        return true;
    }
    let [box_a, box_b] = [&*a, &*b].map(Aabb::around);
    let gap = (box_a.lower - box_b.upper).sup(&(box_b.lower - box_a.upper));
    if a.len() + b.len() == 2 || gap.sup(&Vector3::zeros()).norm() > SEARCH * distance {
        return false;
    }
    let (longer, shorter, aabb) = if a.len() < b.len() {
        (b, a, box_b)
    } else {
        (a, b, box_a)
    };
    let (axis, middle) = (aabb.half_extents().imax(), longer.len() / 2);
    longer.select_nth_unstable_by(middle, |p, q| p[axis].total_cmp(&q[axis]));
    let (lower, upper) = longer.split_at_mut(middle);
    are_near(lower, shorter, distance) || are_near(upper, shorter, distance)
}

/// Returns the first vertex of the chain of each vertex, as [`TriangleSoup::welded`](super::TriangleSoup::welded) merges them within a
/// tolerance (m). Vertices that are not listed are returned unchanged. All positions must be finite.
#[cfg(feature = "files")]
pub(crate) fn first_in_chain(
    positions: &[Vector3<f64>],
    vertices: &[usize],
    tolerance: f64,
) -> Vec<usize> {
    let mut sets = DisjointSets::of(vertices);
    sets.connect(positions, tolerance);
    (0..positions.len())
        .map(|vertex| sets.first_of(vertex))
        .collect()
}

/// Groups triangles that are connected by common vertices. Groups are in the order of their smallest vertex index.
pub(super) fn connected(triangles: &[[usize; 3]]) -> Vec<Vec<[usize; 3]>> {
    let mut sets = DisjointSets::of(triangles.as_flattened());
    for &[a, b, c] in triangles {
        sets.union([a, b]);
        sets.union([b, c]);
    }
    let mut groups: BTreeMap<usize, Vec<[usize; 3]>> = BTreeMap::new();
    for triangle in triangles {
        groups
            .entry(sets.first_of(triangle[0]))
            .or_default()
            .push(*triangle);
    }
    groups.into_values().collect()
}

/// Splits triangles into those that come first with their corners and orientation, and those that repeat them.
pub(super) fn without_repeats(triangles: &[[usize; 3]]) -> [Vec<[usize; 3]>; 2] {
    let mut present = FxHashSet::default();
    let is_first = |triangle: &[usize; 3]| {
        let mut rotated = *triangle;
        let lowest = (0..3).min_by_key(|&corner| triangle[corner]);
        rotated.rotate_left(lowest.unwrap_or(0));
        present.insert(rotated)
    };
    let (first, repeats) = triangles.iter().copied().partition(is_first);
    [first, repeats]
}

/// Drops pairs of triangles with the same corners and opposite orientations.
fn without_opposites(triangles: Vec<[usize; 3]>) -> Vec<[usize; 3]> {
    let mut counts: FxHashMap<[usize; 3], [u32; 2]> = FxHashMap::default();
    let key = |&[a, b, c]: &[usize; 3]| {
        let mut sorted = [a, b, c];
        sorted.sort_unstable();
        let is_even = [[a, b, c], [b, c, a], [c, a, b]].contains(&sorted);
        (sorted, usize::from(is_even))
    };
    for triangle in &triangles {
        let (sorted, side) = key(triangle);
        counts.entry(sorted).or_default()[side] += 1;
    }
    if counts.len() == triangles.len() {
        return triangles;
    }
    for [odd, even] in counts.values_mut() {
        let pairs = *odd.min(even);
        (*odd, *even) = (pairs, pairs);
    }
    let mut dropped = counts;
    let is_kept = |triangle: &[usize; 3]| {
        let (sorted, side) = key(triangle);
        let left = dropped.get_mut(&sorted).map(|counts| &mut counts[side]);
        left.is_none_or(|left| std::mem::replace(left, left.saturating_sub(1)) == 0)
    };
    let mut triangles = triangles;
    triangles.retain(is_kept);
    triangles
}

/// Drops the vertices that no triangle uses. All indices must be in range.
pub(super) fn without_unused(vertices: Vec<Vector3<f64>>, triangles: &[[usize; 3]]) -> Triangles {
    let mut new_index = vec![None; vertices.len()];
    for &vertex in triangles.as_flattened() {
        new_index[vertex] = Some(0);
    }
    let mut kept = Vec::new();
    for (vertex, position) in vertices.into_iter().enumerate() {
        if let Some(index) = &mut new_index[vertex] {
            *index = kept.len();
            kept.push(position);
        }
    }
    let renumbered = |triangle: &[usize; 3]| triangle.map(|v| new_index[v].unwrap_or_default());
    (kept, triangles.iter().map(renumbered).collect())
}
