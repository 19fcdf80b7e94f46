use nalgebra::Vector3;

/// Distance by which a segment may miss a triangle and still count as a crossing, over the size of the triangle.
const EDGE_OVERLAP: f64 = 1e-10;

/// A closed triangle, with the data needed to compute distances to it.
#[derive(Debug, Clone)]
pub(crate) struct Triangle {
    corners: [Vector3<f64>; 3],
    /// Unit normal. It is NaN for a degenerate triangle, so that no point projects to the interior.
    normal: Vector3<f64>,
}

/// Closest point of a triangle to a query point.
pub(crate) struct Foot {
    /// Barycentric coordinates of the closest point.
    pub shares: [f64; 3],
    /// Unit vector from the closest point to the query point. It is zero if the query point lies on
    /// the triangle.
    pub direction: Vector3<f64>,
}

impl Triangle {
    /// Creates a triangle from three corners (m).
    pub fn new(corners: [Vector3<f64>; 3]) -> Self {
        let [a, b, c] = corners;
        // Normalize the edges first. A product of four lengths would overflow or underflow long
        // before a length does.
        let normal = (b - a).normalize().cross(&(c - a).normalize()).normalize();
        Self { corners, normal }
    }

    /// Returns the corners (m).
    pub fn corners(&self) -> &[Vector3<f64>; 3] {
        &self.corners
    }

    /// Returns the unit normal. It is NaN for a degenerate triangle.
    pub fn normal(&self) -> &Vector3<f64> {
        &self.normal
    }

    /// Returns the barycentric coordinates of the projection of a point to the plane.
    pub fn shares_of(&self, point: &Vector3<f64>) -> [f64; 3] {
        shares(self.areas(point))
    }

    /// Returns the distance (m) from a point to the plane of the triangle. It is a lower bound of
    /// the distance to the triangle. It is NaN for a degenerate triangle.
    pub fn distance_to_plane(&self, point: &Vector3<f64>) -> f64 {
        (point - self.corners[0]).dot(&self.normal).abs()
    }

    /// Returns the distance (m) from a point to the triangle.
    pub fn distance_to(&self, point: &Vector3<f64>) -> f64 {
        if self.areas(point).iter().all(|&area| area >= 0.0) {
            return self.distance_to_plane(point);
        }
        let distances = self
            .edges()
            .map(|(from, to)| distance_to_segment(point, from, to));
        distances.into_iter().fold(f64::INFINITY, f64::min)
    }

    /// Returns the point of the triangle that is closest to a query point.
    pub fn foot_of(&self, point: &Vector3<f64>) -> Foot {
        let areas = self.areas(point);
        if areas.iter().all(|&area| area >= 0.0) {
            let height = (point - self.corners[0]).dot(&self.normal);
            return Foot {
                shares: shares(areas),
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

    /// Returns the crossing of a segment with the triangle: the position along the segment, from 0 to 1, and the barycentric coordinates. A
    /// segment in the plane of the triangle does not cross it.
    pub fn hit_by(&self, [from, to]: &[Vector3<f64>; 2]) -> Option<(f64, [f64; 3])> {
        let [before, after] = [from, to].map(|end| (end - self.corners[0]).dot(&self.normal));
        let share = before / (before - after);
        // The share of a segment in the plane is NaN, and so is that of a degenerate triangle.
        if !(0.0..=1.0).contains(&share) {
            return None;
        }
        let areas = self.areas(&from.lerp(to, share));
        let sum: f64 = areas.iter().sum();
        // Neighbors overlap by more than the rounding error, so that no segment passes between them.
        let is_inside = areas.iter().all(|&area| area >= -EDGE_OVERLAP * sum);
        is_inside.then(|| (share, shares(areas)))
    }

    fn edges(&self) -> [(&Vector3<f64>, &Vector3<f64>); 3] {
        let [a, b, c] = &self.corners;
        [(a, b), (b, c), (c, a)]
    }

    /// Returns, for each edge, twice the signed area (m²) of the triangle that the edge forms with
    /// the query point. The query point is projected to the plane. The area is positive on the
    /// inner side of the edge.
    fn areas(&self, point: &Vector3<f64>) -> [f64; 3] {
        self.edges()
            .map(|(from, to)| (to - from).cross(&(point - from)).dot(&self.normal))
    }
}

/// Returns barycentric coordinates from the areas at the edges. The area k belongs to the edge from corner k to k + 1, so that the
/// opposite corner is k + 2.
fn shares(areas: [f64; 3]) -> [f64; 3] {
    let sum: f64 = areas.iter().sum();
    [areas[1], areas[2], areas[0]].map(|area| area / sum)
}

/// Returns the sign of `height`, and 0 for 0.
fn direction_of(height: f64) -> f64 {
    if height == 0.0 { 0.0 } else { height.signum() }
}

fn distance_to_segment(point: &Vector3<f64>, from: &Vector3<f64>, to: &Vector3<f64>) -> f64 {
    let share = share_of_segment(point, from, to);
    ((point - from) - (to - from) * share).norm()
}

/// Returns the parameter of the closest point of a segment: 0 at `from`, 1 at `to`.
fn share_of_segment(point: &Vector3<f64>, from: &Vector3<f64>, to: &Vector3<f64>) -> f64 {
    let (edge, along) = (to - from, point - from);
    let length_squared = edge.norm_squared();
    if length_squared == 0.0 {
        return 0.0;
    }
    (along.dot(&edge) / length_squared).clamp(0.0, 1.0)
}
