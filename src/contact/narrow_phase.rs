use super::equilibrium::{EquilibriumPlane, RoundOff, straddles};
use crate::geometry::{AffineField, ConvexPolygon, FACES, PolygonMoments, Tetrahedron, snapped};
use crate::mesh::FieldTet;
use crate::scalar::{Scalar, carries_derivatives, real_part};
use crate::spatial::Pose;
use std::cell::OnceCell;

/// Bounds on how far p_A may miss the pressure of a level face of B, relative to that pressure,
/// and the face still be left out: the rounding of modulus × extent, with room.
const LEVEL_SLACK: f64 = 1e-13;

/// The narrow phase of one body pair: everything that is the same for all its tetrahedra. All
/// geometry is in A's frame.
pub(super) struct NarrowPhase<T> {
    pub modulus_a: T,
    pub modulus_b: T,
    pub pose_ab: Pose<T>,
    pub real_pose_ab: Pose<f64>,
    pub round_off: RoundOff,
    /// Whether to stop before slicing where the plane misses a tetrahedron.
    pub plane_check: bool,
}

/// The contact polygon of a pair of tetrahedra, in A's frame.
pub(super) struct PairPolygon<T> {
    /// The tetrahedra, of A and of B.
    pub tets: [usize; 2],
    /// Whether it lies in flush surfaces of both bodies: there is no pressure on it, but there will be
    /// on one side or the other as soon as a body moves. It counts by half in the derivatives, which
    /// makes them the mean of the two one-sided ones; these are equal where opposite faces are flush.
    pub flush: bool,
    pub polygon: ConvexPolygon<T>,
    pub plane: EquilibriumPlane<T>,
    pub moments: PolygonMoments<T>,
    pub pressure_a: AffineField<T>,
    pub pressure_b: AffineField<T>,
    /// The pressure on the polygon (Pa): both bodies' fields are the same there, and this is the one
    /// of the smaller gradient, which is rounded less.
    pub pressure: AffineField<T>,
}

/// A tetrahedron of B as A sees it: its real part at once, its derivatives once they are needed.
pub(super) struct TetOfB<'a, T> {
    pub tetrahedron: Tetrahedron,
    pub real: PosedTet<'a, f64>,
    /// Pressure at each corner (Pa).
    pressures: [f64; 4],
    /// What the rounding of a coordinate can make of the pressure (Pa/m).
    sensitivity: f64,
    dual: OnceCell<PosedTet<'a, T>>,
}

/// The fields of a tetrahedron of B in A's frame.
pub(super) struct PosedTet<'a, T> {
    field_tet: &'a FieldTet,
    pose_ab: &'a Pose<T>,
    pub pressure: AffineField<T>,
    faces: OnceCell<[AffineField<T>; 4]>,
}

impl<'a, T: Scalar> PosedTet<'a, T> {
    fn new(field_tet: &'a FieldTet, pose_ab: &'a Pose<T>, modulus: T) -> Self {
        Self {
            field_tet,
            pose_ab,
            pressure: field_tet.extent.posed(pose_ab).scaled(modulus),
            faces: OnceCell::new(),
        }
    }

    /// The barycentric coordinates: field k is 0 on the face opposite to corner k, positive inside.
    pub fn faces(&self) -> &[AffineField<T>; 4] {
        self.faces.get_or_init(|| {
            let barycentric = &self.field_tet.barycentric;
            barycentric
                .each_ref()
                .map(|field| field.posed(self.pose_ab))
        })
    }
}

/// How the equilibrium plane meets a pair of tetrahedra; decided on real parts.
struct Crossing {
    /// Whether it passes through both, by the half-open rule.
    straddled: bool,
    /// Whether it is the common plane of two flush surfaces.
    flush: bool,
    /// Whether it is reached by slicing A from above instead of below.
    from_above: bool,
    /// Where |p_A − p_B| (Pa) counts as zero at A's corners.
    tolerance: f64,
    /// Error of a coordinate (m).
    margin: f64,
    /// The faces of B that bound the polygon.
    clipping_faces: [bool; 4],
}

impl<T: Scalar> NarrowPhase<T> {
    pub fn tet_of_b<'a>(&'a self, field_tet: &'a FieldTet) -> TetOfB<'a, T> {
        let corners = &field_tet.tetrahedron.corners;
        let modulus_b = real_part(self.modulus_b);
        TetOfB {
            tetrahedron: Tetrahedron {
                corners: corners
                    .each_ref()
                    .map(|c| self.real_pose_ab.transformed_point(c)),
            },
            real: PosedTet::new(field_tet, &self.real_pose_ab, modulus_b),
            pressures: field_tet.extents.map(|extent| extent * modulus_b),
            sensitivity: field_tet.sensitivity * modulus_b,
            dual: OnceCell::new(),
        }
    }

