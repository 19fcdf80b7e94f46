use super::equilibrium::{CornerSigns, Sides, is_equal_field};
use super::relative_pair::{PosedTet, RelativePair};
use crate::geometry::{AffineField, ConvexPolygon, FACES, OnPlane, is_doubtful_value, snapped};
use crate::mesh::FieldTet;
use crate::scalar::Scalar;
use crate::spatial::Pose;
use nalgebra::Vector3;

const ALL_FACES: u8 = 0b1111;

/// What the equilibrium plane has to do with a pair of tetrahedra.
pub(crate) enum Encounter {
    /// Nothing: it misses one of them.
    Apart,
    /// There is none, because the fields are equal over a volume.
    EqualFields,
    /// It passes through both, or touches them, though not always at the same place.
    Crossing(Crossing),
}

/// Where the equilibrium plane passes through both tetrahedra at the same place, in A's frame and
/// decided in `f64`.
pub(crate) struct Meeting {
    /// The tetrahedra, of A and of B.
    pub tets: [usize; 2],
    pub crossing: Crossing,
    /// What is common to the plane and both tetrahedra: a polygon, or less where it only touches.
    pub outline: ConvexPolygon,
    /// B's pressure (Pa).
    pub pressure_b: AffineField,
}

/// How the plane passes a pair of tetrahedra.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Passage {
    /// Through both.
    Through,
    /// In a face of one or of both that lie on the same side of it. The polygon counts by half: moved a little
    /// to that side, the plane passes through both, and moved to the other side it does not. If the face is
    /// shared, the tetrahedra beyond it have the rest.
    InFace,
    /// In flush surfaces of both bodies.
    Flush,
    /// It only touches one of them.
    Touching,
}

/// How the polygon of a meeting is made, so that it can be made again in another scalar.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Crossing {
    /// p_A − p_B (Pa) at A's corners.
    at_a: [f64; 4],
    /// Whether the plane comes so close to a corner, without meeting it, that round-off may have a part
    /// in where it cuts.
    is_doubtful: bool,
    passage: Passage,
    /// How the plane lies to A and to B.
    signs: [CornerSigns; 2],
    /// Where |p_A − p_B| (Pa) counts as zero at A's corners.
    tolerance: f64,
    /// Error of a coordinate (m).
    margin: f64,
    /// The faces of B that may bound the polygon: bit k for the face opposite to corner k.
    bounding_faces: u8,
}

