//! Merging of coincident vertices and removal of unused ones.

use nalgebra::Vector3;
use std::collections::HashMap;

/// Replaces each index by the first vertex with exactly the same position. All indices must be in range.
pub(super) fn merge_coincident(vertices: &[Vector3<f64>], triangles: &mut [[usize; 3]]) {
    let mut first_at_position = HashMap::new();
    let first_at = |(vertex, position): (usize, &Vector3<f64>)| {
        *first_at_position
            .entry(position_key(position))
            .or_insert(vertex)
    };
    let first: Vec<usize> = vertices.iter().enumerate().map(first_at).collect();
    for vertex in triangles.as_flattened_mut() {
        *vertex = first[*vertex];
    }
}

/// Returns a key that is equal for two points if and only if all their coordinates are equal.
pub(super) fn position_key(point: &Vector3<f64>) -> [u64; 3] {
    // Adding 0 maps −0 to +0, so that both zeros have the same bits.
    std::array::from_fn(|axis| (point[axis] + 0.0).to_bits())
}

/// The vertices that triangles use, in order, and the triangles with their new vertex indices.
pub(super) struct UsedVertices {
    pub vertices: Vec<Vector3<f64>>,
    pub triangles: Vec<[usize; 3]>,
    /// Index of each vertex in the input.
    pub original: Vec<usize>,
}

impl UsedVertices {
    /// Drops the vertices that no triangle uses. All indices must be in range.
    pub fn of(vertices: Vec<Vector3<f64>>, triangles: &[[usize; 3]]) -> Self {
        let mut new_index = vec![None; vertices.len()];
        for &vertex in triangles.as_flattened() {
            new_index[vertex] = Some(0);
        }
        let (mut kept, mut original) = (Vec::new(), Vec::new());
        for (vertex, position) in vertices.into_iter().enumerate() {
            if let Some(index) = &mut new_index[vertex] {
                *index = kept.len();
                kept.push(position);
                original.push(vertex);
            }
        }
        let renumbered = |triangle: &[usize; 3]| triangle.map(|v| new_index[v].unwrap_or_default());
        Self {
            vertices: kept,
            triangles: triangles.iter().map(renumbered).collect(),
            original,
        }
    }
}
