use crate::mesh::MeshError;
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
    let size = size(points);
    check_simple(points, TOUCH * size)?;
    let mut outline: Vec<usize> = (0..points.len()).collect();
    if doubled_area(points) < 0.0 {
        outline.reverse();
    }
    let flat = 1e-12 * size * size;
    let mut triangles = Vec::with_capacity(points.len() - 2);
    while outline.len() > 3 {
        let ear = (0..outline.len()).find(|&ear| is_ear(points, &outline, ear, flat));
        // A simple polygon has an ear, so that only rounding error can hide it.
        let Some(ear) = ear else {
            let edges = [outline[0], outline[1]];
            return Err(MeshError::TouchingEdges { edges });
        };
        triangles.push(corner(&outline, ear));
        outline.remove(ear);
    }
    triangles.push([outline[0], outline[1], outline[2]]);
    Ok(triangles)
}

/// Returns twice the signed area (m²) of the triangle. It is positive if the corners are counter-clockwise.
pub(super) fn orientation([a, b, c]: [Vector2<f64>; 3]) -> f64 {
    (b - a).perp(&(c - a))
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

/// The point before a point of the outline, the point and the point after it.
fn corner(outline: &[usize], index: usize) -> [usize; 3] {
    let count = outline.len();
    [count - 1, 0, 1].map(|offset| outline[(index + offset) % count])
}

/// Returns true if the corner can be cut off: it is convex, and no other point lies in its closed triangle.
fn is_ear(points: &[Vector2<f64>], outline: &[usize], index: usize, flat: f64) -> bool {
    let ear = corner(outline, index);
    let [a, b, c] = ear.map(|vertex| points[vertex]);
    let is_inside = |point: Vector2<f64>| {
        let sides = [[a, b, point], [b, c, point], [c, a, point]];
        sides.into_iter().all(|side| orientation(side) >= -flat)
    };
    let mut others = outline.iter().filter(|vertex| !ear.contains(vertex));
    orientation([a, b, c]) > flat && !others.any(|&vertex| is_inside(points[vertex]))
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
