//! Triangulation of polygons in the plane.

use nalgebra::Vector2;

/// Limit of the number of tests of corners, which bounds the time for a polygon to about a second.
const MAX_TEST_COUNT: usize = 100_000_000;

/// Area below which three corners are collinear, relative to the squared size of the polygon.
const THINNESS: f64 = 1e-14;

/// Cause of the error for a polygon without a triangulation.
const CROSSED: &str = "the face intersects itself";

type Point = Vector2<f64>;

/// Returns the triangles of a polygon as indices of its corners. The polygon may be concave, and its edges may touch. A fan around the
/// first corner is used if it fills the polygon. Otherwise ears are clipped. Triangles that cannot be avoided between collinear corners
/// have no area. A polygon with fewer than three corners has no triangles.
///
/// The corners, and those of each triangle, are counter-clockwise.
///
/// # Errors
/// Returns the cause if the polygon visibly intersects itself.
pub(crate) fn triangulated(points: Vec<Point>) -> Result<Vec<[usize; 3]>, &'static str> {
    let count = points.len();
    let fan = || (2..count).map(|corner| [0, corner - 1, corner]);
    let size = { points.iter() }.fold(0.0, |size: f64, point| size.max((point - points[0]).amax()));
    let smallest = THINNESS * size * size;
    let is_ear = |triangle: [usize; 3]| orientation(triangle.map(|k| points[k])) > smallest;
    if count <= 3 || size == 0.0 || fan().all(is_ear) {
        return Ok(fan().collect());
    }
    Clipping {
        next: 0,
        ring: (0..count).collect(),
        tests_left: MAX_TEST_COUNT,
        smallest,
        points,
    }
    .ears()
}

/// Returns twice the signed area (m²) of the triangle. It is positive if the corners are counter-clockwise.
pub(crate) fn orientation([a, b, c]: [Point; 3]) -> f64 {
    (b - a).perp(&(c - a))
}

/// The rest of a polygon while ears are clipped.
struct Clipping {
    points: Vec<Point>,
    /// Corners that are not clipped.
    ring: Vec<usize>,
    /// Position in the ring at which the search continues.
    next: usize,
    tests_left: usize,
    /// Twice the area above which a triangle is an ear.
    smallest: f64,
}

impl Clipping {
    fn ears(mut self) -> Result<Vec<[usize; 3]>, &'static str> {
        let mut triangles = Vec::with_capacity(self.ring.len() - 2);
        while self.ring.len() > 3 {
            let tip = match self.find(Self::is_ear)? {
                Some(tip) => tip,
                // Corners on a line or twice at one position remain, which have no area.
                None => self.find(Self::is_spike)?.ok_or(CROSSED)?,
            };
            triangles.push(self.triangle_at(tip));
            self.ring.remove(tip);
            // Removal moves the corners behind the tip.
            self.tests_left = self.tests_left.saturating_sub(self.ring.len() / 16);
            self.next = tip;
        }
        let last = self.triangle_at(1);
        if orientation(last.map(|corner| self.points[corner])) < -self.smallest {
            return Err(CROSSED);
        }
        triangles.push(last);
        Ok(triangles)
    }

    /// Returns the first position in the ring, from `next` on, that passes a test.
    fn find(
        &mut self,
        test: impl Fn(&mut Self, usize) -> bool,
    ) -> Result<Option<usize>, &'static str> {
        let count = self.ring.len();
        for step in 0..count {
            let tip = (self.next + step) % count;
            self.tests_left = self.tests_left.saturating_sub(1);
            if test(self, tip) {
                return Ok(Some(tip));
            }
            if self.tests_left == 0 {
                return Err("the face has too many corners: cut it into triangles beforehand");
            }
        }
        Ok(None)
    }

    fn triangle_at(&self, tip: usize) -> [usize; 3] {
        let count = self.ring.len();
        [tip + count - 1, tip, tip + 1].map(|position| self.ring[position % count])
    }

    /// Returns true if the triangle of a corner and its neighbors is counter-clockwise and contains no other corner.
    fn is_ear(&mut self, tip: usize) -> bool {
        let corners = self.triangle_at(tip).map(|corner| self.points[corner]);
        if orientation(corners) <= self.smallest {
            return false;
        }
        self.tests_left = self.tests_left.saturating_sub(self.ring.len());
        let others = self.ring.iter().map(|&corner| self.points[corner]);
        !{ others }.any(|point| !corners.contains(&point) && contains(corners, point))
    }

    /// Returns true if the triangle of a corner and its neighbors has no area.
    fn is_spike(&mut self, tip: usize) -> bool {
        let corners = self.triangle_at(tip).map(|corner| self.points[corner]);
        orientation(corners).abs() <= self.smallest
    }
}

/// Returns true if a counter-clockwise triangle contains a point. Its boundary belongs to it.
fn contains([a, b, c]: [Point; 3], point: Point) -> bool {
    let edges = [[a, b], [b, c], [c, a]];
    { edges }
        .iter()
        .all(|&[from, to]| orientation([from, to, point]) >= 0.0)
}
