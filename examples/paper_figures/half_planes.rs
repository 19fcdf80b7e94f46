//! The intersection of half-planes as in the paper (§III-E). The half-planes are sorted by angle and appended to a queue one at a time. A
//! new half-plane removes redundant half-planes from both ends of the queue. An end is redundant if its corner with its neighbor lies
//! outside the new half-plane.
//!
//! If the intersection is empty, the algorithm may remove the border that separates the half-planes. Other corners should then be removed
//! too, but nearly coincident borders put these corners within the tolerance. The remaining half-planes then look like a polygon (the
//! paper, §VI-C).

use nalgebra::Vector2;
use std::collections::VecDeque;

/// Distance (m) at which an outside point counts as inside, as in the paper's program, Hydroelastics.jl.
pub const TOLERANCE: f64 = 1e-9;

/// The points to the left of a directed line.
#[derive(Clone, Copy)]
pub struct HalfPlane {
    /// A point (m) of the border.
    pub point: Vector2<f64>,
    /// Unit vector along the border.
    pub direction: Vector2<f64>,
}

impl HalfPlane {
    /// Creates the half-plane to the left of the direction from one point to another.
    pub fn left_of(from: Vector2<f64>, to: Vector2<f64>) -> Self {
        Self {
            point: from,
            direction: (to - from).normalize(),
        }
    }

    /// Returns the signed distance (m) of a point inside the border.
    pub fn depth(&self, point: &Vector2<f64>) -> f64 {
        self.direction.perp(&(point - self.point))
    }

    fn excludes(&self, point: &Vector2<f64>) -> bool {
        self.depth(point) < -TOLERANCE
    }

    fn angle(&self) -> f64 {
        self.direction.y.atan2(self.direction.x)
    }
}

/// Returns the crossing of two borders, which is far away or not finite if they are parallel.
fn crossing(first: &HalfPlane, second: &HalfPlane) -> Vector2<f64> {
    let along = (second.point - first.point).perp(&second.direction);
    first.point + first.direction * (along / first.direction.perp(&second.direction))
}

/// Returns the corners of the intersection, or an empty vector.
pub fn intersection(mut half_planes: Vec<HalfPlane>) -> Vec<Vector2<f64>> {
    half_planes.sort_by(|a, b| a.angle().total_cmp(&b.angle()));
    let mut queue: VecDeque<HalfPlane> = VecDeque::new();
    for next in half_planes {
        drop_redundant(&mut queue, &next);
        queue.push_back(next);
    }
    close(&mut queue);
    if queue.len() < 3 {
        return Vec::new();
    }
    let following = queue.iter().cycle().skip(1);
    let pairs = queue.iter().zip(following);
    pairs.map(|(one, other)| crossing(one, other)).collect()
}

/// Removes half-planes from both ends of the queue while their corner lies outside the next half-plane.
fn drop_redundant(queue: &mut VecDeque<HalfPlane>, next: &HalfPlane) {
    while queue.len() > 1 && next.excludes(&corner_at_end(queue)) {
        queue.pop_back();
    }
    while queue.len() > 1 && next.excludes(&crossing(&queue[0], &queue[1])) {
        queue.pop_front();
    }
}

fn corner_at_end(queue: &VecDeque<HalfPlane>) -> Vector2<f64> {
    let last = queue.len() - 1;
    crossing(&queue[last - 1], &queue[last])
}

/// Removes half-planes at one end that are redundant because of the other end.
fn close(queue: &mut VecDeque<HalfPlane>) {
    while queue.len() > 2 && queue[0].excludes(&corner_at_end(queue)) {
        queue.pop_back();
    }
    while queue.len() > 2 && queue[queue.len() - 1].excludes(&crossing(&queue[0], &queue[1])) {
        queue.pop_front();
    }
}
