use super::equilibrium::straddles;
use super::shadow::{PairShadow, PosedTet};
use crate::geometry::{AffineField, ConvexPolygon, FACES, snapped};
use crate::mesh::FieldTet;
use crate::scalar::Scalar;

/// Bounds on how far p_A may miss the pressure of a level face of B, relative to that pressure,
/// and the face still be left out: the rounding of modulus × extent, with room.
const LEVEL_SLACK: f64 = 1e-13;

/// What the equilibrium plane has to do with a pair of tetrahedra.
pub(super) enum Encounter {
    /// Nothing: it misses one of them, or they have no part of it in common.
    Apart,
    /// There is none, because the fields are equal over a volume.
    EqualFields,
    /// It passes through both at the same place, or touches them there.
    Meeting(Meeting),
}

/// Where the equilibrium plane passes through both tetrahedra, in A's frame, decided in `f64`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Meeting {
    /// The tetrahedra, of A and of B.
    pub tets: [usize; 2],
    pub crossing: Crossing,
    /// What is common to the plane and both tetrahedra: a polygon, or less where it only touches.
    pub outline: ConvexPolygon,
    /// The faces that the outline reaches, and over which the surface may go on: bit i for the face of
    /// A opposite to corner i, bit 4 + k for the face of B opposite to corner k.
    pub sides: u8,
    /// B's pressure (Pa).
    pub pressure_b: AffineField,
    /// Whether the outline is a contact polygon.
    pub is_polygon: bool,
}

/// How the polygon of a meeting is made, so that it can be made again in another scalar.
#[derive(Debug, Clone, Copy)]
pub(super) struct Crossing {
    /// Whether it lies in flush surfaces of both bodies.
    pub flush: bool,
    /// Whether it is reached by slicing A from above instead of below.
    from_above: bool,
    /// Where |p_A − p_B| (Pa) counts as zero at A's corners.
    tolerance: f64,
    /// Error of a coordinate (m).
    margin: f64,
    /// The faces of B that bound the polygon: bit k for the face opposite to corner k.
    bounding_faces: u8,
}

impl PairShadow<'_> {
    /// How a tetrahedron of A and one of B meet. Without `plane_check`, they go through slicing and
    /// clipping even where the plane misses one of them.
    pub fn encounter(&self, a: &FieldTet, b: &PosedTet, plane_check: bool) -> Encounter {
        let (modulus_a, margin) = (self.moduli[0], self.margin());
        // A corner's own pressure is exact; the other field is off by what its gradient makes of the
        // rounding of a coordinate.
        let tolerance = margin * b.sensitivity;
        let at_a = excess_at_corners_of_a(a, modulus_a, &b.pressure, tolerance);
        if plane_check && !is_met(&at_a) {
            return Encounter::Apart;
        }
        let at_b = self.excess_at_corners_of_b(a, b, margin * modulus_a * a.sensitivity);
        if plane_check && !is_met(&at_b) {
            return Encounter::Apart;
        }
        let gradient = a.extent.gradient * modulus_a - b.pressure.gradient;
        if self.round_off.is_equal_field(&gradient) {
            return Encounter::EqualFields;
        }
        let flush = has_surface_face_in_plane(a, &at_a)
            && has_surface_face_in_plane(self.tet_b(b.index), &at_b)
            && a.extent.gradient.dot(&b.pressure.gradient) > 0.0;
        let crossing = Crossing {
            flush,
            from_above: !straddles(&at_a),
            tolerance,
            margin,
            bounding_faces: self.clipping_faces(a, b, &at_b),
        };
        let straddled = straddles(&at_a) && straddles(&at_b);
        self.meeting(a, b, crossing, &at_b).map_or(Encounter::Apart, |meeting| {
            let is_polygon = (flush || straddled) && !meeting.outline.is_empty();
            Encounter::Meeting(Meeting { is_polygon, ..meeting })
        })
    }

    fn meeting(&self, a: &FieldTet, b: &PosedTet, crossing: Crossing, at_b: &[f64; 4]) -> Option<Meeting> {
        let steepness = &self.tet_b(b.index).barycentric_steepness;
        let outline = crossing.outline(a, self.moduli[0], &b.pressure, steepness, |face| b.faces[face]);
        let sides = outline.sides();
        (!outline.corners().is_empty()).then(|| Meeting {
            tets: [a.index, b.index],
            crossing: Crossing {
                bounding_faces: crossing.bounding_faces & (sides >> 4),
                ..crossing
            },
            outline,
            sides: sides | self.touched_faces(b, crossing, &outline, at_b) << 4,
            pressure_b: b.pressure,
            is_polygon: false,
        })
    }

    /// p_A − p_B (Pa) at B's corners, A's field extended beyond its tetrahedron.
    fn excess_at_corners_of_b(&self, a: &FieldTet, b: &PosedTet, tolerance: f64) -> [f64; 4] {
        std::array::from_fn(|i| {
            let pressure_a = self.moduli[0] * a.extent.at(&b.tetrahedron.corners[i]);
            snapped(pressure_a - b.pressures[i], tolerance)
        })
    }

    /// The faces of B that the polygon must be clipped by.
    fn clipping_faces(&self, a: &FieldTet, b: &PosedTet, at_b: &[f64; 4]) -> u8 {
        let pressures_a = a.extents.map(|extent| extent * self.moduli[0]);
        let level_faces = &self.tet_b(b.index).level_faces;
        let is_clipping = |face: usize| {
            // A face in the plane itself does not bound the polygon: the half-open rule has
            // decided on which side of it the polygon lies.
            let is_implied = level_faces[face] && b.implies_face(face, &pressures_a);
            !is_in_plane(face, at_b) && !is_implied
        };
        (0..4).map(|face| u8::from(is_clipping(face)) << face).sum()
    }

    /// The inner faces of B that the outline reaches without being clipped by them.
    fn touched_faces(&self, b: &PosedTet, crossing: Crossing, outline: &ConvexPolygon, at_b: &[f64; 4]) -> u8 {
        let mesh = self.shapes[1].field().mesh();
        let touches = |face: usize| {
            let tolerance = crossing.margin * self.tet_b(b.index).barycentric_steepness[face];
            let reaches = |corner| b.faces[face].at(corner).abs() <= tolerance;
            is_in_plane(face, at_b) || outline.corners().iter().any(reaches)
        };
        (0..4)
            .filter(|&face| crossing.bounding_faces & 1 << face == 0)
            .filter(|&face| mesh.neighbour(b.index, face).is_some())
            .map(|face| u8::from(touches(face)) << face)
            .sum()
    }
}

