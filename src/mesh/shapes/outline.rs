use crate::mesh::MeshError;
use crate::mesh::ear_clipping::{self, orientation};
use nalgebra::Vector2;

/// Smallest and largest number of points of an outline. The check for crossings takes quadratic time.
const POINTS: [usize; 2] = [3, 2_000];

/// Distance below which two edges touch, over the size of the outline.
const TOUCH: f64 = 1e-9;

/// Returns the triangles of a simple polygon, counter-clockwise, by ear clipping. The polygon may be concave, and may have either
/// orientation.
///
/// # Errors
/// Returns an error if the number of points is out of range, if a coordinate is not finite, or if edges touch or cross.
pub(super) fn triangulated(points: &[Vector2<f64>]) -> Result<Vec<[usize; 3]>, MeshError> {
    super::check_resolution("points", points.len(), POINTS)?;
    for (vertex, point) in points.iter().enumerate() {
        if let Some(&value) = point.iter().find(|value| !value.is_finite()) {
            return Err(MeshError::NonFiniteCoordinate { vertex, value });
        }
    }
    check_simple(points, TOUCH * size(points))?;
    let mut outline: Vec<usize> = (0..points.len()).collect();
    if doubled_area(points) < 0.0 {
        outline.reverse();
    }
    let corners = outline.iter().map(|&corner| points[corner]).collect();
    // A simple polygon has a triangulation, so that only rounding error can hide it.
    let triangles = ear_clipping::triangulated(corners).map_err(|_| MeshError::TouchingEdges {
        edges: [outline[0], outline[1]],
    })?;
    let triangles = triangles.iter();
    Ok(triangles.map(|ear| ear.map(|k| outline[k])).collect())
}

/// Diagonal (m) of the bounding rectangle.
fn size(points: &[Vector2<f64>]) -> f64 {
    let bounds = points[1..]
        .iter()
        .fold((points[0], points[0]), |(low, high), point| {
            (low.inf(point), high.sup(point))
        });
    (bounds.1 - bounds.0).norm()
}

fn doubled_area(points: &[Vector2<f64>]) -> f64 {
    let next = points.iter().cycle().skip(1);
    let from_first = |point: &Vector2<f64>| point - points[0];
    let edges = points.iter().zip(next);
    edges.map(|(a, b)| from_first(a).perp(&from_first(b))).sum()
}

/// Checks that edges without a common point are farther apart than `touch` (m), and that successive edges do not fold back.
fn check_simple(points: &[Vector2<f64>], touch: f64) -> Result<(), MeshError> {
    let count = points.len();
    let edge = |first: usize| [points[first], points[(first + 1) % count]];
    for first in 0..count {
        for second in first + 1..count {
            let [a, b] = edge(first);
            let [c, d] = edge(second);
            let is_apart = if second == first + 1 {
                distance(a, [c, d]).min(distance(d, [a, b])) > touch
            } else if first == 0 && second == count - 1 {
                distance(b, [c, d]).min(distance(c, [a, b])) > touch
            } else {
                !is_crossing([a, b], [c, d])
                    && [(a, [c, d]), (b, [c, d]), (c, [a, b]), (d, [a, b])]
                        .into_iter()
                        .all(|(point, edge)| distance(point, edge) > touch)
            };
            if !is_apart {
                let edges = [first, second];
                return Err(MeshError::TouchingEdges { edges });
            }
        }
    }
    Ok(())
}

/// Returns true if each edge has its ends on different sides of the other edge.
fn is_crossing([a, b]: [Vector2<f64>; 2], [c, d]: [Vector2<f64>; 2]) -> bool {
    let differ = |first: f64, second: f64| (first > 0.0) != (second > 0.0);
    differ(orientation([a, b, c]), orientation([a, b, d]))
        && differ(orientation([c, d, a]), orientation([c, d, b]))
}

/// Distance (m) of a point from an edge.
pub(super) fn distance(point: Vector2<f64>, [a, b]: [Vector2<f64>; 2]) -> f64 {
    let along = b - a;
    // An edge may have no length.
    let share = (point - a).dot(&along) / along.norm_squared().max(f64::MIN_POSITIVE);
    (point - a - along * share.clamp(0.0, 1.0)).norm()
}
