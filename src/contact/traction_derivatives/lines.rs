//! The lines that bound a polygon in its plane. If several lines contain an edge, each line has a share in the edge.

use super::pieces::EdgeFace;
use nalgebra::Vector3;

/// The line in which the plane meets a face that owns an edge.
#[derive(Clone, Copy)]
pub(super) struct Line {
    /// The face: 0 to 3 of A, 4 to 7 of B, or [`TAXEL_PLANE`].
    pub face: usize,
    /// The body with which the face moves: 0 for A, 1 for B.
    pub body: u8,
    /// The face's outward unit normal ν, in A's axes.
    pub outward: Vector3<f64>,
    /// ν·n.
    pub along_normal: f64,
    /// 1/|ν − (ν·n)n|. It is negative if ν points into the polygon, and 0 if the face lies in the plane.
    pub inverse_sine: f64,
}

/// Relative rounding error of the speed of a line.
const SAME_SPEED: f64 = 1e-9;

/// Index in [`Lines`] of the taxel plane that contains the edge.
pub(super) const TAXEL_PLANE: usize = 8;

impl Line {
    /// Returns the face with its shares in the motion of an edge. The shares are multiplied by the sign of `inverse_sine`, so a face in the
    /// plane moves no edge.
    pub fn as_edge_face(&self, shares: [f64; 2]) -> EdgeFace {
        let sign = if self.inverse_sine == 0.0 {
            0.0
        } else {
            self.inverse_sine.signum()
        };
        EdgeFace {
            body: self.body,
            opposite: (self.face != TAXEL_PLANE).then_some(self.face % 4),
            normal: self.outward,
            shares: shares.map(|share| share * sign),
        }
    }
}

/// The lines of the faces that contain an edge.
pub(super) type Lines = [Option<Line>; TAXEL_PLANE + 1];

/// Shares an edge among its lines. The motion of the edge is then the mean of both sides of the coincidence.
///
/// Consider a small forward change, in which the faces move outwards at the given speeds relative to the plane, and the opposite backward
/// change. `weights` has the weights of the two changes. The polygon after each change follows from these rules:
///
/// - Lines with a positive `inverse_sine` bound the polygon from outside. The polygon ends at the innermost of them.
/// - Lines with a negative `inverse_sine` bound the polygon from inside. The polygon begins at the outermost of them.
/// - If the end is not outside the beginning, no polygon is left, and neither line has a share.
/// - A face that lies in the plane has no line.
///
/// If all lines bound the polygon from outside, the slowest and the fastest line share the edge.
///
/// A taxel plane and a face of the same body may have equal speeds. Round-off would then decide which line is faster. The shares are
/// therefore the mean over a slightly slower and a slightly faster plane. `scale` is the size of a typical speed.
pub(super) fn split_between_owners(
    lines: &Lines,
    (speed, scale): (impl Fn(&Line) -> f64, f64),
    weights: [f64; 2],
    mut add: impl FnMut(&Line, f64),
) {
    if lines[TAXEL_PLANE].is_none() {
        return split_by_speed(lines, speed, weights, add);
    }
    for nudge in [SAME_SPEED * scale, -SAME_SPEED * scale] {
        let of_plane = |line: &Line| f64::from(u8::from(line.face == TAXEL_PLANE));
        let nudged = |line: &Line| speed(line) + nudge * of_plane(line);
        split_by_speed(lines, nudged, weights, |line, share| add(line, 0.5 * share));
    }
}

/// Computes the shares of [`split_between_owners`] for lines with distinct speeds.
fn split_by_speed(
    lines: &Lines,
    speed: impl Fn(&Line) -> f64,
    weights: [f64; 2],
    mut add: impl FnMut(&Line, f64),
) {
    let owning = || lines.iter().flatten();
    let is_outer = |line: &&Line| line.inverse_sine > 0.0;
    let is_inner = |line: &&Line| line.inverse_sine < 0.0;
    for (sign, weight) in [1.0, -1.0].into_iter().zip(weights) {
        let speed = |line: &&Line| sign * line.inverse_sine * speed(line);
        let by_speed = |a: &&Line, b: &&Line| speed(a).total_cmp(&speed(b));
        let end = owning().filter(is_outer).min_by(by_speed);
        let start = owning().filter(is_inner).max_by(by_speed);
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

/// Returns 1/|ν − (ν·n)n| for an edge `along` and the outward normal ν of a face, whose components along the axes are `m`. The result is
/// negative if ν points into the polygon, and 0 if the face lies in the plane.
pub(super) fn inverse_sine(along: &[f64; 2], m: &Vector3<f64>) -> f64 {
    let sine = (m.x * m.x + m.y * m.y).sqrt();
    let turn = m.x * along[1] - m.y * along[0];
    if sine == 0.0 {
        0.0
    } else {
        turn.signum() / sine
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Creates a line of the face with this number.
    fn line(face: usize, inverse_sine: f64) -> Line {
        Line {
            face,
            body: 0,
            outward: Vector3::x(),
            along_normal: 0.0,
            inverse_sine,
        }
    }

    /// A vertex of the face may move while the plane stays, so each has half of the edge.
    #[test]
    fn a_taxel_plane_and_a_face_with_the_same_speed_have_equal_shares_of_an_edge() {
        for speed in [0.0, 1e-17, 2.0] {
            let mut owning = [None; TAXEL_PLANE + 1];
            (owning[0], owning[TAXEL_PLANE]) = (Some(line(0, 1.0)), Some(line(TAXEL_PLANE, 1.0)));
            let mut shares = [0.0; TAXEL_PLANE + 1];
            split_between_owners(&owning, (|_| speed, 1.0), [1.0, 1.0], |line, share| {
                shares[line.face] += share;
            });
            let halves = [shares[0], shares[TAXEL_PLANE]].map(f64::to_bits);
            assert_eq!(halves, [0.5_f64.to_bits(); 2], "{speed}");
        }
    }

    /// Returns the share of each face in an edge, as bits, for faces that move at these speeds.
    fn shares(lines: &[Line], speeds: [f64; 3]) -> [u64; 3] {
        let mut owning = [None; TAXEL_PLANE + 1];
        for (slot, line) in owning.iter_mut().zip(lines) {
            *slot = Some(*line);
        }
        let mut shares = [0.0; 3];
        split_between_owners(
            &owning,
            (|line| speeds[line.face], 1.0),
            [1.0, 1.0],
            |line, share| shares[line.face] += share,
        );
        shares.map(f64::to_bits)
    }

    #[test]
    fn a_face_in_the_plane_takes_no_share_of_an_edge_and_leaves_those_of_the_others_as_they_are() {
        let speeds = [-2.0, -1.0, 1.0, 2.0];
        for (first, second) in speeds.into_iter().flat_map(|v| speeds.map(|w| (v, w))) {
            for sides in [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]] {
                let both = [line(0, sides[0]), line(1, sides[1])];
                for others in [&both[..], &both[..1]] {
                    let without = shares(others, [first, second, 0.0]);
                    for in_plane in [-3.0, 0.0, 3.0] {
                        let speeds = [first, second, in_plane];
                        let with = shares(&[others, &[line(2, 0.0)]].concat(), speeds);
                        assert_eq!(with, without, "{sides:?} {speeds:?}");
                    }
                }
            }
        }
    }
}
