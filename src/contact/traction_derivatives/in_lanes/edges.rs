use super::corners::Corners;
use crate::contact::slip_fields::LoadedOctet;
use crate::lanes::{ROW, Row};
use crate::narrow_phase::{PosedTet, RelativePair, SLOTS};
use nalgebra::Vector3;

/// Stands for the face of an edge at A's boundary.
pub(super) const NO_FACE: u8 = u8::MAX;

/// Up to eight polygons by their edges, side by side, that are integrated by the same rules.
pub(super) struct Edges {
    pub corners: Corners,
    /// For the edge from each corner on, as many as there are, the outward unit normal of the face that it lies in, in A's axes; 0 for edges at A's boundary,
    /// where there is no pressure. Beyond the last edge those of earlier polygons, which count for nothing: such edges have no
    /// length, nor have those of places that are free.
    pub normals: [[Row; 3]; SLOTS],
    /// 1 for a face of B, which moves with it, and 0 for one of A.
    pub of_b: [Row; SLOTS],
    /// The face of each: 0 to 3 of A, 4 to 7 of B, or [`NO_FACE`].
    pub faces: [[u8; ROW]; SLOTS],
    /// Octet and place of each; where there is none, of the first.
    pub places: [[usize; 2]; ROW],
}

impl Edges {
    pub const NONE: Self = Self {
        corners: Corners::NONE,
        normals: [[[0.0; ROW]; 3]; SLOTS],
        of_b: [[0.0; ROW]; SLOTS],
        faces: [[NO_FACE; ROW]; SLOTS],
        places: [[0; 2]; ROW],
    };

    /// Makes polygons without an area of the places that are free, where something may be left of others.
    pub fn fill_up(&mut self) {
        self.corners.fill_up();
        let first = self.places[0];
        self.places[self.corners.len..].fill(first);
    }

    /// Adds the polygon at a place, given its tetrahedron of B.
    pub fn push(
        &mut self,
        &LoadedOctet { octet, number, .. }: &LoadedOctet,
        place: usize,
        (pair, tet_b): (&RelativePair, &PosedTet),
    ) {
        let lane = self.corners.len;
        self.places[lane] = [number, place];
        self.corners.len += 1;
        let [tet_a, _] = octet.tets()[place];
        let a = pair.tet_a(tet_a as usize);
        let mut edge = 0;
        octet.visit_edges(place, |slot, corner| {
            self.corners.set(lane, edge, corner);
            let (normal, face) = match slot.checked_sub(4) {
                None if a.zero_faces & 1 << slot != 0 => (Vector3::zeros(), NO_FACE),
                None => {
                    let inward = a.barycentric[slot].gradient;
                    let outward = inward * -a.barycentric_steepness[slot].recip();
                    (outward, slot.to_le_bytes()[0])
                }
                Some(bound) => {
                    let face = tet_b.bounds[bound];
                    let inward = tet_b.faces[usize::from(face)].gradient;
                    let outward = inward * -tet_b.face_steepness[usize::from(face)].recip();
                    (outward, 4 + face)
                }
            };
            for axis in 0..3 {
                self.normals[edge % SLOTS][axis][lane] = normal[axis];
            }
            let is_of_b = face != NO_FACE && face >= 4;
            self.of_b[edge % SLOTS][lane] = f64::from(u8::from(is_of_b));
            self.faces[edge % SLOTS][lane] = face;
            edge += 1;
        });
        self.corners.close(lane, edge);
    }
}
