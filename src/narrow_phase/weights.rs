//! The weight of a contact polygon, from the signs of p_A − p_B at the corners of both tetrahedra.

use nalgebra::Vector3;

/// Generic velocity of B (m/s, A's axes). Faces through a common line or plane leave it one after the other at this velocity.
pub(crate) const PERTURBATION: Vector3<f64> = Vector3::new(0.613, 0.427, -0.665);

/// Signs of the (snapped) values of p_A − p_B at the corners of a tetrahedron: bit i for corner i.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CornerSigns {
    below: u8,
    zero: u8,
}

const ALL_CORNERS: u8 = 0b1111;

/// The sides of the plane, as bits.
const BELOW: u8 = 1;
const ABOVE: u8 = 2;

impl CornerSigns {
    /// A tetrahedron with corners on both sides of the plane.
    pub const CROSSED: Self = Self {
        below: 0b0001,
        zero: 0,
    };

    /// A tetrahedron without known signs.
    pub const UNKNOWN: Self = Self {
        below: 0,
        zero: ALL_CORNERS,
    };

    /// Returns the signs of a tetrahedron that has face 3 in the plane and lies below or above it.
    pub fn on_face(is_below: bool) -> Self {
        Self {
            below: if is_below { 0b1000 } else { 0 },
            zero: 0b0111,
        }
    }

    /// Returns the signs of values of p_A − p_B at the corners. Values within rounding errors of zero must have been snapped to zero.
    #[inline]
    pub fn of(values: &[f64; 4]) -> Self {
        let bits = |is_set: fn(f64) -> bool| (0..4).map(|i| u8::from(is_set(values[i])) << i).sum();
        Self {
            below: bits(|value| value < 0.0),
            zero: bits(|value| value == 0.0),
        }
    }

    /// Returns whether the plane passes through the tetrahedron or touches it.
    pub fn are_met(self) -> bool {
        self.below != ALL_CORNERS && self.below | self.zero != 0
    }

    /// Returns whether these corners are all on one side of the plane, and none is on it.
    fn are_beside(self, corners: u8) -> bool {
        self.below & corners == corners || (self.below | self.zero) & corners == 0
    }

    /// Returns the faces that the plane misses: bit k for the face opposite to corner k.
    pub fn missed_faces(self) -> u8 {
        let bit = |corner: u8| u8::from(self.are_beside(ALL_CORNERS & !(1 << corner))) << corner;
        bit(0) | bit(1) | bit(2) | bit(3)
    }

    /// Returns the faces whose lines in the plane do not meet the line of this face within the tetrahedron, because the plane misses their
    /// common edge.
    pub fn disjoint_faces(self, face: usize) -> u8 {
        let bit = |corner: u8| {
            u8::from(self.are_beside(ALL_CORNERS & !(1 << face | 1 << corner))) << corner
        };
        bit(0) | bit(1) | bit(2) | bit(3)
    }

    /// Returns the sides of the plane on which the tetrahedron has corners.
    fn corner_sides(self) -> u8 {
        let is_above = self.below | self.zero != ALL_CORNERS;
        (if self.below == 0 { 0 } else { BELOW }) | if is_above { ABOVE } else { 0 }
    }

    /// Returns whether the plane cuts more than a corner of the tetrahedron, if zero values count as below, or as above.
    fn is_cut(self, is_zero_below: bool) -> bool {
        match self.corner_sides() {
            BELOW => self.zero.count_ones() > 1 && !is_zero_below,
            ABOVE => self.zero.count_ones() > 1 && is_zero_below,
            sides => sides != 0,
        }
    }

    /// Returns whether the plane touches only an edge of the tetrahedron.
    fn is_touched_at_edge(self) -> bool {
        self.zero.count_ones() == 2 && self.corner_sides() != BELOW | ABOVE
    }

    /// Returns the corners that count as below in a slice. Corners on the plane count only if the plane touches the tetrahedron from
    /// below.
    pub fn sliced_below(self) -> u8 {
        if self.below == 0 {
            self.zero
        } else {
            self.below
        }
    }

    /// Returns the faces that lie in the plane: bit k for the face opposite to corner k.
    pub fn faces_in_plane(self) -> u8 {
        match ALL_CORNERS & !self.zero {
            0 => ALL_CORNERS,
            opposite if opposite.is_power_of_two() => opposite,
            _ => 0,
        }
    }
}

