//! Merging of vertices, and removal of the vertices that are then unused and the triangles that then cancel.

use super::SurfaceWarning;
use nalgebra::Vector3;
use rustc_hash::FxHashMap;

/// Positions of vertices (m), and vertex indices of triangles.
pub(super) type Triangles = (Vec<Vector3<f64>>, Vec<[usize; 3]>);

/// Size of the cells of the grid, relative to the tolerance. It exceeds the size of the searched box, which thus overlaps at most 8 cells.
const CELL_SIZE: f64 = 4.0;

/// Half the size of the searched box, relative to the tolerance. The excess covers rounding errors.
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

    /// Connects all pairs of vertices within the tolerance (m). A grid limits the search to the cells that overlap a box around the
    /// vertex, so that the result does not depend on the borders of cells.
    fn connect(&mut self, positions: &[Vector3<f64>], tolerance: f64) {
        let cell_of = |position: Vector3<f64>| (position / (CELL_SIZE * tolerance)).map(f64::floor);
        let mut cells: FxHashMap<[u64; 3], Vec<usize>> = FxHashMap::default();
        for vertex in self.vertices.clone() {
            let position = positions[vertex];
            let [lower, upper] =
                [-SEARCH, SEARCH].map(|step| cell_of(position.add_scalar(step * tolerance)));
            let is_upper = |corner: u8, axis: usize| corner >> axis & 1 == 1;
            let is_new = |&corner: &u8| (0..3).all(|k| !is_upper(corner, k) || lower[k] < upper[k]);
            for corner in (0..8).filter(is_new) {
                let side =
                    |axis: usize, _| if is_upper(corner, axis) { upper } else { lower }[axis];
                let near = cells.get(&position_key(&Vector3::from_fn(side)));
                for &other in near.into_iter().flatten() {
                    if (position - positions[other]).norm() <= tolerance {
                        let roots = [vertex, other].map(|v| self.first_of(v));
                        self.parents
                            .insert(roots[0].max(roots[1]), roots[0].min(roots[1]));
                    }
                }
            }
            let cell = position_key(&cell_of(position));
            cells.entry(cell).or_default().push(vertex);
        }
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
