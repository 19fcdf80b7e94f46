use nalgebra::Vector3;

/// A closed triangle, and what distances to it need.
#[derive(Debug, Clone)]
pub(crate) struct Triangle {
    corners: [Vector3<f64>; 3],
    /// Of length one. A flat triangle has none (NaN), and nothing lies above it.
    normal: Vector3<f64>,
}

/// The point of a triangle that is nearest to another point.
pub(crate) struct Foot {
    /// Its barycentric coordinates.
    pub shares: [f64; 3],
    /// From there to the point, of length one; 0 where the point lies on the triangle.
    pub direction: Vector3<f64>,
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
        if self.areas(point).iter().all(|&area| area >= 0.0) {
            return self.distance_to_plane(point);
        }
        let distances = self
            .edges()
            .map(|(from, to)| distance_to_segment(point, from, to));
        distances.into_iter().fold(f64::INFINITY, f64::min)
    }

    /// The point of the triangle that is nearest to a point.
    pub fn foot_of(&self, point: &Vector3<f64>) -> Foot {
        let areas = self.areas(point);
        if areas.iter().all(|&area| area >= 0.0) {
            let sum: f64 = areas.iter().sum();
            let height = (point - self.corners[0]).dot(&self.normal);
            return Foot {
                // The first edge ends where the third corner is not.
                shares: [areas[1], areas[2], areas[0]].map(|area| area / sum),
                direction: self.normal * direction_of(height),
            };
        }
        let distances = self
            .edges()
            .map(|(from, to)| distance_to_segment(point, from, to));
        let nearest = (0..3).min_by(|&i, &j| distances[i].total_cmp(&distances[j]));
        let from = nearest.unwrap_or_default();
        let to = (from + 1) % 3;
        let share = share_of_segment(point, &self.corners[from], &self.corners[to]);
        let mut shares = [0.0; 3];
        (shares[from], shares[to]) = (1.0 - share, share);
        let foot = self.corners[from] + (self.corners[to] - self.corners[from]) * share;
        let direction = (point - foot).try_normalize(0.0);
        Foot {
            shares,
            direction: direction.unwrap_or_default(),
        }
    }

    fn edges(&self) -> [(&Vector3<f64>, &Vector3<f64>); 3] {
        let [a, b, c] = &self.corners;
        [(a, b), (b, c), (c, a)]
    }

    /// Twice the areas (m²) between each edge and the projection of a point to the plane: positive on the inner side.
    fn areas(&self, point: &Vector3<f64>) -> [f64; 3] {
        self.edges()
            .map(|(from, to)| (to - from).cross(&(point - from)).dot(&self.normal))
    }
}

/// A sign, and 0 of 0.
fn direction_of(height: f64) -> f64 {
    if height == 0.0 { 0.0 } else { height.signum() }
}

fn distance_to_segment(point: &Vector3<f64>, from: &Vector3<f64>, to: &Vector3<f64>) -> f64 {
    let share = share_of_segment(point, from, to);
    ((point - from) - (to - from) * share).norm()
}

/// How far along a segment, from 0 to 1, its nearest point lies.
fn share_of_segment(point: &Vector3<f64>, from: &Vector3<f64>, to: &Vector3<f64>) -> f64 {
    let (edge, along) = (to - from, point - from);
    let length_squared = edge.norm_squared();
    if length_squared == 0.0 {
        return 0.0;
    }
    (along.dot(&edge) / length_squared).clamp(0.0, 1.0)
}
