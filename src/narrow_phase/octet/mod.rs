//! Eight pairs of tetrahedra side by side. The generic ones are cut several at a time.

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

/// Slots for the edges of a polygon, one for each face that may have an edge: four of A, and up to four of B.
pub(crate) const SLOTS: usize = 8;

/// Up to eight pairs of tetrahedra, and the contact polygons of those that are *generic*: no value that decides a branch is near zero,
/// and the fields are not nearly equal. So nothing coincides, and rounding errors decide nothing.
///
/// A polygon has coordinates y along the axes e₁ and e₂ of its plane, from one of its corners. The third axis is the normal n. Everything
/// is in A's frame. For a pair without a polygon the moments are zero, and all numbers are finite.
#[derive(Clone)]
#[repr(C, align(64))]
pub(crate) struct Octet {
    /// A corner of each polygon (m).
    pub origin: [Row; 3],
    /// e₁, e₂ and n, the unit normal of the plane of equal pressure, out of B into A.
    pub axes: [[Row; 3]; 3],
    /// The pressure (Pa) at the origin, and its slopes along e₁ and e₂ (Pa/m).
    pub pressure: [Row; 3],
    /// ∇p_A (Pa/m).
    pub gradient_a: [Row; 3],
    /// ∇p_A/|g| and ∇p_B/|g| (see [`EquilibriumPlane`](super::EquilibriumPlane)).
    pub slopes: [[Row; 3]; 2],
    /// 1/|g| (m/Pa), or 0 if B is rigid.
    pub inverse_gradient_norm: Row,
    /// ∫ m dA for the monomials m = 1, y₁, y₂, y₁², y₁y₂, y₂².
    pub moments: [Row; 6],
    /// The start of the edge of each slot, counter-clockwise. If a slot has no edge, this is the origin, which is also a corner of the
    /// polygon.
    pub corners: [[Row; 2]; SLOTS],
    /// The end of the edge of each slot, in the same way.
    pub ends: [[Row; 2]; SLOTS],
    /// Slot before the slot of each of B's `bounds`, in the order of edges. The entry is −1 if the bound cuts nothing off.
    after: [Row; 4],
    /// The topology as bits of a whole number, stored as `f64` because lanes have no integers. The lowest bits are the slots with an edge,
    /// followed by [`SPECIAL`]. The bits from [`BELOW`] are A's corners below the plane. The bits from [`OPPOSITE`] are the slots with an
    /// edge that does not touch the origin.
    codes: Row,
    /// The pairs of tetrahedra, of A and of B.
    tets: [[u32; 2]; ROW],
    len: usize,
    /// The faces over which the contact surface may continue from each pair. Written by the search, after it has cut the special pairs.
    pub reached: [ReachedFaces; ROW],
}

/// The faces over which a contact surface may continue from a pair of tetrahedra.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct ReachedFaces {
    /// Bit i for the face of A opposite to corner i, bit 4 + k for the face of B opposite to corner k.
    pub faces: u8,
    /// Whether `faces` depends on rounding errors.
    pub is_ill_conditioned: bool,
    /// Whether the fields are equal over a volume, so that there is no plane.
    pub is_equal: bool,
}

impl ReachedFaces {
    /// The result for a pair without a plane.
    pub const EQUAL_FIELDS: Self = Self {
        faces: 0,
        is_ill_conditioned: false,
        is_equal: true,
    };
}

/// The pairs of an octet that are in the lanes.
struct Part<'t> {
    /// The position of the first pair in the octet.
    first: usize,
    /// The tetrahedra from this position to the end of the octet.
    a: &'t [&'t FieldTet],
    b: &'t [&'t PosedTet],
}

/// The bit of a code above the bits of slots. It means that a value is near zero. No other bit is set then.
const SPECIAL: u32 = 1 << SLOTS;

/// The bit of A's first corner: set if the corner is below the plane.
const BELOW: usize = SLOTS + 1;

/// The bit of the first slot: set if the slot has an edge that neither begins nor ends at the origin.
const OPPOSITE: usize = BELOW + 4;

impl Octet {
    /// Creates an empty octet.
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

    /// Replaces the pairs by up to eight others. The results of the previous pairs stay; they are finite.
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
    fn bits(&self, index: usize) -> u32 {
        self.codes[index] as u32
    }

    /// Returns the slots with an edge, as bits.
    fn slots(&self, index: usize) -> u8 {
        self.bits(index).to_le_bytes()[0]
    }

