//! Eight pairs of tetrahedra side by side: the contact polygons of the generic ones, several at a time.

#![expect(
    clippy::needless_range_loop,
    reason = "adapters of iterators take closures, and a closure over lanes may stay a call, compiled for any processor"
)]

mod kernel;
mod outlines;
mod pair_classes;
#[cfg(test)]
mod tests;

pub(crate) use kernel::CutOctets;

use super::cut::{Cut, CutTopology};
use super::{PosedTet, RelativePair};
use crate::geometry::{ConvexPolygon, NEXT_FACES, face_of_slice};
use crate::lanes::space::vector_at;
use crate::lanes::{ROW, Row};
use crate::mesh::FieldTet;

/// Room for the edges of a polygon, by the faces they lie in: the four of A, and up to four of B.
pub(crate) const SLOTS: usize = 8;

/// Up to eight pairs of tetrahedra, and the contact polygons of those that are *generic*: no value by which something is decided
/// is near zero, and the fields are not nearly equal, so that nothing coincides and round-off decides nothing.
///
/// A polygon is in coordinates y of its plane: along the axes e₁ and e₂, n being the third, from one of its
/// corners. All in A's frame. Of a pair without a polygon moments are 0, and everything is finite.
#[derive(Clone)]
#[repr(C, align(64))]
pub(crate) struct Octet {
    /// A corner of each polygon (m).
    pub origin: [Row; 3],
    /// e₁, e₂ and n, the unit normal of the plane of equal pressure, out of B into A.
    pub axes: [[Row; 3]; 3],
    /// The pressure (Pa) at the origin, and how it rises along e₁ and e₂ (Pa/m).
    pub pressure: [Row; 3],
    /// ∇p_A (Pa/m).
    pub gradient_a: [Row; 3],
    /// ∇p_A/|g| and ∇p_B/|g| (see [`EquilibriumPlane`](super::EquilibriumPlane)).
    pub slopes: [[Row; 3]; 2],
    /// 1/|g| (m/Pa), 0 where B is rigid.
    pub inverse_gradient_norm: Row,
    /// ∫ m dA for the monomials m = 1, y₁, y₂, y₁², y₁y₂, y₂².
    pub moments: [Row; 6],
    /// Where the edge of each slot begins, counter-clockwise; at the origin, which is a corner too, where a slot has none.
    pub corners: [[Row; 2]; SLOTS],
    /// Where the edge of each slot ends, in the same way.
    pub ends: [[Row; 2]; SLOTS],
    /// For each of B's `bounds` the slot after which its own comes; −1 where it cuts nothing off.
    after: [Row; 4],
    /// What was found: whole numbers of which the lowest bits are the slots with an edge, then come [`SPECIAL`], from [`BELOW`] on
    /// A's corners below the plane, and from [`OPPOSITE`] on the slots with an edge opposite to the origin. As `f64`, because
    /// lanes know no other numbers.
    codes: Row,
    /// The pairs of tetrahedra, of A and of B.
    tets: [[u32; 2]; ROW],
    len: usize,
    /// Where the contact surface may go on from each pair: the search's to write, once it has looked at the special pairs too.
    pub reached: [ReachedFaces; ROW],
}

/// Where a contact surface may go on from a pair of tetrahedra.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct ReachedFaces {
    /// Bit i for the face of A opposite to corner i, bit 4 + k for the face of B opposite to corner k.
    pub faces: u8,
    /// Whether round-off decided over which faces.
    pub is_ill_conditioned: bool,
    /// Whether the fields are equal over a volume, so that there is no plane to follow.
    pub is_equal: bool,
}

impl ReachedFaces {
    /// Of a pair without a plane.
    pub const EQUAL_FIELDS: Self = Self {
        faces: 0,
        is_ill_conditioned: false,
        is_equal: true,
    };
}

/// As many pairs of an octet as there are lanes.
struct Part<'t> {
    /// The place of the first in the octet.
    first: usize,
    /// The tetrahedra, from that place on to the octet's end.
    a: &'t [&'t FieldTet],
    b: &'t [&'t PosedTet],
}

/// The bit of a code above those for slots: values are near zero. No other is set beside it.
const SPECIAL: u32 = 1 << SLOTS;

/// Above it, the place of the bit for A's first corner: set where the corner is below the plane.
const BELOW: usize = SLOTS + 1;

/// Above these, the place of the bit for the first slot: set where it has an edge that neither begins nor ends at the origin.
const OPPOSITE: usize = BELOW + 4;

impl Octet {
    /// Of no pairs.
    pub fn empty() -> Self {
        let zero = [0.0; ROW];
        Self {
            origin: [zero; 3],
            axes: [[zero; 3]; 3],
            pressure: [zero; 3],
            gradient_a: [zero; 3],
            slopes: [[zero; 3]; 2],
            inverse_gradient_norm: zero,
            moments: [zero; 6],
            corners: [[zero; 2]; SLOTS],
            ends: [[zero; 2]; SLOTS],
            after: [zero; 4],
            codes: zero,
            tets: [[0; 2]; ROW],
            len: 0,
            reached: [ReachedFaces::default(); ROW],
        }
    }

