use super::RelativePair;
use super::equilibrium::is_equal_field;
use super::relative_pair::PosedTet;
use super::weights::{CornerSigns, Weights};
use crate::contact_shape::PartnerShape;
use crate::geometry::{
    ALL_FACES, Aabb, AffineField, ConvexPolygon, NearZeroHistogram, Tolerance, snapped,
};
use crate::mesh::FieldTet;
use crate::scalar::Scalar;
use crate::spatial::Pose;

/// Position of the equilibrium plane relative to a pair of tetrahedra.
pub(crate) enum PairClass {
    /// The plane misses one of the tetrahedra.
    Disjoint,
    /// There is no plane, because the fields are equal over a volume.
    EqualFields,
    /// The plane passes through both tetrahedra or touches them. They may still have no common point in the plane.
    Intersecting(CutTopology),
}

/// The decisions about a polygon, made in `f64`. They determine its construction in any scalar.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CutTopology {
    /// p_A − p_B (Pa) at A's corners.
    at_a: [f64; 4],
    /// Tolerance (Pa) of `at_a`.
    zero: f64,
    /// Corners of A below the plane.
    below: u8,
    /// The faces that lie in the plane, with the bits of the polygon's owners.
    faces_in_plane: u8,
    /// The faces of B that may bound the polygon.
    bounding_faces: u8,
    /// Signs at B's corners, as far as they are known.
    signs_b: CornerSigns,
    weights: Weights,
    is_on_both_surfaces: bool,
    /// Whether the surfaces of the bodies face each other in the plane.
    is_touch: bool,
    closeness: NearZeroHistogram,
}

/// Intersection of the equilibrium plane with two tetrahedra, in A's frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cut {
    /// The tetrahedra, of A and of B.
    pub tets: [usize; 2],
    /// The polygon. It may be degenerate if the plane only touches. Bits 0 to 3 of the owners of its edges are the faces of A opposite to
    /// each corner. Bits 4 to 7 are the faces of B.
    pub polygon: ConvexPolygon,
    /// B's pressure (Pa), or the depth (m) in it if it is rigid.
    pub field_b: AffineField,
    pub(super) topology: CutTopology,
}

