//! Convex hulls of a few points, by brute force.

use hydroelastic::mesh::{PressureField, TriangleSoup, shapes};
use nalgebra::Vector3;

/// Returns the convex hull of points in general position (m) as a pressure field. It tries every triple of points.
pub fn hull(points: Vec<Vector3<f64>>) -> PressureField {
    let count = points.len();
    let triples = (0..count).flat_map(|i| {
        let pairs = (i + 1..count).flat_map(move |j| (j + 1..count).map(move |k| (j, k)));
        pairs.map(move |(j, k)| [i, j, k])
    });
    let triangles = triples.filter_map(|triple| outward(&points, triple));
    let soup = TriangleSoup {
        triangles: triangles.collect(),
        vertices: points,
    };
    shapes::star_shaped(&soup.closed().unwrap()).unwrap()
}

/// Returns the triangle of three points, counter-clockwise seen from outside, if all points are on one side of it.
fn outward(points: &[Vector3<f64>], [i, j, k]: [usize; 3]) -> Option<[usize; 3]> {
    let normal = (points[j] - points[i]).cross(&(points[k] - points[i]));
    let others = (0..points.len()).filter(|point| ![i, j, k].contains(point));
    let mut heights = others.map(|point| normal.dot(&(points[point] - points[i])));
    let first = heights.next()?;
    if first > 0.0 {
        return heights.all(|height| height > 0.0).then_some([i, k, j]);
    }
    heights.all(|height| height < 0.0).then_some([i, j, k])
}
