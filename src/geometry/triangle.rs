use nalgebra::Vector3;

/// Distance (m) from a point to the closed triangle.
pub(crate) fn distance_to_triangle(point: &Vector3<f64>, triangle: &[Vector3<f64>; 3]) -> f64 {
    let [a, b, c] = triangle;
    // Of length one from the start: products of four lengths would leave the range of f64 long
    // before the lengths do. A flat triangle has no normal (NaN), and nothing lies above it.
    let normal = (b - a).normalize().cross(&(c - a).normalize()).normalize();
    let edges = [(a, b), (b, c), (c, a)];
    let above_all = edges
        .iter()
        .all(|(from, to)| (*to - *from).cross(&(point - *from)).dot(&normal) >= 0.0);
    if above_all {
        return (point - a).dot(&normal).abs();
    }
    edges
        .iter()
        .map(|(from, to)| distance_to_segment(point, from, to))
        .fold(f64::INFINITY, f64::min)
}

fn distance_to_segment(point: &Vector3<f64>, from: &Vector3<f64>, to: &Vector3<f64>) -> f64 {
    let (edge, along) = (to - from, point - from);
    let length_squared = edge.norm_squared();
    if length_squared == 0.0 {
        return along.norm();
    }
    let t = (along.dot(&edge) / length_squared).clamp(0.0, 1.0);
    (along - edge * t).norm()
}