impl RelativePair<'_> {
    /// Classifies a tetrahedron of A and one of B. Without `plane_check`, the tetrahedra are sliced and clipped even if the plane misses
    /// one of them.
    pub fn classify(&self, a: &FieldTet, b: &PosedTet, plane_check: bool) -> PairClass {
        let scale_a = self.scales[0];
        // A corner's own pressure is exact. The other field has the error of the rounded coordinates times its gradient.
        let tolerance_a = self.tolerance.scaled(b.sensitivity);
        let excess_a = excess_at_corners_of_a(a, scale_a, &b.field);
        let at_a = excess_a.map(|value| snapped(value, tolerance_a.zero));
        let signs_a = CornerSigns::of(&at_a);
        if plane_check && !signs_a.are_met() {
            return PairClass::Disjoint;
        }
        let (signs_b, closeness_b) = self.signs_at_b(a, b, signs_a);
        if plane_check && !signs_b.are_met() {
            return PairClass::Disjoint;
        }
        let gradient_a = a.extent.gradient * scale_a;
        let gradient = gradient_a - b.field.gradient;
        if is_equal_field(&gradient, [scale_a * a.sensitivity, b.sensitivity]) {
            return PairClass::EqualFields;
        }
        let zero_faces_b = self.tet_b(b.index).zero_faces;
        let [in_plane_a, in_plane_b] = [signs_a, signs_b].map(CornerSigns::faces_in_plane);
        let [ends_a, ends_b] = [in_plane_a & a.zero_faces, in_plane_b & zero_faces_b];
        let is_on_both_surfaces = ends_a != 0 && ends_b != 0;
        let signs = [signs_a, signs_b];
        let signs_of_corners = match self.shape_b {
            PartnerShape::Compliant(_) => signs_b,
            PartnerShape::Rigid(_) | PartnerShape::HalfSpace(_) => CornerSigns::UNKNOWN,
        };
        let missed_faces = signs_of_corners.missed_faces();
        let weights = if is_on_both_surfaces {
            Weights::of_touching(signs)
        } else {
            Weights::of(signs, [&gradient_a, &b.field.gradient])
        };
        PairClass::Intersecting(CutTopology {
            at_a,
            zero: tolerance_a.zero,
            below: signs_a.sliced_below(),
            faces_in_plane: in_plane_a | in_plane_b << 4,
            // Faces in the plane and faces that the plane misses do not bound the polygon. Neither do faces on which B's pressure is
            // zero: A's pressure is never negative, so the polygon ends at A first.
            bounding_faces: ALL_FACES & !in_plane_b & !missed_faces & !zero_faces_b,
            signs_b: signs_of_corners,
            weights,
            is_on_both_surfaces,
            is_touch: is_on_both_surfaces && a.extent.gradient.dot(&b.field.gradient) < 0.0,
            closeness: tolerance_a.closeness_of(&excess_a).or(closeness_b),
        })
    }

    /// Intersects the plane with both tetrahedra. The result may be empty.
    #[inline]
    pub fn cut(&self, a: &FieldTet, b: &PosedTet, topology: CutTopology) -> Cut {
        let face_of_b = |face: usize| (b.faces[face], b.face_steepness[face]);
        Cut {
            tets: [a.index, b.index],
            polygon: topology.polygon(a, &topology.at_a, self.tolerance, face_of_b),
            field_b: b.field,
            topology,
        }
    }

    /// Returns a box (m) around the possible contact polygon of two tetrahedra: around the slice of A, inflated by the error of values that
    /// count as zero, or around A if the plane only touches it. Returns `None` if they do not meet.
    pub fn box_of_polygon(&self, a: &FieldTet, b: &PosedTet) -> Option<Aabb> {
        let PairClass::Intersecting(topology) = self.classify(a, b, true) else {
            return None;
        };
        let (slice, bounds) = (topology.slice(a, &topology.at_a), a.tetrahedron.aabb());
        let of_a = if slice.is_empty() {
            bounds
        } else {
            // No edge is longer than the diagonal.
            let longest = 2.0 * bounds.half_extents().norm();
            let misplacement = self.tolerance.misplacement(topology.closeness);
            Aabb::around(slice.corners()).inflated(misplacement * longest)
        };
        of_a.common(&b.tetrahedron.aabb().inflated(self.margin()))
    }

    /// Returns the signs at the corners of a tetrahedron of B, and their distances from the plane. A partner without tetrahedra has the
    /// signs of a tetrahedron through which the plane passes. If a surface of A is in the plane too, it has the signs of a tetrahedron with
    /// its surface in the plane.
    fn signs_at_b(
        &self,
        a: &FieldTet,
        b: &PosedTet,
        signs_a: CornerSigns,
    ) -> (CornerSigns, NearZeroHistogram) {
        if let PartnerShape::Compliant(_) = self.shape_b {
            let tolerance = self.tolerance.scaled(self.scales[0] * a.sensitivity);
            let excess = self.excess_at_corners_of_b(a, b);
            let values = excess.map(|value| snapped(value, tolerance.zero));
            return (CornerSigns::of(&values), tolerance.closeness_of(&excess));
        }
        let ends = signs_a.faces_in_plane() & a.zero_faces;
        let signs = if ends == 0 {
            CornerSigns::CROSSED
        } else {
            // B's field grows inwards. p_A − p_B does so too if A's field grows more.
            let excess = a.extent.gradient * self.scales[0] - b.field.gradient;
            CornerSigns::on_face(excess.dot(&b.field.gradient) < 0.0)
        };
        (signs, NearZeroHistogram::default())
    }

    /// Returns p_A − p_B (Pa) at B's corners. A's field is extended beyond its tetrahedron.
    fn excess_at_corners_of_b(&self, a: &FieldTet, b: &PosedTet) -> [f64; 4] {
        std::array::from_fn(|i| {
            self.scales[0] * a.extent.at(&b.tetrahedron.corners[i]) - b.values[i]
        })
    }

    /// Returns the polygon of a cut in another scalar, with the same topology. The inputs are the scale of A's field, and B's field.
    pub fn polygon_in<T: Scalar>(
        &self,
        cut: &Cut,
        (scale_a, field_b): (T, &AffineField<T>),
        pose_ab: &Pose<T>,
    ) -> ConvexPolygon<T> {
        let [a, b] = [self.tet_a(cut.tets[0]), self.tet_b(cut.tets[1])];
        let excess = excess_at_corners_of_a(a, scale_a, field_b)
            .map(|value| snapped(value, cut.topology.zero));
        let face_of_b = |face: usize| {
            let posed = b.barycentric[face].posed(pose_ab);
            (posed, b.barycentric_steepness[face])
        };
        cut.topology.polygon(a, &excess, self.tolerance, face_of_b)
    }
}

