use super::ContactBody;
use super::equilibrium::SNAP;
use crate::broad_phase::Shape;
use crate::geometry::{AffineField, Tetrahedron, Tolerance};
use crate::mesh::FieldTet;
use crate::scalar::{Scalar, real_part};
use crate::spatial::Pose;

/// The `f64` shadow of a body pair, in A's frame: what every decision is made on.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RelativePair<'a> {
    pub shapes: [&'a Shape; 2],
    /// Hydroelastic moduli (Pa).
    pub moduli: [f64; 2],
    pub pose_ab: Pose<f64>,
    /// What counts as zero as a distance (m).
    pub tolerance: Tolerance,
}

/// A tetrahedron of B in A's frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PosedTet {
    pub index: usize,
    pub tetrahedron: Tetrahedron,
    /// Pressure at each corner (Pa).
    pub pressures: [f64; 4],
    pub pressure: AffineField,
    /// What the rounding of a coordinate can make of the pressure (Pa/m).
    pub sensitivity: f64,
    /// The barycentric coordinates: field k is 0 on the face opposite to corner k, positive inside.
    pub faces: [AffineField; 4],
}

impl<'a> RelativePair<'a> {
    pub fn of<T: Scalar>(
        a: &ContactBody<'a, T>,
        b: &ContactBody<'a, T>,
        pose_ab: &Pose<T>,
    ) -> Self {
        let moduli = [a, b].map(|body| real_part(body.modulus()));
        // The coordinates involved are as large as the bodies reach from their frames' origins.
        let margin = SNAP * (a.shape().field().reach() + b.shape().field().reach());
        Self {
            shapes: [a.shape(), b.shape()],
            moduli,
            pose_ab: pose_ab.real(),
            tolerance: Tolerance::new(margin),
        }
    }

    /// The same pair, with faces within 2^octaves margins of each other taken for coincident.
    pub fn with_near_coincidences(self, octaves: i32) -> Self {
        Self {
            tolerance: self.tolerance.widened(octaves),
            ..self
        }
    }

    pub fn tet_a(&self, index: usize) -> &'a FieldTet {
        &self.shapes[0].field().tets()[index]
    }

    pub fn tet_b(&self, index: usize) -> &'a FieldTet {
        &self.shapes[1].field().tets()[index]
    }

    /// What counts as zero as a distance (m).
    pub fn margin(&self) -> f64 {
        self.tolerance.zero
    }

    /// A tetrahedron of B as A sees it.
    pub fn posed_tet(&self, index: usize) -> PosedTet {
        let (tet, modulus, pose_ab) = (self.tet_b(index), self.moduli[1], &self.pose_ab);
        PosedTet {
            index,
            tetrahedron: tet.tetrahedron.posed(pose_ab),
            pressures: tet.extents.map(|extent| extent * modulus),
            pressure: tet.extent.posed(pose_ab).scaled(modulus),
            sensitivity: tet.sensitivity * modulus,
            faces: tet.barycentric.each_ref().map(|field| field.posed(pose_ab)),
        }
    }
}
