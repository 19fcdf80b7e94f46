use super::scratch::PosedTets;
use crate::narrow_phase::{Cut, Octet, PosedTet, RelativePair};

/// Generic pairs of tetrahedra, with their polygons.
#[derive(Clone, Copy)]
pub(crate) struct GenericPairs<'s> {
    pub octets: &'s [Octet],
    posed_tets: &'s PosedTets,
}

impl<'s> GenericPairs<'s> {
    pub(super) fn new(octets: &'s [Octet], posed_tets: &'s PosedTets) -> Self {
        Self { octets, posed_tets }
    }

    /// Returns a part of the octets.
    pub fn part(self, octets: &'s [Octet]) -> Self {
        Self { octets, ..self }
    }

    /// Returns whether any pair has a polygon.
    pub fn have_polygons(self) -> bool {
        self.octets.iter().any(|octet| octet.polygons() != 0)
    }

    /// Returns the tetrahedron of B of a pair, in A's frame.
    pub fn posed_tet(self, tet_b: u32) -> &'s PosedTet {
        self.posed_tets.get(tet_b)
    }

    /// Returns the cut at an index of an octet, which must have a polygon there.
    pub fn cut(self, octet: &Octet, index: usize, pair: &RelativePair) -> Cut {
        let [_, tet_b] = octet.tets()[index];
        octet.cut(index, pair, self.posed_tet(tet_b))
    }
}
