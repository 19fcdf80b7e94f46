use super::visited::Visited;
use crate::lanes::ROW;
use crate::narrow_phase::{Cut, Octet, PosedTet, RelativePair};
use std::cell::RefCell;
use std::ops::Range;

thread_local! {
    /// The memory that is not in use: as many as there were searches whose results were in use at the same time.
    static SPARE: RefCell<Vec<Scratch>> = const { RefCell::new(Vec::new()) };
}

/// Memory shrinks when a search uses less than this fraction of it.
const LEAST_USED: f64 = 1.0 / 64.0;

/// Memory never shrinks below the room for this many pairs of tetrahedra.
const LEAST_KEPT: usize = 1024;

/// Pairs that are looked at together, at the most, so that their octets stay in the cache of a core.
const MAX_ROUND: usize = 256 * ROW;

/// Memory that one search leaves to the next in the same thread, so that a search allocates nothing
/// once warm. It carries no information from one to the next.
#[derive(Default)]
pub(super) struct Scratch {
    pub posed_tets: PosedTets,
    /// Nodes of A's tree of triangles, and triangles, for the descent to the boundary.
    pub tree_nodes: Vec<u32>,
    /// The pairs of triangles that may cross at the boundary, by their tetrahedra.
    pub crossings: Vec<[u32; 2]>,
    /// Which pairs of tetrahedra were looked at or are about to be.
    pub visited: Visited,
    /// These pairs, in the order in which they are looked at, and their octets, without the ones that were spilled.
    pub octets: Octets,
    /// Pairs from which the surface may go on over other faces than it seems.
    pub ill_conditioned: Vec<[u32; 2]>,
    /// The cuts of special pairs.
    pub cuts: Vec<Cut>,
    /// The pairs in which the fields are equal, so that there is no plane.
    pub equal: Vec<[usize; 2]>,
}

impl Scratch {
    /// Spare memory of the thread, emptied, or new memory.
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

    /// Leaves the memory to the next search.
    pub fn release(self) {
        // Fails where the thread is ending: the memory is freed then.
        let _ = SPARE.try_with(|spare| spare.borrow_mut().push(self));
    }
}

/// Pairs of tetrahedra in the order in which they were entered, and the octets of those that were looked at.
#[derive(Default)]
pub(super) struct Octets {
    /// The pairs, of which so many were looked at, or are being.
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

    /// The pairs so far: those that are appended will be looked at.
    #[inline]
    pub fn pairs(&mut self) -> &mut Vec<[u32; 2]> {
        &mut self.pairs
    }

    /// Fills octets with the pairs to look at next: no more than a [`MAX_ROUND`], and whole octets only, unless fewer than eight pairs
    /// wait. From now on they count as done.
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

    /// Forgets the octets: their room is used again.
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
