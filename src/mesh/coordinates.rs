//! What is asked of the coordinates of vertices, whatever they belong to.

use nalgebra::Vector3;

/// The first coordinate (m) that is NaN or infinite, after the index of its point.
pub(super) fn first_non_finite<'p>(
    points: impl IntoIterator<Item = &'p Vector3<f64>>,
) -> Option<(usize, f64)> {
    points.into_iter().enumerate().find_map(|(index, point)| {
        let value = point.iter().find(|value| !value.is_finite());
        value.map(|&value| (index, value))
    })
}

/// Largest distance (m) of a point from the origin; 0 of no points.
pub(super) fn reach(points: &[Vector3<f64>]) -> f64 {
    let distances = points.iter().map(nalgebra::Matrix::norm);
    distances.fold(0.0, f64::max)
}
