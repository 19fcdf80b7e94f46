//! Triangles and the vertices they share.

use super::SurfaceError;
use nalgebra::Vector3;
use std::collections::HashMap;

/// Vertices and triangles as indices of them.
pub(super) type Indexed = (Vec<Vector3<f64>>, Vec<[usize; 3]>);

/// Triangles whose corners at exactly the same place are one vertex, without those of which two corners are the same.
pub(super) fn welded(corners: &[[Vector3<f64>; 3]]) -> Result<Indexed, SurfaceError> {
    let mut vertices = Vec::new();
    let mut vertex_at = HashMap::new();
    let mut triangles = Vec::with_capacity(corners.len());
    for (triangle, positions) in corners.iter().enumerate() {
        let mut indices = [0; 3];
        for (corner, position) in positions.iter().enumerate() {
            if let Some(&value) = position.iter().find(|value| !value.is_finite()) {
                let vertex = 3 * triangle + corner;
                return Err(SurfaceError::NonFiniteCoordinate { vertex, value });
            }
            indices[corner] = *vertex_at.entry(place_key(position)).or_insert_with(|| {
                vertices.push(*position);
                vertices.len() - 1
            });
        }
        let [a, b, c] = indices;
        if a != b && b != c && c != a {
            triangles.push(indices);
        }
    }
    Ok(without_unused(&vertices, &triangles))
}

/// The same for points at the same place, and no others.
pub(super) fn place_key(point: &Vector3<f64>) -> [u64; 3] {
    // Adding 0 makes one number of the two zeros.
    std::array::from_fn(|axis| (point[axis] + 0.0).to_bits())
}

/// Only the vertices that triangles use, in their order. All indices are in range.
pub(super) fn without_unused(vertices: &[Vector3<f64>], triangles: &[[usize; 3]]) -> Indexed {
    let mut new_index = vec![None; vertices.len()];
    for &vertex in triangles.iter().flatten() {
        new_index[vertex] = Some(0);
    }
    let mut kept = Vec::with_capacity(vertices.len());
    for (position, index) in vertices.iter().zip(&mut new_index) {
        if let Some(index) = index {
            *index = kept.len();
            kept.push(*position);
        }
    }
    let renumbered = |triangle: &[usize; 3]| triangle.map(|v| new_index[v].unwrap_or_default());
    let triangles = triangles.iter().map(renumbered).collect();
    (kept, triangles)
}
