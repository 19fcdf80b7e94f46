use crate::geometry::AffineField;
use crate::scalar::Scalar;
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
/// opposite flush sides make up for each other if both are cut alike, which round-off must not decide.
pub(crate) const ELASTIC_COINCIDENCE: u32 = 6;

/// A difference of pressure gradients below this fraction of what the rounding of a coordinate can make of
/// the pressures is none: the two fields are equal over a volume. The plane of fields that differ by more
/// is placed to about SNAP/EQUAL_FIELDS = 3e-5 of the bodies' size, or better.
const EQUAL_FIELDS: f64 = 1e-9;

/// The plane p_A = p_B of a pair of tetrahedra.
///
/// Both pressures are affine, so p_A − p_B has the constant gradient g = ∇p_A − ∇p_B. The plane is
/// normal to g, and g points to where A's pressure is higher: out of B into A.
#[derive(Debug, Clone, Copy)]
pub(crate) struct EquilibriumPlane<T> {
    /// n = g/|g|.
    pub normal: Vector3<T>,
    /// |g| (Pa/m).
    pub steepness: T,
}

impl<T: Scalar> EquilibriumPlane<T> {
    pub fn between(pressure_a: &AffineField<T>, pressure_b: &AffineField<T>) -> Self {
        let gradient = pressure_a.gradient - pressure_b.gradient;
        let steepness = gradient.dot(&gradient).sqrt();
        Self {
            normal: gradient / steepness,
            steepness,
        }
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

    /// The sides of the plane on which the tetrahedron has a section however near to the plane: both if the plane passes
    /// through it, one if it has a face in the plane, none if the plane touches an edge or a corner.
    fn section_sides(self) -> u8 {
        let sides = self.corner_sides();
        if sides == BELOW | ABOVE || self.faces_in_plane() != 0 {
            sides
        } else {
            0
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

/// How much of a contact polygon counts: the mean of what the plane cuts just above and just below.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Weight {
    /// In integrals over the polygon: half for each side of the plane on which both tetrahedra have a section.
    pub area: f64,
    /// In fluxes through its edges: the same, but 1 where the plane touches one of the tetrahedra along an edge. Moved
    /// to one side the plane cuts a strip there, and the owners of the line's two ways add up to half its growth.
    pub edges: f64,
}

impl Weight {
    pub fn of(signs: [CornerSigns; 2]) -> Self {
        let [a, b] = signs;
        let area = 0.5 * f64::from((a.section_sides() & b.section_sides()).count_ones());
        let is_line = area == 0.0
            && a.corner_sides() & b.corner_sides() != 0
            && signs.into_iter().any(CornerSigns::is_touched_at_edge);
        Self {
            area,
            edges: if is_line { 1.0 } else { area },
        }
    }
}
