//! Triangles and the vertices they share.

use super::SurfaceError;
use super::coordinates::first_non_finite;
use nalgebra::Vector3;
use std::collections::HashMap;

/// Vertices and triangles as indices of them.
pub(super) type Indexed = (Vec<Vector3<f64>>, Vec<[usize; 3]>);

/// Triangles whose corners at exactly the same place are one vertex, without those of which two corners are the same.
pub(super) fn welded(corners: &[[Vector3<f64>; 3]]) -> Result<Indexed, SurfaceError> {
    if let Some((vertex, value)) = first_non_finite(corners.iter().flatten()) {
        return Err(SurfaceError::NonFiniteCoordinate { vertex, value });
    }
    let mut vertices = Vec::new();
    let mut vertex_at = HashMap::new();
    let mut triangles = Vec::with_capacity(corners.len());
    for positions in corners {
        let indices = positions.map(|position| {
            *vertex_at.entry(place_key(&position)).or_insert_with(|| {
                vertices.push(position);
                vertices.len() - 1
            })
        });
        let [a, b, c] = indices;
        if a != b && b != c && c != a {
            triangles.push(indices);
        }
    }
    Ok(without_unused(vertices, &triangles))
}

/// A key that two points have in common if all their coordinates are equal, and only then.
pub(super) fn place_key(point: &Vector3<f64>) -> [u64; 3] {
    // −0 + 0 is 0: both zeros have the same bits.
    std::array::from_fn(|axis| (point[axis] + 0.0).to_bits())
}

/// Only the vertices that triangles use, in their order. All indices are in range.
pub(super) fn without_unused(vertices: Vec<Vector3<f64>>, triangles: &[[usize; 3]]) -> Indexed {
    let mut new_index = vec![None; vertices.len()];
    for &vertex in triangles.iter().flatten() {
        new_index[vertex] = Some(0);
    }
    let mut kept = Vec::with_capacity(vertices.len());
    for (position, index) in vertices.into_iter().zip(&mut new_index) {
        if let Some(index) = index {
            *index = kept.len();
            kept.push(position);
        }
    }
    let renumbered = |triangle: &[usize; 3]| triangle.map(|v| new_index[v].unwrap_or_default());
    let triangles = triangles.iter().map(renumbered).collect();
    (kept, triangles)
}
