use super::visited::Visited;
use crate::lanes::ROW;
use crate::narrow_phase::{Cut, Octet, PosedTet, RelativePair};
use std::cell::RefCell;
use std::ops::Range;

thread_local! {
    /// Unused scratch memory. The list has one entry for each of the search results that were alive
    /// at the same time.
    static SPARE: RefCell<Vec<Scratch>> = const { RefCell::new(Vec::new()) };
}

/// Memory shrinks when a search uses less than this fraction of it.
const LEAST_USED: f64 = 1.0 / 64.0;

/// Memory never shrinks below the room for this many pairs of tetrahedra.
const LEAST_KEPT: usize = 1024;

/// Largest number of pairs that are cut together, so that their octets stay in the cache of a core.
const MAX_ROUND: usize = 256 * ROW;

/// Memory that is reused by the searches of a thread, so that a warm search allocates nothing. It carries no information from one
/// search to the next.
#[derive(Default)]
pub(super) struct Scratch {
    pub posed_tets: PosedTets,
    /// Nodes of A's tree of triangles, and triangles, for the descent to the boundary.
    pub tree_nodes: Vec<u32>,
    /// The pairs of triangles that may cross at the boundary, by their tetrahedra.
    pub crossings: Vec<[u32; 2]>,
    /// Pairs of tetrahedra that were queued.
    pub visited: Visited,
    /// The queue of pairs, and their octets, without those that were spilled.
    pub octets: Octets,
    /// Ill-conditioned pairs: rounding errors decide over which faces the surface continues.
    pub ill_conditioned: Vec<[u32; 2]>,
    /// The cuts of special pairs.
    pub cuts: Vec<Cut>,
    /// The pairs in which the fields are equal, so that there is no plane.
    pub equal: Vec<[usize; 2]>,
}

impl Scratch {
    /// Takes unused memory of the thread, emptied, or new memory.
    pub fn acquire() -> Self {
        let spare = SPARE.with_borrow_mut(Vec::pop);
        let mut scratch = spare.unwrap_or_default();
        let used = scratch.octets.pair_count().max(LEAST_KEPT) as f64;
        if used < LEAST_USED * scratch.octets.pairs.capacity() as f64 {
            scratch = Self::default();
        }
        scratch.posed_tets.clear();
        scratch.visited.clear();
        scratch.octets.clear();
        scratch.ill_conditioned.clear();
        scratch.cuts.clear();
        scratch.equal.clear();
        scratch
    }

    /// Returns the memory to the thread.
    pub fn release(self) {
        // Fails if the thread is ending. The memory is freed then.
        let _ = SPARE.try_with(|spare| spare.borrow_mut().push(self));
    }
}

/// A queue of pairs of tetrahedra, and the octets of those that were cut.
#[derive(Default)]
pub(super) struct Octets {
    /// All pairs. The first `done` of them are cut, or are being cut.
    pairs: Vec<[u32; 2]>,
    done: usize,
    /// Room for octets, of which the first `len` are in use.
    room: Vec<Octet>,
    len: usize,
}

impl Octets {
    fn clear(&mut self) {
        self.pairs.clear();
        (self.done, self.len) = (0, 0);
    }

    /// Returns the pairs. Those that are appended will be cut.
    #[inline]
    pub fn pairs(&mut self) -> &mut Vec<[u32; 2]> {
        &mut self.pairs
    }

    /// Fills octets with the next pairs: at most [`MAX_ROUND`], and whole octets only, unless fewer than eight pairs are queued. From
    /// now on they count as done.
    pub fn next(&mut self) -> Option<(Range<usize>, &mut [Octet])> {
        let waiting = &self.pairs[self.done..];
        let count = if waiting.len() < ROW {
            waiting.len()
        } else {
            waiting.len().min(MAX_ROUND) / ROW * ROW
        };
        let start = self.len;
        for tets in waiting[..count].chunks(ROW) {
            if self.len == self.room.len() {
                self.room.push(Octet::empty());
            }
            self.room[self.len].fill_with(tets);
            self.len += 1;
        }
        self.done += count;
        (count > 0).then(|| (start..self.len, &mut self.room[start..self.len]))
    }

    /// The octets.
    pub fn in_use(&self) -> &[Octet] {
        &self.room[..self.len]
    }

    /// Removes the octets; their memory is reused.
    pub fn forget(&mut self) {
        self.len = 0;
    }

    #[inline]
    pub fn at(&self, index: usize) -> &Octet {
        &self.room[index]
    }

    pub fn are_all_done(&self) -> bool {
        self.done == self.pairs.len()
    }

    /// Number of pairs.
    pub fn pair_count(&self) -> usize {
        self.pairs.len()
    }
}

/// The tetrahedra of B that are in queued pairs, in A's frame, each transformed once.
#[derive(Default)]
pub(super) struct PosedTets {
    tets: Vec<PosedTet>,
    /// For each tetrahedron of B, the search in which it was transformed last, and its index in `tets`.
    indices: Vec<[u32; 2]>,
    round: u32,
}

impl PosedTets {
    fn clear(&mut self) {
        self.tets.clear();
        self.round = self.round.wrapping_add(1);
        if self.round == 0 {
            self.indices.clear();
            self.round = 1;
        }
    }

    /// Transforms a tetrahedron of B, unless it was transformed before.
    #[inline]
    pub fn add(&mut self, pair: &RelativePair, index: u32) {
        let index = index as usize;
        if self.indices.len() <= index {
            let count = pair.shape_b.cells().len();
            self.indices.resize(count, [0; 2]);
        }
        if self.indices[index][0] != self.round {
            self.indices[index] = [self.round, self.tets.len() as u32];
            self.tets.push(pair.posed_tet(index));
        }
    }

    /// Returns a tetrahedron of B that was added.
    #[inline]
    pub fn get(&self, index: u32) -> &PosedTet {
        let [_, posed_index] = self.indices[index as usize];
        &self.tets[posed_index as usize]
    }
}
