//! Curves with fewer points that look the same. Pixels are whole numbers, so a line through close points looks jagged.

use nalgebra::Vector2;

/// Largest displacement of a curve (pixels).
const UNSEEN: f64 = 0.4;

/// Returns the ends of a curve, and the points between them without which it would look different. `pixels` is the length of a unit along
/// each axis.
pub fn thinned(points: &[(f64, f64)], pixels: Vector2<f64>) -> Vec<(f64, f64)> {
    let (Some(&first), Some(&last)) = (points.first(), points.last()) else {
        return Vec::new();
    };
    let place = |(x, y): (f64, f64)| Vector2::new(x, y).component_mul(&pixels);
    let (start, chord) = (place(first), place(last) - place(first));
    let length = chord.norm().max(f64::EPSILON);
    let distance = |point: (f64, f64)| ((place(point) - start).perp(&chord) / length).abs();
    let distances = points.iter().map(|point| distance(*point)).enumerate();
    let farthest = distances.max_by(|a, b| a.1.total_cmp(&b.1));
    match farthest {
        Some((middle, distance)) if distance > UNSEEN => {
            let mut left = thinned(&points[..=middle], pixels);
            left.pop();
            [left, thinned(&points[middle..], pixels)].concat()
        }
        _ => vec![first, last],
    }
}