impl PosedTet {
    /// Whether every point of the plane inside A's tetrahedron lies on the inner side of a level face
    /// of B because of the pressures alone.
    ///
    /// On a *level* face p_B is constant; at the surface it is 0. Inside the face p_B is above (or
    /// below) that level, and on the plane p_B = p_A. So where all of A's corner pressures are on
    /// that side already, clipping would cut nothing; and it must not be tried, because A's own
    /// level face often cuts the plane in the very same line, and which of two equal lines
    /// round-off prefers decides over the derivative.
    fn implies_face(&self, face: usize, pressures_a: &[f64; 4]) -> bool {
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
    pub fn outline<T: Scalar>(
        &self,
        a: &FieldTet,
        modulus_a: T,
        pressure_b: &AffineField<T>,
        steepness: &[f64; 4],
        face_of_b: impl Fn(usize) -> AffineField<T>,
    ) -> ConvexPolygon<T> {
        let excess = excess_at_corners_of_a(a, modulus_a, pressure_b, self.tolerance);
        let mut polygon = if self.from_above {
            a.tetrahedron.sliced(&excess.map(|value| -value)).reversed()
        } else {
            a.tetrahedron.sliced(&excess)
        };
        for face in 0..4 {
            if self.bounding_faces & 1 << face != 0 && !polygon.corners().is_empty() {
                let tolerance = self.margin * steepness[face];
                polygon = polygon.clipped(&face_of_b(face), tolerance, 1 << (4 + face));
            }
        }
        polygon
    }
}

/// Whether the plane passes through a tetrahedron with these (snapped) values of p_A − p_B at its
/// corners, or touches it.
fn is_met(values: &[f64; 4]) -> bool {
    values.iter().any(|&value| value <= 0.0) && values.iter().any(|&value| value >= 0.0)
}

fn is_in_plane(face: usize, excess: &[f64; 4]) -> bool {
    FACES[face].iter().all(|&corner| excess[corner] == 0.0)
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
    pressure_b: &AffineField<T>,
    tolerance: f64,
) -> [T; 4] {
    std::array::from_fn(|i| {
        let corner = &a.tetrahedron.corners[i];
        snapped(modulus_a * a.extents[i] - pressure_b.at_constant(corner), tolerance)
    })
}