impl RelativePair<'_> {
    /// How a tetrahedron of A and one of B meet. Without `plane_check`, they go through slicing and
    /// clipping even where the plane misses one of them.
    pub fn encounter(&self, a: &FieldTet, b: &PosedTet, plane_check: bool) -> Encounter {
        let (modulus_a, margin) = (self.moduli[0], self.margin());
        // A corner's own pressure is exact; the other field is off by what its gradient makes of the
        // rounding of a coordinate.
        let tolerance = margin * b.sensitivity;
        let at_a = excess_at_corners_of_a(a, modulus_a, &b.pressure, tolerance);
        let signs_a = CornerSigns::of(&at_a);
        if plane_check && !signs_a.are_met() {
            return Encounter::Apart;
        }
        let tolerance_b = margin * modulus_a * a.sensitivity;
        let at_b = self.excess_at_corners_of_b(a, b, tolerance_b);
        let signs_b = CornerSigns::of(&at_b);
        if plane_check && !signs_b.are_met() {
            return Encounter::Apart;
        }
        let gradient = a.extent.gradient * modulus_a - b.pressure.gradient;
        if is_equal_field(&gradient, [modulus_a * a.sensitivity, b.sensitivity]) {
            return Encounter::EqualFields;
        }
        let tet_b = self.tet_b(b.index);
        let flush = has_surface_face(a, signs_a.faces_in_plane())
            && has_surface_face(tet_b, signs_b.faces_in_plane())
            && a.extent.gradient.dot(&b.pressure.gradient) > 0.0;
        Encounter::Crossing(Crossing {
            is_doubtful: at_a
                .iter()
                .any(|&value| is_doubtful_value(value, tolerance))
                || at_b
                    .iter()
                    .any(|&value| is_doubtful_value(value, tolerance_b)),
            at_a,
            passage: if flush {
                Passage::Flush
            } else {
                Passage::of([signs_a, signs_b])
            },
            signs: [signs_a, signs_b],
            tolerance,
            margin,
            // A face in the plane itself does not bound the polygon; nor does one at which B ends, for no
            // pressure of A is below 0.
            bounding_faces: ALL_FACES & !signs_b.faces_in_plane() & !tet_b.zero_faces,
        })
    }

    /// The common part of the plane and both tetrahedra, which may be nothing.
    #[inline]
    pub fn meeting(&self, a: &FieldTet, b: &PosedTet, crossing: Crossing) -> Meeting {
        let steepness = &self.tet_b(b.index).barycentric_steepness;
        let face_of_b = |face: usize| (b.faces[face], steepness[face]);
        let (outline, bounding_faces) =
            crossing.outline(a, &crossing.at_a, face_of_b, OnPlane::Inside);
        Meeting {
            tets: [a.index, b.index],
            crossing: Crossing {
                passage: crossing.passage_of(&outline, bounding_faces),
                bounding_faces,
                ..crossing
            },
            outline,
            pressure_b: b.pressure,
        }
    }

    /// p_A − p_B (Pa) at B's corners, A's field extended beyond its tetrahedron.
    fn excess_at_corners_of_b(&self, a: &FieldTet, b: &PosedTet, tolerance: f64) -> [f64; 4] {
        std::array::from_fn(|i| {
            let pressure_a = self.moduli[0] * a.extent.at(&b.tetrahedron.corners[i]);
            snapped(pressure_a - b.pressures[i], tolerance)
        })
    }
}

impl Meeting {
    /// The outline, made again in another scalar, from A's modulus and B's pressure, by the same cuts. Corners on
    /// a face of B count as inside of it or as outside.
    pub fn outline_in<T: Scalar>(
        &self,
        [a, b]: [&FieldTet; 2],
        (modulus_a, pressure_b): (T, &AffineField<T>),
        pose_ab: &Pose<T>,
        on_face: OnPlane,
    ) -> ConvexPolygon<T> {
        let crossing = &self.crossing;
        let excess = excess_at_corners_of_a(a, modulus_a, pressure_b, crossing.tolerance);
        let face_of_b = |face: usize| {
            let posed = b.barycentric[face].posed(pose_ab);
            (posed, b.barycentric_steepness[face])
        };
        crossing.outline(a, &excess, face_of_b, on_face).0
    }

    /// The faces that the outline reaches, and over which the surface may go on: bit i for the face of A
    /// opposite to corner i, bit 4 + k for the face of B opposite to corner k.
    #[inline]
    pub fn reached_faces(&self) -> u8 {
        if self.outline.corners().is_empty() {
            return 0;
        }
        self.outline.sides() | self.crossing.signs[1].faces_in_plane() << 4
    }

    /// Whether round-off may have decided over a piece of the outline.
    pub fn is_doubtful(&self) -> bool {
        self.crossing.is_doubtful || self.outline.is_doubtful()
    }

    /// Whether the outline is a contact polygon.
    pub fn is_polygon(&self) -> bool {
        self.crossing.passage != Passage::Touching && !self.outline.is_empty()
    }

    /// How much of the outline counts as a contact polygon: half where it lies in a face.
    pub fn weight(&self) -> f64 {
        match self.crossing.passage {
            Passage::Through => 1.0,
            Passage::InFace | Passage::Flush => 0.5,
            Passage::Touching => 0.0,
        }
    }

