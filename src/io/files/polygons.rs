//! Triangulation of polygons in space.

use crate::mesh::TriangleSoup;
use nalgebra::Vector3;

/// Limit of the number of tests of corners, which bounds the time for a polygon to about a second.
const MAX_TEST_COUNT: usize = 100_000_000;

/// Area below which three corners are collinear, relative to the squared size of the polygon.
const THINNESS: f64 = 1e-14;

/// Cause of the error for a polygon without a triangulation.
const CROSSED: &str = "the face intersects itself";

type Point = [f64; 2];

/// Returns the triangles of a polygon as indices of its corners. A fan around the first corner is used if it fills the polygon. Otherwise
/// ears are clipped. Triangles that cannot be avoided between collinear corners have no area. A polygon with fewer than three corners has
/// no triangles.
///
/// The corners need not lie in a plane. Each clipped ear is counter-clockwise in the coordinate plane closest to the polygon.
///
/// # Errors
/// Returns the cause if the polygon visibly intersects itself.
pub(super) fn triangulated(corners: &[Vector3<f64>]) -> Result<Vec<[usize; 3]>, &'static str> {
    let fan = || (2..corners.len()).map(|corner| [0, corner - 1, corner]);
    let points = projected(corners);
    let size = extent(&points);
    let smallest = THINNESS * size * size;
    let is_ear = |triangle: [usize; 3]| twice_area(triangle.map(|k| points[k])) > smallest;
    if corners.len() <= 3 || size == 0.0 || fan().all(is_ear) {
        return Ok(fan().collect());
    }
    Clipping {
        next: 0,
        ring: (0..corners.len()).collect(),
        tests_left: MAX_TEST_COUNT,
        smallest,
        points,
    }
    .ears()
}

/// Adds the triangles of a polygon whose corners are vertices of the soup. All indices must be in range.
///
/// # Errors
/// Returns the errors of [`triangulated`].
pub(super) fn add_polygon(soup: &mut TriangleSoup, corners: &[usize]) -> Result<(), &'static str> {
    let positions: Vec<Vector3<f64>> = corners.iter().map(|&v| soup.vertices[v]).collect();
    let triangles = triangulated(&positions)?;
    let triangles = triangles
        .iter()
        .map(|triangle| triangle.map(|k| corners[k]));
    soup.triangles.extend(triangles);
    Ok(())
}

/// Projects the corners along the axis closest to the normal, so that the polygon is counter-clockwise.
fn projected(corners: &[Vector3<f64>]) -> Vec<Point> {
    let Some(first) = corners.first() else {
        return Vec::new();
    };
    let edges = corners.windows(2);
    let normal: Vector3<f64> = edges
        .map(|edge| (edge[0] - first).cross(&(edge[1] - first)))
        .sum();
    let axis = normal.iamax();
    let [mut u, mut v] = [(axis + 1) % 3, (axis + 2) % 3];
    if normal[axis] < 0.0 {
        (u, v) = (v, u);
    }
    let offsets = corners.iter().map(|corner| corner - first);
    offsets.map(|offset| [offset[u], offset[v]]).collect()
}

/// Largest coordinate.
fn extent(points: &[Point]) -> f64 {
    let coordinates = points.as_flattened().iter();
    coordinates.fold(0.0, |largest, x| largest.max(x.abs()))
}

fn twice_area([a, b, c]: [Point; 3]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
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
                // Only collinear or repeated corners remain, which have no area.
                None => self.find(Self::is_spike)?.ok_or(CROSSED)?,
            };
            triangles.push(self.triangle_at(tip));
            self.ring.remove(tip);
            // Removal moves the corners behind the tip.
            self.tests_left = self.tests_left.saturating_sub(self.ring.len() / 16);
            self.next = tip;
        }
        let last = self.triangle_at(1);
        if twice_area(last.map(|corner| self.points[corner])) < -self.smallest {
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
        if twice_area(corners) <= self.smallest {
            return false;
        }
        self.tests_left = self.tests_left.saturating_sub(self.ring.len());
        let others = self.ring.iter().map(|&corner| self.points[corner]);
        !{ others }.any(|point| !corners.contains(&point) && contains(corners, point))
    }

    /// Returns true if the triangle of a corner and its neighbors has no area.
    fn is_spike(&mut self, tip: usize) -> bool {
        let corners = self.triangle_at(tip).map(|corner| self.points[corner]);
        twice_area(corners).abs() <= self.smallest
    }
}

