use crate::narrow_phase::{Cut, PosedTet, RelativePair};
use rustc_hash::FxHashSet;
use std::cell::RefCell;

thread_local! {
    /// The memory that is not in use: as many as there were searches whose results were in use at the same time.
    static SPARE: RefCell<Vec<Scratch>> = const { RefCell::new(Vec::new()) };
}

/// Memory shrinks when a search uses less than this fraction of it.
const LEAST_USED: f64 = 1.0 / 64.0;

/// Memory never shrinks below the room for this many pairs of tetrahedra.
const LEAST_KEPT: usize = 1024;

/// Memory that one search leaves to the next in the same thread, so that a search allocates nothing
/// once warm. It carries no information from one to the next.
#[derive(Default)]
pub(super) struct Scratch {
    pub posed_tets: PosedTets,
    /// The pairs of tetrahedra that were looked at or are about to be.
    pub visited: FxHashSet<u64>,
    /// The pairs to look at next.
    pub frontier: Vec<[u32; 2]>,
    /// The pairs to look at after those.
    pub next_frontier: Vec<[u32; 2]>,
    /// Pairs from which the surface may go on over other faces than it seems.
    pub doubtful: Vec<[u32; 2]>,
    /// For each pair of the frontier, over which faces the surface may go on.
    pub exits: Vec<Exits>,
    /// What was found.
    pub cuts: Vec<Cut>,
    /// The pairs in which the fields are equal, so that there is no plane.
    pub equal: Vec<[usize; 2]>,
}

/// Where a contact surface may go on from a pair of tetrahedra.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Exits {
    /// Bit i for the face of A opposite to corner i, bit 4 + k for the face of B opposite to corner k.
    pub faces: u8,
    /// Whether round-off decided over which faces.
    pub is_ill_conditioned: bool,
    /// Whether the fields are equal over a volume, so that there is no plane to follow.
    pub is_equal: bool,
}

impl Exits {
    /// Of a pair without a plane.
    pub const EQUAL_FIELDS: Self = Self {
        faces: 0,
        is_ill_conditioned: false,
        is_equal: true,
    };
}

impl Scratch {
    /// Spare memory of the thread, emptied, or new memory.
    pub fn taken() -> Self {
        let spare = SPARE.with_borrow_mut(Vec::pop);
        let mut scratch = spare.unwrap_or_default();
        let used = scratch.visited.len().max(LEAST_KEPT) as f64;
        if used < LEAST_USED * scratch.visited.capacity() as f64 {
            scratch = Self::default();
        }
        scratch.posed_tets.clear();
        scratch.visited.clear();
        scratch.next_frontier.clear();
        scratch.doubtful.clear();
        scratch.cuts.clear();
        scratch.equal.clear();
        scratch
    }

    /// Leaves the memory to the next search.
    pub fn left(self) {
        // Fails where the thread is ending: the memory is freed then.
        let _ = SPARE.try_with(|spare| spare.borrow_mut().push(self));
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
    pub fn add(&mut self, pair: &RelativePair, index: u32) {
        let index = index as usize;
        if self.places.len() <= index {
            let count = pair.shape_b.cells().len();
            self.places.resize(count, [0; 2]);
        }
        if self.places[index][0] != self.round {
            self.places[index] = [self.round, self.tets.len() as u32];
            self.tets.push(pair.posed_tet(index));
        }
    }

    /// A tetrahedron of B that was added.
    #[inline]
    pub fn get(&self, index: u32) -> &PosedTet {
        let [_, place] = self.places[index as usize];
        &self.tets[place as usize]
    }
}
