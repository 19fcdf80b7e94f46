//! Triangulation of polygons in space.

use crate::mesh::{TriangleSoup, ear_clipping};
use nalgebra::{Vector2, Vector3, vector};

/// Returns the triangles of a polygon as [`ear_clipping::triangulated`] does. The corners may lie off a plane. Each triangle is
/// counter-clockwise in the plane of coordinates that is closest to the polygon, if it is not part of a fan.
///
/// # Errors
/// Returns the cause if the polygon visibly intersects itself.
pub(super) fn triangulated(corners: &[Vector3<f64>]) -> Result<Vec<[usize; 3]>, &'static str> {
    ear_clipping::triangulated(projected(corners))
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
fn projected(corners: &[Vector3<f64>]) -> Vec<Vector2<f64>> {
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
    offsets
        .map(|offset| vector![offset[u], offset[v]])
        .collect()
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

    /// A polygon overlaps itself nowhere if its triangles have the area of their common normal.
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
    fn polygons_without_area_are_cut_and_crossed_ones_are_refused() {
        let line = flat(&[[0.0, 0.0], [1.0, 0.0], [3.0, 0.0], [2.0, 0.0]]);
        assert_eq!(triangulated(&line).unwrap().len(), 2);
        assert!(triangulated(&line[..2]).unwrap().is_empty());
        let crossed = flat(&[[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 1.0]]);
        assert!(triangulated(&crossed).is_err());
    }
}