impl Cut {
    /// Returns the weights of the polygon.
    pub fn weights(&self) -> Weights {
        self.topology.weights
    }

    /// Returns whether the cut adds to an integral or to its derivatives.
    pub fn counts(&self) -> bool {
        !self.topology.weights.are_none() && !self.polygon.is_empty()
    }

    /// Returns whether the cut [counts](Self::counts), or could count after a small change: a rounding error, or an approach of touching
    /// faces.
    pub fn is_noted(&self) -> bool {
        self.counts() || self.is_ill_conditioned() || self.is_touch()
    }

    /// Returns whether surfaces that face each other touch on an area. The pressure is zero, but the derivative jumps when the bodies
    /// approach.
    pub fn is_touch(&self) -> bool {
        self.topology.is_touch && !self.polygon.is_empty()
    }

    /// Returns whether the cut lies on the surfaces of both bodies, which are flush. The pressure is zero until a body moves.
    pub fn is_on_both_surfaces(&self) -> bool {
        self.topology.is_on_both_surfaces
    }

    /// Returns whether rounding errors may have decided about a part of the cut.
    pub fn is_ill_conditioned(&self) -> bool {
        self.closeness().is_ill_conditioned()
    }

    /// Returns the distances of corners from planes.
    pub fn closeness(&self) -> NearZeroHistogram {
        self.topology.closeness.or(self.polygon.closeness())
    }

    /// Returns the distances of the whole polygon from faces of B.
    pub fn coplanarity(&self) -> NearZeroHistogram {
        self.polygon.coplanarity()
    }

    /// Returns the faces that the polygon reaches, over which the surface may continue, with the bits of the owners of its edges.
    #[inline]
    pub fn reached(&self) -> u8 {
        let owners = self.polygon.owners();
        if owners.is_empty() {
            return 0;
        }
        owners.iter().fold(0, |all, edge_owners| all | edge_owners) | self.topology.faces_in_plane
    }
}

impl CutTopology {
    /// Returns the topology of a generic pair, given the corners of A below the plane.
    pub fn generic(
        [a, b]: [&FieldTet; 2],
        pair: &RelativePair,
        tet_b: &PosedTet,
        below: u8,
    ) -> Self {
        Self {
            at_a: excess_at_corners_of_a(a, pair.scales[0], &tet_b.field),
            zero: pair.tolerance.scaled(tet_b.sensitivity).zero,
            below,
            faces_in_plane: 0,
            bounding_faces: ALL_FACES & !b.zero_faces,
            signs_b: CornerSigns::UNKNOWN,
            weights: Weights::WHOLE,
            is_on_both_surfaces: false,
            is_touch: false,
            closeness: NearZeroHistogram::default(),
        }
    }

    /// Slices A by the plane.
    #[inline]
    fn slice<T: Scalar>(&self, a: &FieldTet, excess: &[T; 4]) -> ConvexPolygon<T> {
        a.tetrahedron.sliced_below(self.below.into(), excess)
    }

    /// Slices A by the plane and clips the slice by B's faces, given with the norms of their gradients.
    #[inline]
    fn polygon<T: Scalar>(
        &self,
        a: &FieldTet,
        excess: &[T; 4],
        tolerance: Tolerance,
        face_of_b: impl Fn(usize) -> (AffineField<T>, f64),
    ) -> ConvexPolygon<T> {
        let mut polygon = self.slice(a, excess);
        for face in 0..4 {
            if self.bounding_faces & 1 << face != 0 && !polygon.corners().is_empty() {
                let (field, gradient) = face_of_b(face);
                let disjoint_faces = || self.signs_b.disjoint_faces(face) << 4;
                polygon.clip(
                    &field,
                    tolerance.scaled(gradient),
                    1 << (4 + face),
                    disjoint_faces,
                );
            }
        }
        polygon
    }
}

/// p_A − p_B (Pa) at A's corners.
fn excess_at_corners_of_a<T: Scalar>(a: &FieldTet, scale_a: T, field_b: &AffineField<T>) -> [T; 4] {
    std::array::from_fn(|i| {
        let corner = &a.tetrahedron.corners[i];
        scale_a * a.extents[i] - field_b.at_constant(corner)
    })
}