/// Returns true if a closed counter-clockwise triangle contains a point.
fn contains([a, b, c]: [Point; 3], point: Point) -> bool {
    let edges = [[a, b], [b, c], [c, a]];
    { edges }
        .iter()
        .all(|&[from, to]| twice_area([from, to, point]) >= 0.0)
}

#[cfg(test)]
mod tests {
    use super::triangulated;
    use nalgebra::{Vector3, vector};

    /// Returns the area vector of the triangles, and the sum of their areas (m²).
    fn areas(corners: &[Vector3<f64>]) -> (Vector3<f64>, f64) {
        let triangles = triangulated(corners).unwrap();
        assert_eq!(triangles.len(), corners.len() - 2);
        let areas = triangles.iter().map(|triangle| {
            let [a, b, c] = triangle.map(|corner| corners[corner]);
            (b - a).cross(&(c - a)) / 2.0
        });
        let areas: Vec<Vector3<f64>> = areas.collect();
        (areas.iter().sum(), areas.iter().map(Vector3::norm).sum())
    }

    /// Asserts that the triangles fill the polygon without overlap: the norm of the area vector is the sum of the areas.
    fn assert_filled(corners: &[Vector3<f64>], area: f64) {
        for turn in 0..corners.len() {
            let turned = [&corners[turn..], &corners[..turn]].concat();
            let (vector, sum) = areas(&turned);
            assert!((vector.norm() - area).abs() < 1e-12 * area, "{vector}");
            assert!((sum - area).abs() < 1e-12 * area, "{sum}");
        }
    }

    fn flat(points: &[[f64; 2]]) -> Vec<Vector3<f64>> {
        // A tilted plane whose normal is closest to −y.
        let position = |&[x, y]: &[f64; 2]| vector![x, 0.3 * x - 0.2 * y, y];
        points.iter().map(position).collect()
    }

    fn area_of(points: &[[f64; 2]]) -> f64 {
        (0..points.len())
            .map(|k| {
                let ([a, b], [c, d]) = (points[k], points[(k + 1) % points.len()]);
                (a * d - b * c) / 2.0
            })
            .sum::<f64>()
            * (1.0_f64 + 0.09 + 0.04).sqrt()
    }

    #[test]
    fn concave_polygons_are_filled_once_from_any_first_corner() {
        let comb: Vec<[f64; 2]> = (0..9)
            .flat_map(|k| [[f64::from(2 * k), 0.0], [f64::from(2 * k) + 1.0, 5.0]])
            .chain([[17.0, 6.0], [0.0, 6.0]])
            .collect();
        let u = [
            [0.0, 0.0],
            [3.0, 0.0],
            [3.0, 3.0],
            [2.0, 3.0],
            [2.0, 1.0],
            [1.0, 1.0],
            [1.0, 3.0],
            [0.0, 3.0],
        ];
        let with_collinear = [
            [0.0, 0.0],
            [1.0, 0.0],
            [2.0, 0.0],
            [2.0, 2.0],
            [1.0, 2.0],
            [0.0, 2.0],
        ];
        // A frame that is cut open along a bridge between its two boundaries.
        let keyhole = [
            [0.0, 0.0],
            [3.0, 0.0],
            [3.0, 3.0],
            [0.0, 3.0],
            [0.0, 0.0],
            [1.0, 1.0],
            [1.0, 2.0],
            [2.0, 2.0],
            [2.0, 1.0],
            [1.0, 1.0],
        ];
        for points in [&comb[..], &u, &with_collinear, &keyhole] {
            assert_filled(&flat(points), area_of(points));
        }
    }

    #[test]
    fn polygons_without_area_are_triangulated_and_crossed_ones_are_refused() {
        let line = flat(&[[0.0, 0.0], [1.0, 0.0], [3.0, 0.0], [2.0, 0.0]]);
        assert_eq!(triangulated(&line).unwrap().len(), 2);
        assert!(triangulated(&line[..2]).unwrap().is_empty());
        let crossed = flat(&[[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 1.0]]);
        assert!(triangulated(&crossed).is_err());
    }
}
