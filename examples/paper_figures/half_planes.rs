//! The intersection of half-planes as the paper has it (§III-E): sorted by angle, then taken one at
//! a time into a queue, from whose ends a new one drops those that it makes redundant: the corner that
//! they make with their neighbor lies outside the new one.
//!
//! Without a common point this may drop the very border that keeps the half-planes apart. Other corners
//! should then fall too, but borders that nearly coincide put them within the tolerance, and what is
//! left looks like a polygon (the paper, §VI-C).

use nalgebra::Vector2;
use std::collections::VecDeque;

/// How far outside (m) a point counts as inside, as in the paper's program, Hydroelastics.jl.
pub const TOLERANCE: f64 = 1e-9;

/// The points to the left of a directed line.
#[derive(Clone, Copy)]
pub struct HalfPlane {
    /// A point (m) of the border.
    pub point: Vector2<f64>,
    /// Unit vector along it.
    pub direction: Vector2<f64>,
}

impl HalfPlane {
    /// To the left of the way from one point to another.
    pub fn left_of(from: Vector2<f64>, to: Vector2<f64>) -> Self {
        Self {
            point: from,
            direction: (to - from).normalize(),
        }
    }

    /// How far inside a point lies (m).
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

/// Where two borders cross: far away, or nowhere, if they are parallel.
fn crossing(first: &HalfPlane, second: &HalfPlane) -> Vector2<f64> {
    let along = (second.point - first.point).perp(&second.direction);
    first.point + first.direction * (along / first.direction.perp(&second.direction))
}

/// The corners of what lies in all half-planes, or nothing.
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

/// Drops from both ends while the corner there lies outside the next one.
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

/// Drops what the other end makes redundant.
fn close(queue: &mut VecDeque<HalfPlane>) {
    while queue.len() > 2 && queue[0].excludes(&corner_at_end(queue)) {
        queue.pop_back();
    }
    while queue.len() > 2 && queue[queue.len() - 1].excludes(&crossing(&queue[0], &queue[1])) {
        queue.pop_front();
    }
}
