use crate::geometry::AffineField;
use crate::scalar::{Scalar, lift, norm};
use nalgebra::Vector3;

/// Values below this fraction of (length × pressure gradient) are round-off: about a hundred times
/// the rounding of one transformed coordinate.
pub(crate) const SNAP: f64 = 3e-14;

/// For derivatives, faces count as coincident if they are within 2^COINCIDENCE margins of each other: 2.5e-10 of the size.
///
/// Derivatives have kinks if sides are flush, and jumps if planes nearly coincide. A finite
/// difference over a longer distance gives the mean of both sides, and the next state of a rollout
/// may be on either side. If faces are further apart, the relative error of their corners is at
/// most 2^-COINCIDENCE.
pub(crate) const COINCIDENCE: u32 = 13;

/// For derivatives of the elastic wrench, faces count as coincident if they are within 2^ELASTIC_COINCIDENCE margins of each other: 2e-12
/// of the size. These derivatives have a kink where surfaces are flush. Two opposite flush sides cancel if both are cut alike, which
/// rounding errors must not decide.
///
/// Values use the same tolerance if a whole polygon is this near to a face. Otherwise neighbors on both sides of the face could both
/// count a part of it, or neither.
pub(crate) const ELASTIC_COINCIDENCE: u32 = 6;

/// Pressure gradients that differ by less than this fraction of the fields' sensitivity to coordinates count as equal: the
/// fields are equal over a volume. The plane of fields that differ by more is placed to about SNAP/EQUAL_FIELDS = 3e-5 of the
/// bodies' size, or better.
const EQUAL_FIELDS: f64 = 1e-9;

/// The plane p_A = p_B of a pair of tetrahedra.
///
/// Both pressures are affine, so p_A − p_B has the constant gradient g = ∇p_A − ∇p_B. The plane is
/// normal to g, and g points to where A's pressure is higher: out of B into A.
///
/// A rigid B is the limit of a steep pressure: ∇p_A/|g| and 1/|g| are zero, and ∇p_B/|g| is −n.
#[derive(Debug, Clone, Copy)]
pub(crate) struct EquilibriumPlane<T> {
    /// n = g/|g|.
    pub normal: Vector3<T>,
    /// Height (m) of the origin of the frame above the plane.
    offset: T,
    /// ∇p_A/|g| and ∇p_B/|g|: as B moves by w, the plane moves by −(∇p_B/|g|)·w along its normal.
    pub slopes: [Vector3<T>; 2],
    /// 1/|g| (m/Pa): as p_B grows by δ, the plane moves by δ/|g|.
    pub inverse_gradient_norm: T,
}

impl<T: Scalar> EquilibriumPlane<T> {
    /// Computes the plane between two compliant bodies from their pressures (Pa) in one frame.
    pub fn between(pressure_a: &AffineField<T>, pressure_b: &AffineField<T>) -> Self {
        let gradients = [&pressure_a.gradient, &pressure_b.gradient];
        let gradient = gradients[0] - gradients[1];
        let inverse_gradient_norm = norm(&gradient).recip();
        Self {
            normal: gradient * inverse_gradient_norm,
            offset: (pressure_a.offset - pressure_b.offset) * inverse_gradient_norm,
            slopes: gradients.map(|gradient| gradient * inverse_gradient_norm),
            inverse_gradient_norm,
        }
    }

    /// Computes the plane on a rigid B, where its depth (m) is zero.
    pub fn of_rigid(depth: &AffineField<T>) -> Self {
        Self {
            normal: -depth.gradient,
            offset: -depth.offset,
            slopes: [Vector3::from_element(lift(0.0)), depth.gradient],
            inverse_gradient_norm: lift(0.0),
        }
    }

    /// Returns the height (m) of a point above the plane.
    pub fn height_at(&self, point: &Vector3<T>) -> T {
        self.normal.dot(point) + self.offset
    }
}

/// Returns whether the fields of two tetrahedra with this difference of pressure gradients (Pa/m) are equal over a volume. There is no
/// plane then.
///
/// The difference is compared with the larger sensitivity (Pa/m). The gradient itself is no measure, because it is a rounding error if
/// all extents of a tetrahedron are the same. The largest gradient of the mesh is none either, because one sliver can make it very large.
pub(crate) fn is_equal_field(gradient: &Vector3<f64>, sensitivities: [f64; 2]) -> bool {
    let [a, b] = sensitivities;
    gradient.norm_squared() <= (EQUAL_FIELDS * a.max(b)).powi(2)
}
