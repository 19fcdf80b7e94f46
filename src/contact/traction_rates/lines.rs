//! The lines that bound a polygon in its plane, and how an edge is shared among several.

use nalgebra::Vector3;

/// The line in which the plane meets a face that owns an edge.
#[derive(Clone, Copy)]
pub(super) struct Line {
    /// The face: 0 to 3 of A, 4 to 7 of B.
    pub face: usize,
    /// The face's outward normal, along the axes of the plane.
    pub normal: Vector3<f64>,
    /// 1/|ν − (ν·n)n| for this normal ν, negative if it points into the polygon.
    pub outwardness: f64,
}

impl Line {
    pub fn moves_with_b(&self) -> bool {
        self.face >= 4
    }
}

/// The lines of the faces that an edge lies in.
pub(super) type Lines = [Option<Line>; 8];

/// Shares an edge out among its lines, so that its motion is the mean of both sides of the coincidence.
///
/// After a little of a change, ahead or behind, in which the lines' faces move outwards at these speeds relative to the
/// plane, the polygon ends at the innermost of the lines that bound it from outside, and begins at the outermost of those
/// that bound it from inside, if that lies further in. So of any number of lines that bound it from outside alone, the
/// slowest and the fastest share the edge. What is ahead and what is behind have their own weights.
pub(super) fn share_out(
    lines: &Lines,
    speed: impl Fn(&Line) -> f64,
    ways: [f64; 2],
    mut add: impl FnMut(&Line, f64),
) {
    let owning = || lines.iter().flatten();
    let is_outer = |line: &&Line| line.outwardness > 0.0;
    for (way, weight) in [1.0, -1.0].into_iter().zip(ways) {
        let speed = |line: &&Line| way * line.outwardness * speed(line);
        let by_speed = |one: &&Line, other: &&Line| speed(one).total_cmp(&speed(other));
        let end = owning().filter(is_outer).min_by(by_speed);
        let start = owning().filter(|line| !is_outer(line)).max_by(by_speed);
        let ends = end.zip(start);
        if ends.is_some_and(|(end, start)| speed(&end) <= speed(&start)) {
            continue;
        }
        if let Some(end) = end {
            add(end, 0.5 * weight);
        }
        if let Some(start) = start {
            add(start, -0.5 * weight);
        }
    }
}

/// 1/|ν − (ν·n)n|, negative if a face's normal ν points into the polygon at this edge, 0 if the face lies in the plane.
pub(super) fn outwardness(along: &[f64; 2], m: &Vector3<f64>) -> f64 {
    let sine = (m.x * m.x + m.y * m.y).sqrt();
    let turn = m.x * along[1] - m.y * along[0];
    if sine == 0.0 {
        0.0
    } else {
        turn.signum() / sine
    }
}