    /// The part of the equilibrium plane inside both tetrahedra; `None` where there is none.
    ///
    /// Whether there is one, and which edges and faces make it, is decided in `f64`; only what
    /// survives is evaluated in `T`.
    pub fn polygon<'a>(&'a self, a: &FieldTet, b: &TetOfB<'a, T>) -> Option<PairPolygon<T>> {
        let crossing = self.crossing(a, b)?;
        let outline = crossing.outline(a, real_part(self.modulus_a), &b.real);
        if outline.is_empty() || !crossing.straddled {
            return None;
        }
        let fields_b = self.fields_of_b(b);
        let polygon = if carries_derivatives::<T>() {
            crossing.outline(a, self.modulus_a, fields_b)
        } else {
            outline.lifted()
        };
        let pressure_a = a.extent.lifted().scaled(self.modulus_a);
        let pressure_b = fields_b.pressure;
        let is_a_softer = real_part(self.modulus_a) * a.steepness
            <= real_part(self.modulus_b) * b.real.field_tet.steepness;
        let plane = EquilibriumPlane::between(&pressure_a, &pressure_b);
        let mut moments = polygon.moments(&plane.normal);
        if crossing.flush {
            moments = moments.scaled(0.5);
        }
        // Nothing but round-off is left of a polygon that does not turn about its normal.
        (real_part(moments.area) > 0.0).then_some(PairPolygon {
            tets: [a.index, b.real.field_tet.index],
            flush: crossing.flush,
            polygon,
            plane,
            moments,
            pressure_a,
            pressure_b,
            pressure: if is_a_softer { pressure_a } else { pressure_b },
        })
    }

    /// `None` where the fields are equal over a volume or, with the plane check, where the plane
    /// misses one of the tetrahedra.
    fn crossing(&self, a: &FieldTet, b: &TetOfB<T>) -> Option<Crossing> {
        let modulus_a = real_part(self.modulus_a);
        // A corner's own pressure is exact; the other field is off by what its gradient makes of the
        // rounding of a coordinate.
        let margin = self.round_off.margin();
        let tolerance = margin * b.sensitivity;
        let at_a = excess_at_corners_of_a(a, modulus_a, &b.real, tolerance);
        let may_be_flush = has_surface_face_in_plane(a, &at_a);
        if self.plane_check && !straddles(&at_a) && !may_be_flush {
            return None;
        }
        let at_b = self.excess_at_corners_of_b(a, b, margin * modulus_a * a.sensitivity);
        let flush = may_be_flush
            && has_surface_face_in_plane(b.real.field_tet, &at_b)
            && a.extent.gradient.dot(&b.real.pressure.gradient) > 0.0;
        let straddled = flush || straddles(&at_a) && straddles(&at_b);
        let gradient = a.extent.gradient * modulus_a - b.real.pressure.gradient;
        if (self.plane_check && !straddled) || self.round_off.is_equal_field(&gradient) {
            return None;
        }
        let pressures_a = a.extents.map(|extent| extent * modulus_a);
        Some(Crossing {
            straddled,
            flush,
            from_above: flush && !straddles(&at_a),
            tolerance,
            margin,
            clipping_faces: std::array::from_fn(|face| {
                // A face in the plane itself does not bound the polygon: the half-open rule has
                // decided on which side of it the polygon lies.
                let in_plane = FACES[face].iter().all(|&corner| at_b[corner] == 0.0);
                !in_plane && !b.implies_face(face, &pressures_a)
            }),
        })
    }

    /// Below which |p_A − p_B| (Pa) is round-off anywhere: what both gradients make of a coordinate's.
    pub fn excess_tolerance(&self, a: &FieldTet, b: &TetOfB<T>) -> f64 {
        self.round_off.margin() * (real_part(self.modulus_a) * a.sensitivity + b.sensitivity)
    }

    /// p_A − p_B (Pa) at B's corners, A's field extended beyond its tetrahedron.
    fn excess_at_corners_of_b(&self, a: &FieldTet, b: &TetOfB<T>, tolerance: f64) -> [f64; 4] {
        let modulus_a = real_part(self.modulus_a);
        std::array::from_fn(|i| {
            let pressure_a = modulus_a * a.extent.at(&b.tetrahedron.corners[i]);
            snapped(pressure_a - b.pressures[i], tolerance)
        })
    }

    /// B's fields with their derivatives.
    pub fn fields_of_b<'a, 'b>(&'a self, b: &'b TetOfB<'a, T>) -> &'b PosedTet<'a, T> {
        b.dual
            .get_or_init(|| PosedTet::new(b.real.field_tet, &self.pose_ab, self.modulus_b))
    }
}