    /// Whether a face of B met corners that were there before, as it does where faces of both bodies have a line in
    /// common. As a body moves or a modulus changes they leave the face, to either side: the derivative is the
    /// mean of both, in the tetrahedron before the face and in that behind it. Corners at the rim are left out: the
    /// pressure is 0 there, and the first derivatives of wrenches are the same on both sides.
    pub fn has_coincidences(&self) -> bool {
        let is_met = |(corner, sides): (&Vector3<f64>, u8)| {
            sides >> 4 != 0 && self.pressure_b.at(corner) > self.crossing.tolerance
        };
        let is_in_face = self.outline.common_sides() >> 4 != 0;
        self.crossing.passage == Passage::Through
            && !is_in_face
            && self.outline.coincidences().any(is_met)
    }

    /// Whether the outline lies in flush surfaces of both bodies.
    pub fn is_flush(&self) -> bool {
        self.crossing.passage == Passage::Flush
    }
}

impl Passage {
    fn of(signs: [CornerSigns; 2]) -> Self {
        let sides = signs.map(CornerSigns::sides);
        if sides.into_iter().all(Sides::are_both) {
            Self::Through
        } else if signs.into_iter().all(CornerSigns::have_section) {
            Self::in_face(sides)
        } else {
            Self::Touching
        }
    }

    /// In a face of tetrahedra on these sides of the plane.
    fn in_face([a, b]: [Sides; 2]) -> Self {
        if a.share_one_with(b) {
            Self::InFace
        } else {
            Self::Touching
        }
    }
}

impl Crossing {
    /// The passage, once the outline is known: a line in a face of B is the beginning of a polygon on one side of
    /// it or on the other, and counts by half.
    #[inline]
    fn passage_of(&self, outline: &ConvexPolygon, near_faces: u8) -> Passage {
        let [signs_a, signs_b] = self.signs;
        let in_faces = outline.common_sides() >> 4 & near_faces;
        let may_count = self.passage != Passage::Flush && signs_a.have_section();
        if may_count && in_faces != 0 && outline.is_line(self.margin) {
            Passage::in_face([signs_a.sides(), signs_b.sides_beyond(in_faces)])
        } else {
            self.passage
        }
    }

    /// Slices A by the plane and clips the slice by B's faces, given with their steepness. Says which of them came
    /// near it.
    #[inline]
    fn outline<T: Scalar>(
        &self,
        a: &FieldTet,
        excess: &[T; 4],
        face_of_b: impl Fn(usize) -> (AffineField<T>, f64),
        on_face: OnPlane,
    ) -> (ConvexPolygon<T>, u8) {
        let is_above = !self.signs[0].sides().below;
        let upward = if is_above { -1.0 } else { 1.0 };
        let mut polygon = a.tetrahedron.sliced(&excess.map(|value| value * upward));
        if is_above {
            polygon.reverse();
        }
        let mut near_faces = 0;
        for face in 0..4 {
            if self.bounding_faces & 1 << face != 0 && !polygon.corners().is_empty() {
                let (field, steepness) = face_of_b(face);
                let side = 1 << (4 + face);
                let is_near = polygon.clip(&field, self.margin * steepness, side, on_face);
                near_faces |= u8::from(is_near) << face;
            }
        }
        (polygon, near_faces)
    }
}

/// Whether one of these faces of a tetrahedron is part of the surface: the extent is 0 on it.
fn has_surface_face(tet: &FieldTet, faces: u8) -> bool {
    let is_surface = |face: usize| FACES[face].iter().all(|&corner| tet.extents[corner] == 0.0);
    faces != 0 && (0..4).any(|face| faces & 1 << face != 0 && is_surface(face))
}

/// p_A − p_B (Pa) at A's corners.
fn excess_at_corners_of_a<T: Scalar>(
    a: &FieldTet,
    modulus_a: T,
    pressure_b: &AffineField<T>,
    tolerance: f64,
) -> [T; 4] {
    std::array::from_fn(|i| {
        let corner = &a.tetrahedron.corners[i];
        snapped(
            modulus_a * a.extents[i] - pressure_b.at_constant(corner),
            tolerance,
        )
    })
}
