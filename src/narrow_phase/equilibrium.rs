use crate::geometry::AffineField;
use crate::scalar::Scalar;
use nalgebra::Vector3;

/// Values below this fraction of (length × pressure gradient) are round-off: about a hundred times
/// the rounding of one transformed coordinate.
pub(crate) const SNAP: f64 = 3e-14;

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
    pub fn sides(self) -> Sides {
        Sides {
            below: self.below != 0,
            above: self.below | self.zero != ALL_CORNERS,
        }
    }

    /// Whether the plane and the tetrahedron have more in common than an edge.
    pub fn have_section(self) -> bool {
        self.sides().are_both() || self.faces_in_plane() != 0
    }

    /// The sides of those of its corners that are opposite to the given faces: where the tetrahedron lies if these
    /// faces count as lying in the plane.
    pub fn sides_beyond(self, faces: u8) -> Sides {
        Sides {
            below: self.below & faces != 0,
            above: faces & !(self.below | self.zero) != 0,
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

/// Sides of the equilibrium plane: below, p_A < p_B.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Sides {
    pub below: bool,
    pub above: bool,
}

impl Sides {
    pub fn are_both(self) -> bool {
        self.below && self.above
    }

    pub fn share_one_with(self, other: Self) -> bool {
        (self.below && other.below) || (self.above && other.above)
    }
}