/// Weight of a contact polygon: the mean of what the plane cuts after a small forward change and after a small backward change.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Weight {
    is_ahead: bool,
    is_behind: bool,
    /// Whether the plane touches one of the tetrahedra along an edge. There is no area, but the plane cuts a strip if it moves to one
    /// side.
    is_line: bool,
}

impl Weight {
    const WHOLE: Self = Self {
        is_ahead: true,
        is_behind: true,
        is_line: false,
    };

    /// Returns the factor of integrals over the polygon: 0, ½ or 1.
    pub fn area(self) -> f64 {
        if self.is_line { 0.0 } else { self.mean() }
    }

    /// Returns the weights after the forward and the backward change: 1 if the polygon counts, and 0 if it does not.
    pub fn ahead_and_behind(self) -> [f64; 2] {
        [self.is_ahead, self.is_behind].map(|is_there| f64::from(u8::from(is_there)))
    }

    /// Returns the mean of both changes. A line counts as the strip that it opens into.
    pub fn mean(self) -> f64 {
        let [ahead, behind] = self.ahead_and_behind();
        0.5 * (ahead + behind)
    }

    fn has_area(self) -> bool {
        self.is_there() && !self.is_line
    }

    fn is_there(self) -> bool {
        self.is_ahead || self.is_behind
    }

    /// Computes the weight from the signs before a small change, and from the rates of p_A − p_B at the corners of A and of B. Zero values
    /// have the sign of their rate after the forward change, and the opposite sign after the backward change.
    fn of([a, b]: [CornerSigns; 2], [rate_a, rate_b]: [f64; 2]) -> Self {
        let is_cut = |is_ahead: bool| {
            let is_below = |rate: f64| (rate > 0.0) != is_ahead;
            a.is_cut(is_below(rate_a)) && b.is_cut(is_below(rate_b))
        };
        Self {
            is_ahead: is_cut(true),
            is_behind: is_cut(false),
            is_line: a.is_touched_at_edge() || b.is_touched_at_edge(),
        }
    }
}

/// Weights of a contact polygon if faces, edges or corners lie in the plane: the mean of both sides of the coincidence.
///
/// If faces of both bodies lie in the plane, values and motions have different weights. When a modulus changes, the plane leaves both
/// faces on the same side. When a body moves, the plane may stay between them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Weights {
    /// Weight for values, and for all derivatives except derivatives with respect to a motion.
    pub still: Weight,
    /// Weight for derivatives with respect to a motion.
    pub moving: Weight,
}

impl Weights {
    /// The weights of a polygon that counts fully.
    pub const WHOLE: Self = Self {
        still: Weight::WHOLE,
        moving: Weight::WHOLE,
    };

    /// Computes the weights from the signs of p_A − p_B at the corners of both tetrahedra, and the gradients of both pressures.
    pub fn of(signs: [CornerSigns; 2], [gradient_a, gradient_b]: [&Vector3<f64>; 2]) -> Self {
        let still = Weight::of(signs, [-1.0; 2]);
        let has_zero = signs.iter().any(|signs| signs.zero != 0);
        let moving = if has_zero {
            // The rates of p_A − p_B as B moves: A's corners stay, and B's corners move with B.
            Weight::of(
                signs,
                [gradient_b.dot(&PERTURBATION), gradient_a.dot(&PERTURBATION)],
            )
        } else {
            still
        };
        Self { still, moving }
    }

    /// Computes the weights if faces on the surfaces of both bodies lie in the plane. The bodies may only touch, so motions have the weight
    /// of values.
    pub fn of_touching(signs: [CornerSigns; 2]) -> Self {
        let still = Weight::of(signs, [-1.0; 2]);
        Self {
            still,
            moving: still,
        }
    }

    /// Returns whether the polygon counts fully.
    pub fn are_whole(self) -> bool {
        self == Self::WHOLE
    }

    /// Returns whether the area counts in values.
    pub fn has_still_area(self) -> bool {
        self.still.has_area()
    }

    /// Returns whether the area counts in values or in derivatives.
    pub fn have_area(self) -> bool {
        self.still.has_area() || self.moving.has_area()
    }

    /// Returns whether the polygon has no weight.
    pub fn are_none(self) -> bool {
        !self.still.is_there() && !self.moving.is_there()
    }
}
