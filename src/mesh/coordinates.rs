//! Checks and bounds on vertex coordinates, shared by all meshes.

use nalgebra::Vector3;

/// Returns the first NaN or infinite coordinate (m), preceded by the index of its point.
pub(super) fn first_non_finite<'p>(
    points: impl IntoIterator<Item = &'p Vector3<f64>>,
) -> Option<(usize, f64)> {
    points.into_iter().enumerate().find_map(|(index, point)| {
        let value = point.iter().find(|value| !value.is_finite());
        value.map(|&value| (index, value))
    })
}

/// Returns the largest distance (m) of a point from the origin, or 0 if there are no points.
pub(super) fn reach(points: &[Vector3<f64>]) -> f64 {
    let distances = points.iter().map(nalgebra::Matrix::norm);
    distances.fold(0.0, f64::max)
}
