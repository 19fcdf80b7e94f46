use crate::contact::loads::LoadedOctet;
use crate::lanes::{ROW, Row};
use crate::narrow_phase::{PosedTet, RelativePair, SLOTS};
use nalgebra::Vector3;

/// Stands for the face of an edge at A's rim.
pub(super) const NO_FACE: u8 = u8::MAX;

/// Up to eight polygons by their edges, side by side, that are integrated by the same rules.
pub(super) struct Edges {
    /// Corners, counter-clockwise from the polygon's origin; after the last one the first, as often as there is room.
    pub corners: [[Row; 2]; SLOTS + 1],
    /// For the edge from each corner on, as many as there are, the outward unit normal of the face that it lies in, in A's axes; 0 for edges at A's rim,
    /// where there is no pressure. Beyond the last edge those of earlier polygons, which count for nothing: such edges have no
    /// length, nor have those of places that are free.
    pub normals: [[Row; 3]; SLOTS],
    /// 1 for a face of B, which moves with it, and 0 for one of A.
    pub of_b: [Row; SLOTS],
    /// The face of each: 0 to 3 of A, 4 to 7 of B, or [`NO_FACE`].
    pub faces: [[u8; ROW]; SLOTS],
    /// How many edges each polygon has.
    pub counts: [usize; ROW],
    /// Octet and place of each; where there is none, of the first.
    pub places: [[usize; 2]; ROW],
    pub len: usize,
}

impl Edges {
    pub const NONE: Self = Self {
        corners: [[[0.0; ROW]; 2]; SLOTS + 1],
        normals: [[[0.0; ROW]; 3]; SLOTS],
        of_b: [[0.0; ROW]; SLOTS],
        faces: [[NO_FACE; ROW]; SLOTS],
        counts: [0; ROW],
        places: [[0; 2]; ROW],
        len: 0,
    };

    /// The most edges that a polygon has of so many places from `first` on.
    #[inline(always)]
    pub fn most(&self, first: usize, count: usize) -> usize {
        let mut most = 0;
        for place in first..first + count {
            most = self.counts[place].max(most);
        }
        most
    }

    /// Makes polygons without an area of the places that are free, where something may be left of others.
    pub fn fill_up(&mut self) {
        for row in self.corners.iter_mut().flatten() {
            row[self.len..].fill(0.0);
        }
        self.counts[self.len..].fill(0);
        let first = self.places[0];
        self.places[self.len..].fill(first);
    }

    /// Adds the polygon at a place, given its tetrahedron of B.
    pub fn push(
        &mut self,
        &LoadedOctet { octet, number, .. }: &LoadedOctet,
        place: usize,
        (pair, tet_b): (&RelativePair, &PosedTet),
    ) {
        let lane = self.len;
        self.places[lane] = [number, place];
        self.len += 1;
        let [tet_a, _] = octet.tets()[place];
        let a = pair.tet_a(tet_a as usize);
        let mut edge = 0;
        octet.visit_edges(place, |slot, [y1, y2]| {
            self.corners[edge % SLOTS][0][lane] = y1;
            self.corners[edge % SLOTS][1][lane] = y2;
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
        self.counts[lane] = edge;
        let first = self.corners[0].map(|row| row[lane]);
        for rows in &mut self.corners[edge.min(SLOTS)..] {
            rows[0][lane] = first[0];
            rows[1][lane] = first[1];
        }
    }
}