impl<T> TetOfB<'_, T> {
    /// Whether every point of the plane inside A's tetrahedron lies on the inner side of a face of
    /// B because of the pressures alone.
    ///
    /// On a *level* face p_B is constant; at the surface it is 0. Inside the face p_B is above (or
    /// below) that level, and on the plane p_B = p_A. So where all of A's corner pressures are on
    /// that side already, clipping would cut nothing; and it must not be tried, because A's own
    /// level face often cuts the plane in the very same line, and which of two equal lines
    /// round-off prefers decides over the derivative.
    fn implies_face(&self, face: usize, pressures_a: &[f64; 4]) -> bool {
        if !self.real.field_tet.level_faces[face] {
            return false;
        }
        let (level, inner) = (self.pressures[FACES[face][0]], self.pressures[face]);
        let slack = LEVEL_SLACK * level.max(inner);
        if (inner - level).abs() <= slack {
            // A plateau: p_B is the same on both sides of the face, and tells nothing of it.
            false
        } else if inner > level {
            pressures_a.iter().all(|&p| p >= level - slack)
        } else {
            pressures_a.iter().all(|&p| p <= level + slack)
        }
    }
}

impl Crossing {
    /// Slices A by the plane and clips the slice by B's faces.
    fn outline<T: Scalar>(&self, a: &FieldTet, modulus_a: T, b: &PosedTet<T>) -> ConvexPolygon<T> {
        let excess = excess_at_corners_of_a(a, modulus_a, b, self.tolerance);
        let mut polygon = if self.from_above {
            a.tetrahedron.sliced(&excess.map(|value| -value)).reversed()
        } else {
            a.tetrahedron.sliced(&excess)
        };
        for (face, field) in b.faces().iter().enumerate() {
            if self.clipping_faces[face] && !polygon.is_empty() {
                let steepness = b.field_tet.barycentric_steepness[face];
                polygon = polygon.clipped(field, self.margin * steepness);
            }
        }
        polygon
    }
}

/// Whether one of a tetrahedron's faces is part of the surface (extent 0) and lies in the plane.
fn has_surface_face_in_plane(tet: &FieldTet, excess: &[f64; 4]) -> bool {
    let in_plane = |&corner: &usize| tet.extents[corner] == 0.0 && excess[corner] == 0.0;
    excess.contains(&0.0) && FACES.iter().any(|face| face.iter().all(in_plane))
}

/// p_A − p_B (Pa) at A's corners.
fn excess_at_corners_of_a<T: Scalar>(
    a: &FieldTet,
    modulus_a: T,
    b: &PosedTet<T>,
    tolerance: f64,
) -> [T; 4] {
    std::array::from_fn(|i| {
        let corner = &a.tetrahedron.corners[i];
        snapped(
            modulus_a * a.extents[i] - b.pressure.at_constant(corner),
            tolerance,
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    /// Round-off of one polygon.
    const EXACT: f64 = 1e-12;

    fn field_tet(corners: [[f64; 3]; 4], extents: [f64; 4]) -> FieldTet {
        let corners = corners.map(Vector3::from);
        FieldTet::new(0, Tetrahedron { corners }, extents)
    }

    /// The pair of the unit tests of the paper's code, which no mesh can hold: a corner of the
    /// surface has pressure.
    #[test]
    fn the_papers_pair_of_tetrahedra_meets_in_its_triangle() {
        let base = [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
        ];
        let a = field_tet(base, [0.0, 0.0, 0.0, 1.0]);
        // Swapped corners: the mirror image of A is turned to positive orientation.
        let top = [
            [1.0, 0.0, 1.8],
            [0.0, 0.0, 1.8],
            [0.0, 1.0, 1.8],
            [0.0, 0.0, 0.8],
        ];
        let b = field_tet(top, [0.0, 0.0, 0.0, 1.0]);
        let narrow_phase = NarrowPhase {
            modulus_a: 1.0,
            modulus_b: 1.0,
            pose_ab: Pose::identity(),
            real_pose_ab: Pose::identity(),
            round_off: RoundOff {
                length: 3.0,
                steepest: 1.0,
            },
            plane_check: true,
        };
        let found = narrow_phase
            .polygon(&a, &narrow_phase.tet_of_b(&b))
            .unwrap();
        let expected = [[0.0, 0.0, 0.9], [0.1, 0.0, 0.9], [0.0, 0.1, 0.9]].map(Vector3::from);
        for corner in expected {
            let is_near = |c: &&Vector3<f64>| (*c - corner).amax() <= EXACT;
            assert_eq!(found.polygon.corners().iter().filter(is_near).count(), 1);
        }
        assert_eq!(found.polygon.corners().len(), 3);
        assert!((found.wrench().force.norm() - 0.0045).abs() <= EXACT);
    }
}
