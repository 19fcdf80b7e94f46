use super::integrate::CutSurface;
use super::polygon_source::PolygonSource;
use super::{RigidShape, Shape};
use crate::contact_shape::PartnerShape;
use crate::geometry::{AffineField, Tetrahedron, snapped};
use crate::mesh::FieldTet;
use crate::narrow_phase::PosedTet;
use crate::scalar::{Scalar, lift, lift_vector, real_part};
use nalgebra::Vector3;

/// Position of the apex of the fan over a rigid body's triangles (see [`PolygonSource::energy_behind_triangle`]), from the center of a box,
/// in half diagonals of the box. It is outside the box, in a direction along no axis or diagonal.
const APEX: Vector3<f64> = Vector3::new(1.13, 0.87, -1.41);

/// Bodies overlap if their energy is more than this fraction of the energy that the whole pressure field of a body can hold, the smaller of
/// both. The fraction is far above round-off, and far below the energy of a body inside the other.
const SUNK: f64 = 1e-9;

impl<T: Scalar> PolygonSource<'_, T> {
    /// Returns ∫ min(p_A, p_B) dV (J) over the common volume of A and B, or ∫ p_A dV if B is rigid.
    pub fn energy(&self) -> T {
        let mut energy = lift(0.0);
        match self.pair.shape_b {
            PartnerShape::Compliant(_) => self.pair.visit_overlapping(|tet_a, tet_b| {
                energy += self.energy_of_tets(self.pair.tet_a(tet_a), tet_b);
            }),
            PartnerShape::HalfSpace(_) => {
                let half_space = self.pair.posed_tet(0);
                self.pair
                    .visit_reaching(&half_space, f64::INFINITY, |tet_a| {
                        energy += self.energy_within_half_space(tet_a, &half_space);
                    });
            }
            PartnerShape::Rigid(shape) => {
                let Some(apex) = self.apex(shape) else {
                    return energy;
                };
                for cell in shape.cells() {
                    energy += self.energy_behind_triangle(&cell.tetrahedron, apex);
                }
            }
        }
        energy
    }

    /// Returns whether the energy is more than round-off, so that the bodies overlap.
    pub fn has_energy(&self) -> bool {
        let of_a = most_energy(self.pair.shape_a) * real_part(self.modulus_a);
        let of_b = match self.pair.shape_b {
            PartnerShape::Compliant(shape) => most_energy(shape) * self.pair.scales[1],
            PartnerShape::Rigid(_) | PartnerShape::HalfSpace(_) => f64::INFINITY,
        };
        real_part(self.energy()) > SUNK * of_a.min(of_b)
    }

    /// Returns the energy (J) in the common volume of two tetrahedra. B's faces cut A's tetrahedron into tetrahedra.
    fn energy_of_tets(&self, a: &FieldTet, b: &PosedTet) -> T {
        if are_apart(a, b) {
            return lift(0.0);
        }
        self.smaller_pressure_within(&self.faces_of(b), a, b, b.values)
    }

    /// Returns the barycentric coordinates of a tetrahedron of B in A's frame.
    fn faces_of(&self, b: &PosedTet) -> [AffineField<T>; 4] {
        let faces = self.pair.tet_b(b.index).barycentric.each_ref();
        faces.map(|face| face.posed(&self.pose_ab))
    }

    /// Returns whether a tetrahedron of A and a cell of B have a common volume with pressure.
    fn press(&self, [a, b]: [usize; 2]) -> bool {
        let (a, b) = (self.pair.tet_a(a), self.pair.posed_tet(b));
        if a.is_inert() {
            return false;
        }
        let bounds = match self.pair.shape_b {
            PartnerShape::Compliant(_) if are_apart(a, &b) => return false,
            PartnerShape::Compliant(_) => self.faces_of(&b).to_vec(),
            PartnerShape::HalfSpace(_) => {
                vec![self.pair.tet_b(b.index).extent.posed(&self.pose_ab)]
            }
            PartnerShape::Rigid(_) => return false,
        };
        let mut volume = 0.0;
        let mut add = |part: &Tetrahedron<T>| volume += real_part(part.signed_volume());
        lifted(a).for_each_part_inside(&bounds, self.pair.margin(), &mut add);
        volume > 0.0
    }

    /// Returns the energy (J) in the part of a tetrahedron of A that is in the half-space.
    fn energy_within_half_space(&self, a: &FieldTet, half_space: &PosedTet) -> T {
        let extent = self.pair.tet_b(0).extent.posed(&self.pose_ab);
        if self.pair.shape_b.is_rigid() {
            return self.pressure_within(&[extent], a);
        }
        let corners = a.tetrahedron.corners.each_ref();
        let highest = corners.map(|corner| half_space.field.at(corner));
        self.smaller_pressure_within(&[extent], a, half_space, highest)
    }

    /// Returns the apex of the fan, in the frame of a rigid B, or `None` if the bounding boxes do not overlap. The apex is next to the
    /// intersection of the boxes. So the tetrahedra of the fan contain little more of A than B does, and cancellation is small.
    fn apex(&self, shape_b: &RigidShape) -> Option<Vector3<f64>> {
        let pose_ba = self.pair.pose_ab.inverse();
        let a = self.pair.shape_a.bounds().posed(&pose_ba);
        let common = a.common(&shape_b.bounds())?;
        Some(common.center() + APEX * common.half_extents().norm())
    }

    /// Returns the energy (J) in the tetrahedron between a triangle of a rigid body and the apex. It is negative if the apex is on the
    /// outer side of the triangle. With these signs, the fan of tetrahedra over all triangles is the body.
    fn energy_behind_triangle(&self, cell: &Tetrahedron, apex: Vector3<f64>) -> T {
        let [a, b, c, _] = cell.corners;
        let fan = Tetrahedron {
            corners: [a, b, c, apex],
        };
        let volume = fan.signed_volume();
        if volume == 0.0 {
            return lift(0.0);
        }
        let faces = fan.barycentric_fields();
        let faces = faces.each_ref().map(|face| face.posed(&self.pose_ab));
        let posed = fan.posed(&self.pair.pose_ab);
        let mut energy = lift::<T>(0.0);
        let region = posed.aabb().inflated(self.pair.margin());
        self.pair
            .shape_a
            .tet_bvh()
            .pressing()
            .visit_overlapping(&region, |tet_a| {
                let tet_a = self.pair.tet_a(tet_a);
                if !posed.is_beyond(&tet_a.barycentric) {
                    energy += self.pressure_within(&faces, tet_a);
                }
            });
        energy * volume.signum()
    }

    /// Returns ∫ p_A dV over the part of a tetrahedron of A in which all the fields are ≥ 0.
    fn pressure_within(&self, fields: &[AffineField<T>], a: &FieldTet) -> T {
        let pressure = a.extent.lifted().scaled(self.modulus_a);
        let mut energy = lift(0.0);
        let margin = self.pair.margin();
        lifted(a).for_each_part_inside(fields, margin, &mut |part: &Tetrahedron<T>| {
            energy += part.integral(&pressure);
        });
        energy
    }

    /// Returns ∫ min(p_A, p_B) dV over the part of A's tetrahedron in which all the fields are ≥ 0. The largest of `pressures_b` is a bound
    /// of B's pressure (Pa) there.
    ///
    /// For the softer body S and the harder one H, ∫ min(p_S, p_H) = ∫ p_S − ∫ over {p_S > p_H} of (p_S − p_H). With S and H exchanged, it
    /// would be a small difference of large integrals.
    fn smaller_pressure_within(
        &self,
        fields: &[AffineField<T>],
        a: &FieldTet,
        b: &PosedTet,
        pressures_b: [f64; 4],
    ) -> T {
        let pressure_a = a.extent.lifted().scaled(self.modulus_a);
        let extent_b = &self.pair.tet_b(b.index).extent;
        let [_, modulus_b] = self.moduli();
        let pressure_b = extent_b.posed(&self.pose_ab).scaled(modulus_b);
        let highest = |numbers: &[f64; 4]| numbers.iter().copied().fold(0.0, f64::max);
        let is_softer = self.pair.scales[0] * highest(&a.extents) <= highest(&pressures_b);
        let (soft, hard) = if is_softer {
            (pressure_a, pressure_b)
        } else {
            (pressure_b, pressure_a)
        };
        let excess = AffineField {
            gradient: soft.gradient - hard.gradient,
            offset: soft.offset - hard.offset,
        };
        let margin = self.pair.margin();
        // Rounding-error bound of the difference of both pressures, from the rounding of a coordinate.
        let tolerance = margin * (self.pair.scales[0] * a.sensitivity + b.sensitivity);
        let mut energy = lift(0.0);
        lifted(a).for_each_part_inside(fields, margin, &mut |part: &Tetrahedron<T>| {
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
}

impl<T: Scalar> CutSurface<'_, T> {
    /// Returns whether the pressures of both bodies are equal over a volume.
    pub fn has_equal_fields(&self) -> bool {
        let mut pairs = self.search_result.equal_fields().iter();
        pairs.any(|&cells| self.source.press(cells))
    }
}

/// Returns the energy (J) of a body's whole pressure field, for a modulus of 1 Pa.
fn most_energy(shape: &Shape) -> f64 {
    let tets = shape.field().tets().iter();
    tets.map(|tet| tet.tetrahedron.integral(&tet.extent)).sum()
}

/// Returns whether one of two tetrahedra lies on the outer side of a face of the other.
fn are_apart(a: &FieldTet, b: &PosedTet) -> bool {
    a.tetrahedron.is_beyond(&b.faces[..4]) || b.tetrahedron.is_beyond(&a.barycentric)
}

/// Returns the tetrahedron with corners that are constants in the scalar.
fn lifted<T: Scalar>(tet: &FieldTet) -> Tetrahedron<T> {
    Tetrahedron {
        corners: tet.tetrahedron.corners.each_ref().map(lift_vector),
    }
}

impl Tetrahedron<f64> {
    /// Returns whether the whole tetrahedron is on the outer side of one of the faces.
    fn is_beyond(&self, faces: &[AffineField]) -> bool {
        let beyond = |face: &AffineField| self.corners.iter().all(|corner| face.at(corner) <= 0.0);
        faces.iter().any(beyond)
    }
}

impl<T: Scalar> Tetrahedron<T> {
    /// Visits tetrahedra that make up the part of this one in which all the fields are ≥ 0.
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

    /// Returns the field's values at the corners. Values within the tolerance of zero are zero.
    fn values(&self, field: &AffineField<T>, tolerance: f64) -> [T; 4] {
        self.corners
            .each_ref()
            .map(|corner| snapped(field.at(corner), tolerance))
    }

    /// Returns the integral of an affine field over the tetrahedron: its volume times the mean value.
    fn integral(&self, field: &AffineField<T>) -> T {
        let sum: T = self.corners.iter().map(|corner| field.at(corner)).sum();
        self.signed_volume() * (sum / 4.0)
    }
}