    /// Returns whether a pair must be cut alone, because values are near zero.
    #[inline]
    pub fn is_special(&self, index: usize) -> bool {
        self.bits(index) & SPECIAL != 0
    }

    /// Returns the faces that the polygon of a generic pair reaches: bits 0 to 3 for faces of A, 4 to 7 for faces of B.
    #[inline]
    pub fn reached_faces(&self, index: usize, tet_b: &PosedTet) -> u8 {
        let slots = u32::from(self.slots(index));
        // A missing bound has no edge, and its bit is above the lowest eight.
        let of_b = |bound: usize| (slots >> (4 + bound) & 1) << (4 + tet_b.bounds[bound]);
        let faces = slots & 0xf | of_b(0) | of_b(1) | of_b(2) | of_b(3);
        faces.to_le_bytes()[0]
    }

    /// Returns the slots with an edge that neither begins nor ends at the origin, as bits. With the origin, these edges form the triangles
    /// of the polygon of a pair.
    #[inline]
    pub fn opposite_edges(&self, index: usize) -> u8 {
        (self.bits(index) >> OPPOSITE).to_le_bytes()[0]
    }

    /// Returns the number of edges of the polygon of a pair.
    #[inline]
    pub fn edge_count(&self, index: usize) -> u32 {
        self.slots(index).count_ones()
    }

    /// Returns whether a pair has a polygon.
    pub fn has_polygon(&self, index: usize) -> bool {
        self.moments[0][index] > 0.0
    }

    /// Returns the pairs with a polygon, as bits.
    #[inline]
    pub fn polygons(&self) -> u8 {
        let mut bits = 0;
        for index in 0..self.len.min(ROW) {
            bits |= u8::from(self.has_polygon(index)) << index;
        }
        bits
    }

    /// Returns the polygon of a pair as a cut.
    pub fn cut(&self, index: usize, pair: &RelativePair, tet_b: &PosedTet) -> Cut {
        let [a, b] = self.tets[index].map(|tet| tet as usize);
        let below = self.below(index);
        let topology = CutTopology::generic([pair.tet_a(a), pair.tet_b(b)], pair, tet_b, below);
        Cut {
            tets: [a, b],
            polygon: self.polygon(index, tet_b),
            field_b: tet_b.field,
            topology,
        }
    }

    /// Returns the corners of A below the plane, as bits.
    fn below(&self, index: usize) -> u8 {
        (self.bits(index) >> BELOW).to_le_bytes()[0] & 0b1111
    }

    /// Returns the polygon in A's frame. The owner of each edge is the face that contains it, with the bits of [`Cut::polygon`].
    fn polygon(&self, index: usize, tet_b: &PosedTet) -> ConvexPolygon {
        let origin = vector_at(&self.origin, index);
        let [e1, e2, _] = self.axes.each_ref().map(|axis| vector_at(axis, index));
        let mut polygon = ConvexPolygon::empty();
        self.visit_edges(index, |slot, [y1, y2]| {
            let owner = match slot.checked_sub(4) {
                None => 1 << slot,
                Some(bound) => 1 << (4 + tet_b.bounds[bound]),
            };
            polygon.push(origin + e1 * y1 + e2 * y2, owner);
        });
        polygon
    }

    /// Visits the slots of a polygon's edges, counter-clockwise, and the start of each edge.
    #[inline]
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the numbers of slots"
    )]
    pub fn visit_edges(&self, index: usize, mut visit: impl FnMut(usize, [f64; 2])) {
        let slots = self.slots(index);
        let below = usize::from(self.below(index));
        let mut next = [0; SLOTS];
        next[..4].copy_from_slice(&NEXT_FACES[below]);
        // Insert the edge of each bound of B, in clipping order, in place of the part that the bound cut off.
        for bound in 0..4 {
            let after = self.after[bound][index];
            if after >= 0.0 {
                let previous = after as usize % SLOTS;
                next[4 + bound] = next[previous];
                next[previous] = 4 + bound;
            }
        }
        // The list of slots is circular. It includes faces of A whose edges were removed.
        let first = face_of_slice(below);
        let mut slot = first;
        loop {
            if slots & 1 << slot != 0 {
                visit(slot, self.corners[slot].map(|row| row[index]));
            }
            slot = next[slot];
            if slot == first {
                break;
            }
        }
    }
}
