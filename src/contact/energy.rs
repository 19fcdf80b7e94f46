use super::polygon::PolygonSource;
use crate::geometry::{AffineField, Tetrahedron, snapped};
use crate::mesh::FieldTet;
use crate::narrow_phase::PosedTet;
use crate::scalar::{Scalar, lift, lift_vector};

impl<T: Scalar> PolygonSource<'_, T> {
    /// ∫ min(p_A, p_B) dV (J) over what two tetrahedra have in common.
    ///
    /// A's tetrahedron is cut by B's faces into tetrahedra; over each of them, for the softer body S and
    /// the stiffer one H, ∫ min(p_S, p_H) = ∫ p_S − ∫ over {p_S > p_H} of (p_S − p_H). The other way round
    /// it would be a small difference of large integrals.
    pub fn energy(&self, a: &FieldTet, b: &PosedTet) -> T {
        if a.tetrahedron.is_beyond(&b.faces) || b.tetrahedron.is_beyond(&a.barycentric) {
            return lift(0.0);
        }
        let tet_b = self.pair.tet_b(b.index);
        let faces_b = tet_b
            .barycentric
            .each_ref()
            .map(|face| face.posed(&self.pose_ab));
        let pressure_a = a.extent.lifted().scaled(self.modulus_a);
        let pressure_b = tet_b.extent.posed(&self.pose_ab).scaled(self.modulus_b);
        let (soft, hard) = if self.is_softer(a, b) {
            (pressure_a, pressure_b)
        } else {
            (pressure_b, pressure_a)
        };
        let excess = AffineField {
            gradient: soft.gradient - hard.gradient,
            offset: soft.offset - hard.offset,
        };
        let margin = self.pair.margin();
        // What both gradients make of a coordinate's rounding.
        let tolerance = margin * (self.pair.moduli[0] * a.sensitivity + b.sensitivity);
        let whole = Tetrahedron {
            corners: a.tetrahedron.corners.each_ref().map(lift_vector),
        };
        let mut energy = lift(0.0);
        whole.for_each_part_inside(&faces_b, margin, &mut |part: &Tetrahedron<T>| {
            energy += part.integral(&soft);
            let above = part.clipped(&part.values(&excess, tolerance));
            energy -= above
                .as_slice()
                .iter()
                .map(|p| p.integral(&excess))
                .sum::<T>();
        });
        energy
    }

    /// Whether A's highest pressure in its tetrahedron is at most B's.
    fn is_softer(&self, a: &FieldTet, b: &PosedTet) -> bool {
        let highest = |numbers: &[f64; 4]| numbers.iter().copied().fold(0.0, f64::max);
        self.pair.moduli[0] * highest(&a.extents) <= highest(&b.pressures)
    }
}

impl Tetrahedron<f64> {
    /// Whether one of the faces has the whole tetrahedron on its outer side.
    fn is_beyond(&self, faces: &[AffineField; 4]) -> bool {
        let beyond = |face: &AffineField| self.corners.iter().all(|corner| face.at(corner) <= 0.0);
        faces.iter().any(beyond)
    }
}

impl<T: Scalar> Tetrahedron<T> {
    /// Visits tetrahedra that make up the part of this one where all the fields are ≥ 0.
    fn for_each_part_inside(
        &self,
        fields: &[AffineField<T>],
        margin: f64,
        visit: &mut impl FnMut(&Self),
    ) {
        let Some((field, others)) = fields.split_first() else {
            return visit(self);
        };
        let tolerance = margin * field.real().gradient.norm();
        for part in self.clipped(&self.values(field, tolerance)).as_slice() {
            part.for_each_part_inside(others, margin, visit);
        }
    }

    /// The field's values at the corners; those within the tolerance of zero are zero.
    fn values(&self, field: &AffineField<T>, tolerance: f64) -> [T; 4] {
        self.corners
            .each_ref()
            .map(|corner| snapped(field.at(corner), tolerance))
    }

    /// The integral of an affine field over the tetrahedron: its volume times the mean value.
    fn integral(&self, field: &AffineField<T>) -> T {
        let sum: T = self.corners.iter().map(|corner| field.at(corner)).sum();
        self.signed_volume() * (sum / 4.0)
    }
}
