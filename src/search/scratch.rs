use crate::narrow_phase::{PosedTet, RelativePair};
use rustc_hash::FxHashSet;
use std::cell::Cell;

thread_local! {
    static SCRATCH: Cell<Option<Box<Scratch>>> = const { Cell::new(None) };
}

/// Memory is given back where the last search used less than one part in so many of it,
const MOST_SPARE: usize = 64;

/// but not below what so many pairs of tetrahedra take.
const LEAST_KEPT: usize = 1024;

/// Memory that one search leaves to the next in the same thread, so that a search allocates nothing
/// once its like has been made. It carries no information from one to the next.
#[derive(Default)]
pub(super) struct Scratch {
    pub posed_tets: PosedTets,
    /// The pairs of tetrahedra that were looked at or are about to be.
    pub visited: FxHashSet<u64>,
    /// The pairs to look at next.
    pub wave: Vec<[u32; 2]>,
    /// The pairs to look at after those.
    pub next_wave: Vec<[u32; 2]>,
    /// For each pair of the wave, over which faces the surface may go on.
    pub ways_on: Vec<WayOn>,
}

/// Where a contact surface may go on from a pair of tetrahedra.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct WayOn {
    /// Bit i for the face of A opposite to corner i, bit 4 + k for the face of B opposite to corner k.
    pub faces: u8,
    /// Whether it may go on elsewhere too.
    pub is_uncertain: bool,
}

impl WayOn {
    /// Anywhere.
    pub const UNKNOWN: Self = Self {
        faces: 0,
        is_uncertain: true,
    };
}

impl Scratch {
    /// Lends the thread's scratch memory. A search within a search gets memory of its own.
    pub fn lent<R>(search: impl FnOnce(&mut Self) -> R) -> R {
        let mut scratch = SCRATCH.take().unwrap_or_default();
        if scratch.visited.capacity() > MOST_SPARE * scratch.visited.len().max(LEAST_KEPT) {
            *scratch = Self::default();
        }
        scratch.posed_tets.clear();
        scratch.visited.clear();
        scratch.next_wave.clear();
        let result = search(&mut scratch);
        SCRATCH.set(Some(scratch));
        result
    }
}

/// The tetrahedra of B that A has seen, each transformed once.
#[derive(Default)]
pub(super) struct PosedTets {
    tets: Vec<PosedTet>,
    /// For each tetrahedron of B the round in which it was transformed, and its place in `tets`.
    places: Vec<[u32; 2]>,
    round: u32,
}

impl PosedTets {
    fn clear(&mut self) {
        self.tets.clear();
        self.round = self.round.wrapping_add(1);
        if self.round == 0 {
            self.places.clear();
            self.round = 1;
        }
    }

    /// Transforms a tetrahedron of B, unless it has been.
    #[inline]
    pub fn add(&mut self, shadow: &RelativePair, index: u32) {
        let index = index as usize;
        if self.places.len() <= index {
            let count = shadow.shapes[1].field().tets().len();
            self.places.resize(count, [0; 2]);
        }
        if self.places[index][0] != self.round {
            self.places[index] = [self.round, self.tets.len() as u32];
            self.tets.push(shadow.posed_tet(index));
        }
    }

    /// A tetrahedron of B that was added.
    #[inline]
    pub fn get(&self, index: u32) -> &PosedTet {
        let [_, place] = self.places[index as usize];
        &self.tets[place as usize]
    }
}
