//! How much of a contact polygon counts, from the signs of p_A − p_B at the corners of both tetrahedra.

use nalgebra::Vector3;

/// Velocity of B (m/s, A's axes) by which faces through a common line or plane leave it one after the other; any generic
/// one will do.
pub(crate) const PERTURBATION: Vector3<f64> = Vector3::new(0.613, 0.427, -0.665);

/// How the equilibrium plane lies to a tetrahedron: the signs of the (snapped) values of p_A − p_B at
/// its corners, bit i for corner i.
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
    /// Of a tetrahedron with corners on both sides.
    pub const CROSSED: Self = Self {
        below: 0b0001,
        zero: 0,
    };

    /// Of which nothing is known.
    pub const UNKNOWN: Self = Self {
        below: 0,
        zero: ALL_CORNERS,
    };

    /// Of a tetrahedron with face 3 in the plane, that lies below the plane or above it.
    pub fn on_face(is_below: bool) -> Self {
        Self {
            below: if is_below { 0b1000 } else { 0 },
            zero: 0b0111,
        }
    }

    /// Of values of p_A − p_B at the corners, snapped to zero where they are within round-off of it.
    #[inline]
    pub fn of(values: &[f64; 4]) -> Self {
        let bits = |is_set: fn(f64) -> bool| (0..4).map(|i| u8::from(is_set(values[i])) << i).sum();
        Self {
            below: bits(|value| value < 0.0),
            zero: bits(|value| value == 0.0),
        }
    }

    /// Whether the plane passes through the tetrahedron or touches it.
    pub fn are_met(self) -> bool {
        self.below != ALL_CORNERS && self.below | self.zero != 0
    }

    /// Whether these corners are all on one side of the plane, and not on it.
    fn are_beside(self, corners: u8) -> bool {
        self.below & corners == corners || (self.below | self.zero) & corners == 0
    }

    /// The faces that the plane misses: bit k for the face opposite to corner k.
    pub fn missed_faces(self) -> u8 {
        let bit = |corner: u8| u8::from(self.are_beside(ALL_CORNERS & !(1 << corner))) << corner;
        bit(0) | bit(1) | bit(2) | bit(3)
    }

    /// The faces whose lines in the plane do not meet that of this face within the tetrahedron: the plane misses their common edge.
    pub fn disjoint_faces(self, face: usize) -> u8 {
        let bit = |corner: u8| {
            u8::from(self.are_beside(ALL_CORNERS & !(1 << face | 1 << corner))) << corner
        };
        bit(0) | bit(1) | bit(2) | bit(3)
    }

    /// The sides of the plane on which the tetrahedron has corners.
    fn corner_sides(self) -> u8 {
        let is_above = self.below | self.zero != ALL_CORNERS;
        (if self.below == 0 { 0 } else { BELOW }) | if is_above { ABOVE } else { 0 }
    }

    /// Whether the plane cuts more than a corner of the tetrahedron, once the values that are zero are below, or above.
    fn is_cut(self, is_zero_below: bool) -> bool {
        match self.corner_sides() {
            BELOW => self.zero.count_ones() > 1 && !is_zero_below,
            ABOVE => self.zero.count_ones() > 1 && is_zero_below,
            sides => sides != 0,
        }
    }

    /// Whether the plane touches an edge of the tetrahedron and nothing else of it.
    fn is_touched_at_edge(self) -> bool {
        self.zero.count_ones() == 2 && self.corner_sides() != BELOW | ABOVE
    }

    /// The corners that count as below when the tetrahedron is sliced: not those on the plane, unless the plane touches
    /// it from below.
    pub fn sliced_below(self) -> u8 {
        if self.below == 0 {
            self.zero
        } else {
            self.below
        }
    }

    /// The faces that lie in the plane: bit k for the face opposite to corner k.
    pub fn faces_in_plane(self) -> u8 {
        match ALL_CORNERS & !self.zero {
            0 => ALL_CORNERS,
            opposite if opposite.is_power_of_two() => opposite,
            _ => 0,
        }
    }
}

/// How much of a contact polygon counts: the mean of what the plane cuts ahead of a small change and behind it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Weight {
    is_ahead: bool,
    is_behind: bool,
    /// Whether the plane touches one of the tetrahedra along an edge: there is no area, but moved to one side the plane cuts
    /// a strip there.
    is_line: bool,
}

impl Weight {
    const WHOLE: Self = Self {
        is_ahead: true,
        is_behind: true,
        is_line: false,
    };

    /// The factor of integrals over the polygon: 0, ½ or 1.
    pub fn area(self) -> f64 {
        if self.is_line { 0.0 } else { self.mean() }
    }

    /// 1 where it counts and 0 where it does not: ahead of the change, and behind it.
    pub fn ways(self) -> [f64; 2] {
        [self.is_ahead, self.is_behind].map(|is_there| f64::from(u8::from(is_there)))
    }

    /// The mean of ahead and behind, a line counting as the strip that it opens into.
    pub fn mean(self) -> f64 {
        let [ahead, behind] = self.ways();
        0.5 * (ahead + behind)
    }

    fn has_area(self) -> bool {
        self.is_there() && !self.is_line
    }

    fn is_there(self) -> bool {
        self.is_ahead || self.is_behind
    }

    /// From signs before a small change in which p_A − p_B grows at these rates, at the corners of A and at those of B: values
    /// that are zero have the sign of their rate ahead of the change, and the other sign behind it.
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

/// How much of a contact polygon counts where faces, edges or corners lie in the plane: the mean of both sides of the
/// coincidence.
///
/// Where faces of both bodies lie in the plane, values and motions have different sides: as a modulus changes, the plane
/// leaves both faces on the same side; as a body moves, it may stay between them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Weights {
    /// In values, and in all derivatives but those by a motion.
    pub still: Weight,
    /// In derivatives by a motion.
    pub moving: Weight,
}

impl Weights {
    /// Of a polygon that counts wholly in everything.
    pub const WHOLE: Self = Self {
        still: Weight::WHOLE,
        moving: Weight::WHOLE,
    };

    /// From signs of p_A − p_B at the corners of both tetrahedra, and the gradients of both pressures.
    pub fn of(signs: [CornerSigns; 2], [gradient_a, gradient_b]: [&Vector3<f64>; 2]) -> Self {
        let still = Weight::of(signs, [-1.0; 2]);
        let has_zero = signs.iter().any(|signs| signs.zero != 0);
        let moving = if has_zero {
            // How p_A − p_B grows as B moves: A's corners stay, and B's move along.
            Weight::of(
                signs,
                [gradient_b.dot(&PERTURBATION), gradient_a.dot(&PERTURBATION)],
            )
        } else {
            still
        };
        Self { still, moving }
    }

    /// Where faces on the surfaces of both bodies lie in the plane: the bodies may only touch, and motions count as moduli do.
    pub fn of_touching(signs: [CornerSigns; 2]) -> Self {
        let still = Weight::of(signs, [-1.0; 2]);
        Self {
            still,
            moving: still,
        }
    }

    /// Whether the whole polygon counts in everything.
    pub fn are_whole(self) -> bool {
        self == Self::WHOLE
    }

    /// Whether the area counts in values.
    pub fn has_still_area(self) -> bool {
        self.still.has_area()
    }

    /// Whether the area counts in anything.
    pub fn have_area(self) -> bool {
        self.still.has_area() || self.moving.has_area()
    }

    /// Whether the polygon counts in nothing.
    pub fn are_none(self) -> bool {
        !self.still.is_there() && !self.moving.is_there()
    }
}
