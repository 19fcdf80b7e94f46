use crate::lanes::{ROW, Row};
use crate::narrow_phase::{Octet, PosedTet, RelativePair};
use nalgebra::Vector3;

/// Corners that a generic polygon has at the most.
pub(super) const CORNERS: usize = 8;

/// The polygons of an octet by their edges, side by side. Places without a polygon have all corners at the origin.
pub(super) struct Edges {
    /// Corners, counter-clockwise from the polygon's origin; after the last one the first, as often as there is room.
    pub corners: [[Row; 2]; CORNERS + 1],
    /// For the edge from each corner on, the outward unit normal of the face that it lies in, in A's axes; 0 for edges at A's rim,
    /// where there is no pressure.
    pub normals: [[Row; 3]; CORNERS],
    /// 1 for a face of B, which moves with it, and 0 for one of A.
    pub of_b: [Row; CORNERS],
    /// The most edges that one of the polygons has.
    pub most: usize,
}

impl Edges {
    pub const NONE: Self = Self {
        corners: [[[0.0; ROW]; 2]; CORNERS + 1],
        normals: [[[0.0; ROW]; 3]; CORNERS],
        of_b: [[0.0; ROW]; CORNERS],
        most: 0,
    };

    /// Takes up the polygon at a place of an octet, of these corners.
    pub fn set(
        &mut self,
        (octet, place): (&Octet, usize),
        corners: &[[f64; 2]],
        (pair, tet_b): (&RelativePair, &PosedTet),
    ) {
        for (index, rows) in self.corners.iter_mut().enumerate() {
            let corner = corners.get(index).unwrap_or(&corners[0]);
            rows[0][place] = corner[0];
            rows[1][place] = corner[1];
        }
        let [tet_a, _] = octet.tets()[place];
        let a = pair.tet_a(tet_a as usize);
        let mut edge = 0;
        octet.visit_edges(place, |slot, _| {
            let (normal, of_b) = match slot.checked_sub(4) {
                None if a.zero_faces & 1 << slot != 0 => (Vector3::zeros(), 0.0),
                None => {
                    let inward = a.barycentric[slot].gradient;
                    (inward * -a.barycentric_steepness[slot].recip(), 0.0)
                }
                Some(bound) => {
                    let face = usize::from(tet_b.bounds[bound]);
                    let inward = tet_b.faces[face].gradient;
                    (inward * -tet_b.face_steepness[face].recip(), 1.0)
                }
            };
            for axis in 0..3 {
                self.normals[edge % CORNERS][axis][place] = normal[axis];
            }
            self.of_b[edge % CORNERS][place] = of_b;
            edge += 1;
        });
        self.most = self.most.max(corners.len());
    }
}
