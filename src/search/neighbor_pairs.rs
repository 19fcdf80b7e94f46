use crate::lanes::ROW;
use crate::mesh::OUTSIDE;
use crate::narrow_phase::{Octet, RelativePair};

/// Faces of a pair of tetrahedra: four of A, then four of B.
const FACES: usize = 8;

/// The pairs of tetrahedra across the faces that contact polygons reach.
pub(super) struct NeighborPairs {
    pairs: [[u32; 2]; ROW * FACES],
    len: usize,
}

#[expect(clippy::needless_bitwise_bool, reason = "a lazy operator is a branch")]
impl NeighborPairs {
    /// Returns the pairs across the faces that the polygons of an octet reach, by index and face.
    ///
    /// Writes the pairs across all faces and compacts those that are reached in one loop, because a branch for each face would be
    /// mispredicted.
    pub fn faces_of(octet: &Octet, pair: &RelativePair) -> Self {
        let of_a = pair.shape_a.field().mesh().neighbors();
        let of_b = pair.shape_b.neighbors();
        let mut pairs = [[OUTSIDE; 2]; ROW * FACES];
        let mut reached = [0; ROW];
        for (index, &[tet_a, tet_b]) in octet.tets().iter().enumerate() {
            reached[index] = octet.reached[index].faces;
            let (next_a, next_b) = (of_a[tet_a as usize], of_b[tet_b as usize]);
            for face in 0..4 {
                pairs[FACES * index + face] = [next_a[face], tet_b];
                pairs[FACES * index + 4 + face] = [tet_a, next_b[face]];
            }
        }
        // Bit `FACES·index + face` is for the pair of that index; no more are packed than were looked at.
        let (mut remaining, mut len) = (u64::from_le_bytes(reached), 0);
        while remaining != 0 {
            let [tet_a, tet_b] = pairs[remaining.trailing_zeros() as usize];
            remaining &= remaining - 1;
            pairs[len] = [tet_a, tet_b];
            len += usize::from((tet_a != OUTSIDE) & (tet_b != OUTSIDE));
        }
        Self { pairs, len }
    }

    pub fn pairs(&self) -> &[[u32; 2]] {
        &self.pairs[..self.len]
    }
}
