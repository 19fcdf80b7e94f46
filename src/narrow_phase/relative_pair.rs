use super::equilibrium::SNAP;
use crate::contact_shape::{ContactBody, Partner, PartnerShape, Shape};
use crate::geometry::{AffineField, Tetrahedron, Tolerance};
use crate::mesh::FieldTet;
use crate::scalar::{Scalar, lift, real_part};
use crate::spatial::Pose;
use nalgebra::Vector3;

/// A pair of bodies in `f64`, in A's frame. All decisions use it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RelativePair<'a> {
    pub shape_a: &'a Shape,
    pub shape_b: PartnerShape<'a>,
    cells_b: &'a [FieldTet],
    /// Factors of the extents in the two fields that are equal on the plane: the hydroelastic moduli (Pa). If B is rigid, they are 0 and
    /// 1, because the plane is where the depth in B (m) is zero.
    pub scales: [f64; 2],
    /// The hydroelastic modulus of A (Pa).
    pub modulus_a: f64,
    pub pose_ab: Pose<f64>,
    /// The distances (m) that count as zero, or as nearly zero.
    pub tolerance: Tolerance,
}

/// A tetrahedron of B in A's frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PosedTet {
    pub index: usize,
    pub tetrahedron: Tetrahedron,
    /// The pressure (Pa), or, in a rigid body, the depth (m): at each corner, and as a function of position.
    pub values: [f64; 4],
    pub field: AffineField,
    /// Bound on the change of the field per rounding error of a coordinate (Pa/m, or 1 for a rigid body).
    pub sensitivity: f64,
    /// Norm of the field's gradient.
    pub steepness: f64,
    /// Barycentric coordinates: field k is zero on the face opposite to corner k, and positive inside. After them, at
    /// [`NO_FACE`], a field that is 1 everywhere and so bounds nothing.
    pub faces: [AffineField; 5],
    /// The norms of their gradients (1/m).
    pub face_steepness: [f64; 5],
    /// The faces that may bound a polygon: all faces but those at which B's field is zero. After them [`NO_FACE`].
    pub bounds: [u8; 4],
    /// Number of faces that may bound a polygon.
    pub bound_count: usize,
}

/// Marks that a tetrahedron has no further face that may bound a polygon.
const NO_FACE: u8 = 4;

/// The field of no face.
const EVERYWHERE: AffineField = AffineField {
    gradient: Vector3::new(0.0, 0.0, 0.0),
    offset: 1.0,
};

impl<'a> RelativePair<'a> {
    pub fn of<T: Scalar>(a: &ContactBody<'a, T>, b: &Partner<'a, T>, pose_ab: &Pose<T>) -> Self {
        let (shape_b, pose_ab) = (b.partner_shape(), pose_ab.real());
        // Coordinates are at most as large as the distances of the bodies' points from the origins of their frames.
        let margin = SNAP * (a.shape().field().reach() + shape_b.reach(&pose_ab));
        Self {
            shape_a: a.shape(),
            shape_b,
            cells_b: shape_b.cells(),
            scales: scales(a, b).map(real_part),
            modulus_a: real_part(a.modulus()),
            pose_ab,
            tolerance: Tolerance::new(margin),
        }
    }

    /// Returns the pair with faces counted as coincident if they are within 2^octaves margins of each other.
    pub fn with_near_coincidences(self, octaves: i32) -> Self {
        Self {
            tolerance: self.tolerance.widened(octaves),
            ..self
        }
    }

    pub fn tet_a(&self, index: usize) -> &'a FieldTet {
        &self.shape_a.field().tets()[index]
    }

    /// A tetrahedron of B, or the cell of a triangle or of a half-space.
    pub fn tet_b(&self, index: usize) -> &'a FieldTet {
        &self.cells_b[index]
    }

    /// The distance (m) that counts as zero.
    pub fn margin(&self) -> f64 {
        self.tolerance.zero
    }

    /// Returns a tetrahedron of B in A's frame.
    pub fn posed_tet(&self, index: usize) -> PosedTet {
        let (tet, scale, pose_ab) = (self.tet_b(index), self.scales[1], &self.pose_ab);
        let posed = |face: usize| tet.barycentric[face].posed(pose_ab);
        let [n0, n1, n2, n3] = tet.barycentric_steepness;
        // Compaction without branches: each face is written, and the next place is used only if it is kept.
        let (mut bounds, mut bound_count) = ([NO_FACE; 4], 0);
        for face in 0..4_u8 {
            bounds[bound_count] = face;
            bound_count += usize::from(tet.zero_faces & 1 << face == 0);
        }
        bounds[bound_count..].fill(NO_FACE);
        PosedTet {
            index,
            tetrahedron: tet.tetrahedron.posed(pose_ab),
            values: tet.extents.map(|extent| extent * scale),
            field: tet.extent.posed(pose_ab).scaled(scale),
            sensitivity: tet.sensitivity * scale,
            steepness: tet.steepness * scale,
            faces: [posed(0), posed(1), posed(2), posed(3), EVERYWHERE],
            face_steepness: [n0, n1, n2, n3, 0.0],
            bounds,
            bound_count,
        }
    }
}

/// Returns the factors of the extents in the two fields that are equal on the plane (see [`RelativePair::scales`]).
pub(crate) fn scales<T: Scalar>(a: &ContactBody<T>, b: &Partner<T>) -> [T; 2] {
    let modulus_a = if b.partner_shape().is_rigid() {
        lift(0.0)
    } else {
        a.modulus()
    };
    [modulus_a, b.scale()]
}