    /// Makes it one of up to eight other pairs. What was found of the ones before stays, as numbers that are finite.
    #[inline]
    pub fn fill_with(&mut self, tets: &[[u32; 2]]) {
        self.len = tets.len();
        self.tets[..self.len].copy_from_slice(tets);
    }

    /// The pairs of tetrahedra.
    pub fn tets(&self) -> &[[u32; 2]] {
        &self.tets[..self.len]
    }

    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a whole number below 2²¹"
    )]
    fn bits(&self, place: usize) -> u32 {
        self.codes[place] as u32
    }

    /// Which slots have an edge.
    fn slots(&self, place: usize) -> u8 {
        self.bits(place).to_le_bytes()[0]
    }

    /// Whether a pair has to be decided by itself, because values are near zero.
    #[inline]
    pub fn is_special(&self, place: usize) -> bool {
        self.bits(place) & SPECIAL != 0
    }

    /// The faces that the polygon of a pair reaches, if it is generic: bits 0 to 3 for those of A, 4 to 7 for those of B.
    #[inline]
    pub fn reached_faces(&self, place: usize, tet_b: &PosedTet) -> u8 {
        let slots = u32::from(self.slots(place));
        // A bound that is none has no edge, and its bit would be beyond the lowest eight.
        let of_b = |bound: usize| (slots >> (4 + bound) & 1) << (4 + tet_b.bounds[bound]);
        let faces = slots & 0xf | of_b(0) | of_b(1) | of_b(2) | of_b(3);
        faces.to_le_bytes()[0]
    }

    /// The slots with an edge that neither begins nor ends at the origin, as bits: with the origin they are the triangles of the
    /// polygon of a pair.
    #[inline]
    pub fn opposite_edges(&self, place: usize) -> u8 {
        (self.bits(place) >> OPPOSITE).to_le_bytes()[0]
    }

    /// How many edges the polygon of a pair has.
    #[inline]
    pub fn edge_count(&self, place: usize) -> u32 {
        self.slots(place).count_ones()
    }

    /// Whether a pair has a polygon.
    pub fn has_polygon(&self, place: usize) -> bool {
        self.moments[0][place] > 0.0
    }

    /// Which pairs have one, as bits.
    #[inline]
    pub fn polygons(&self) -> u8 {
        let mut bits = 0;
        for place in 0..self.len.min(ROW) {
            bits |= u8::from(self.has_polygon(place)) << place;
        }
        bits
    }

    /// The polygon of a pair by itself.
    pub fn cut(&self, place: usize, pair: &RelativePair, tet_b: &PosedTet) -> Cut {
        let [a, b] = self.tets[place].map(|tet| tet as usize);
        let below = self.below(place);
        let topology = CutTopology::generic([pair.tet_a(a), pair.tet_b(b)], pair, tet_b, below);
        Cut {
            tets: [a, b],
            polygon: self.polygon(place, tet_b),
            field_b: tet_b.field,
            topology,
        }
    }

    /// The corners of A below the plane.
    fn below(&self, place: usize) -> u8 {
        (self.bits(place) >> BELOW).to_le_bytes()[0] & 0b1111
    }

    /// The polygon in A's frame, its edges owned by the faces they lie in: bits as of [`Cut::polygon`].
    fn polygon(&self, place: usize, tet_b: &PosedTet) -> ConvexPolygon {
        let origin = vector_at(&self.origin, place);
        let [e1, e2, _] = self.axes.each_ref().map(|axis| vector_at(axis, place));
        let mut polygon = ConvexPolygon::empty();
        self.visit_edges(place, |slot, [y1, y2]| {
            let owner = match slot.checked_sub(4) {
                None => 1 << slot,
                Some(bound) => 1 << (4 + tet_b.bounds[bound]),
            };
            polygon.push(origin + e1 * y1 + e2 * y2, owner);
        });
        polygon
    }

    /// Visits the slots of a polygon's edges, counter-clockwise, and where each edge begins.
    #[inline]
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the numbers of slots"
    )]
    pub fn visit_edges(&self, place: usize, mut visit: impl FnMut(usize, [f64; 2])) {
        let slots = self.slots(place);
        let below = usize::from(self.below(place));
        let mut next = [0; SLOTS];
        next[..4].copy_from_slice(&NEXT_FACES[below]);
        // What each bound of B cut off, in the order in which they clipped, its edge takes the place of.
        for bound in 0..4 {
            let after = self.after[bound][place];
            if after >= 0.0 {
                let left = after as usize % SLOTS;
                next[4 + bound] = next[left];
                next[left] = 4 + bound;
            }
        }
        // Faces of A whose edges were dropped are passed all the same: the round of slots is closed.
        let first = face_of_slice(below);
        let mut slot = first;
        loop {
            if slots & 1 << slot != 0 {
                visit(slot, self.corners[slot].map(|row| row[place]));
            }
            slot = next[slot];
            if slot == first {
                break;
            }
        }
    }
}
