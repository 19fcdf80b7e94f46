use crate::geometry::AffineField;
use crate::scalar::{Scalar, lift, norm};
use nalgebra::Vector3;

/// Values below this fraction of (length × pressure gradient) are round-off: about a hundred times
/// the rounding of one transformed coordinate.
pub(crate) const SNAP: f64 = 3e-14;

/// For derivatives, faces count as coincident if they are within 2^COINCIDENCE margins of each other: 2.5e-10 of the size.
///
/// Derivatives have kinks where sides are flush, and steps where planes nearly coincide. This close to one, the mean of
/// both sides is what a difference over any longer step sees; the next step of a rollout may be on either side. Of faces
/// further apart, the corners are placed to at least one part in 2^COINCIDENCE.
pub(crate) const COINCIDENCE: u32 = 13;

/// The same for the derivatives of the elastic wrench, 2e-12 of the size. These have a kink where surfaces are flush; two
/// opposite flush sides make up for each other if both are cut alike, which round-off must not decide. And for values,
/// where a whole polygon is as near as that to a face: the angle between their planes is not far above round-off, and
/// neighbors on both sides of the face would otherwise both count a part, or neither.
pub(crate) const ELASTIC_COINCIDENCE: u32 = 6;

/// Pressure gradients that differ by less than this fraction of the fields' sensitivity to coordinates count as equal: the
/// fields are equal over a volume. The plane of fields that differ by more is placed to about SNAP/EQUAL_FIELDS = 3e-5 of the bodies' size, or better.
const EQUAL_FIELDS: f64 = 1e-9;

/// Velocity of B (m/s, A's axes) by which faces through a common line or plane leave it one after the other; any generic
/// one will do.
pub(crate) const NUDGE: Vector3<f64> = Vector3::new(0.613, 0.427, -0.665);

/// The plane p_A = p_B of a pair of tetrahedra.
///
/// Both pressures are affine, so p_A − p_B has the constant gradient g = ∇p_A − ∇p_B. The plane is
/// normal to g, and g points to where A's pressure is higher: out of B into A.
///
/// A rigid B is the limit of one whose pressure is ever steeper: ∇p_A/|g| and 1/|g| are 0, and ∇p_B/|g| is −n.
#[derive(Debug, Clone, Copy)]
pub(crate) struct EquilibriumPlane<T> {
    /// n = g/|g|.
    pub normal: Vector3<T>,
    /// Height (m) of the origin of the frame above the plane.
    offset: T,
    /// ∇p_A/|g| and ∇p_B/|g|: as B moves by w, the plane moves by −(∇p_B/|g|)·w along its normal.
    pub slopes: [Vector3<T>; 2],
    /// 1/|g| (m/Pa): as p_B grows by δ, the plane moves by δ/|g|.
    pub yielding: T,
}

impl<T: Scalar> EquilibriumPlane<T> {
    pub fn between(pressure_a: &AffineField<T>, pressure_b: &AffineField<T>) -> Self {
        let gradients = [&pressure_a.gradient, &pressure_b.gradient];
        let gradient = gradients[0] - gradients[1];
        let yielding = norm(&gradient).recip();
        Self {
            normal: gradient * yielding,
            offset: (pressure_a.offset - pressure_b.offset) * yielding,
            slopes: gradients.map(|gradient| gradient * yielding),
            yielding,
        }
    }

    /// Of a rigid B, from the depth in it (m).
    pub fn of_rigid(depth: &AffineField<T>) -> Self {
        Self {
            normal: -depth.gradient,
            offset: -depth.offset,
            slopes: [Vector3::from_element(lift(0.0)), depth.gradient],
            yielding: lift(0.0),
        }
    }

    /// Height (m) of a point above the plane.
    pub fn height_at(&self, point: &Vector3<T>) -> T {
        self.normal.dot(point) + self.offset
    }
}

/// Whether the fields of two tetrahedra with this difference of pressure gradients (Pa/m) are equal over a
/// volume: they have no plane there.
///
/// Measured by the larger of their sensitivities (Pa/m): where all extents of a tetrahedron are alike
/// its gradient is itself round-off, and no measure; nor is the steepest gradient elsewhere in the mesh,
/// where one sliver can make it as large as it likes.
pub(crate) fn is_equal_field(gradient: &Vector3<f64>, sensitivities: [f64; 2]) -> bool {
    let [a, b] = sensitivities;
    gradient.norm_squared() <= (EQUAL_FIELDS * a.max(b)).powi(2)
}

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

    /// Of a tetrahedron with face 3 in the plane, on this side of it.
    pub fn on_face(is_below: bool) -> Self {
        Self {
            below: if is_below { 0b1000 } else { 0 },
            zero: 0b0111,
        }
    }

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

    /// In integrals over the polygon.
    pub fn area(self) -> f64 {
        if self.is_line { 0.0 } else { self.mean() }
    }

    /// Whether it counts ahead and behind, as 1 or 0.
    pub fn ways(self) -> [f64; 2] {
        [self.is_ahead, self.is_behind].map(|is_there| f64::from(u8::from(is_there)))
    }

    /// The mean of both.
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

    /// Values of p_A − p_B that are zero are not zero after the change, and grow at these rates on A and on B.
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

/// How much of a contact polygon counts, each time as the mean of both sides of what is a coincidence.
///
/// Where faces of both bodies lie in the plane, it makes a difference which sides: as a modulus changes the plane leaves
/// both faces on the same side, as a body moves it may stay between them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Weights {
    /// In values, and in all derivatives but those by a motion.
    pub still: Weight,
    /// In derivatives by a motion.
    pub moving: Weight,
}

impl Weights {
    /// From signs of p_A − p_B at the corners of both tetrahedra, and the gradients of both pressures.
    pub fn of(signs: [CornerSigns; 2], [gradient_a, gradient_b]: [&Vector3<f64>; 2]) -> Self {
        let still = Weight::of(signs, [-1.0; 2]);
        let has_zero = signs.iter().any(|signs| signs.zero != 0);
        let moving = if has_zero {
            // How p_A − p_B grows as B moves: A's corners stay, and B's move along.
            Weight::of(signs, [gradient_b.dot(&NUDGE), gradient_a.dot(&NUDGE)])
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
        self.still == Weight::WHOLE && self.moving == Weight::WHOLE
    }

    /// Whether the area counts in anything.
    pub fn have_area(self) -> bool {
        self.still.has_area() || self.moving.has_area()
    }

    pub fn are_none(self) -> bool {
        !self.still.is_there() && !self.moving.is_there()
    }
}
