use nalgebra::Vector3;

/// A closed triangle, and what distances to it need.
#[derive(Debug, Clone)]
pub(crate) struct Triangle {
    corners: [Vector3<f64>; 3],
    /// Of length one. A flat triangle has none (NaN), and nothing lies above it.
    normal: Vector3<f64>,
}

impl Triangle {
    /// From three corners (m).
    pub fn new(corners: [Vector3<f64>; 3]) -> Self {
        let [a, b, c] = corners;
        // Of length one from the start: products of four lengths would leave the range of f64 long
        // before the lengths do.
        let normal = (b - a).normalize().cross(&(c - a).normalize()).normalize();
        Self { corners, normal }
    }

    /// The corners (m).
    pub fn corners(&self) -> &[Vector3<f64>; 3] {
        &self.corners
    }

    /// Distance (m) from a point to the plane of the triangle, which is no farther than the triangle; NaN for a flat one.
    pub fn distance_to_plane(&self, point: &Vector3<f64>) -> f64 {
        (point - self.corners[0]).dot(&self.normal).abs()
    }

    /// Distance (m) from a point.
    pub fn distance_to(&self, point: &Vector3<f64>) -> f64 {
        let [a, b, c] = &self.corners;
        let edges = [(a, b), (b, c), (c, a)];
        let is_left = |(from, to): &(&Vector3<f64>, &Vector3<f64>)| {
            (*to - *from).cross(&(point - *from)).dot(&self.normal) >= 0.0
        };
        if edges.iter().all(is_left) {
            return self.distance_to_plane(point);
        }
        let distances = edges.map(|(from, to)| distance_to_segment(point, from, to));
        distances.into_iter().fold(f64::INFINITY, f64::min)
    }
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
