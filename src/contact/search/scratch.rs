use crate::contact::shadow::{PairShadow, PosedTet};
use rustc_hash::FxHashSet;
use std::cell::Cell;

thread_local! {
    static SCRATCH: Cell<Option<Box<Scratch>>> = const { Cell::new(None) };
}

/// Memory that one search leaves to the next in the same thread, so that a search allocates nothing
/// once its like has been made. It carries no information from one to the next.
#[derive(Default)]
pub(super) struct Scratch {
    pub posed_tets: PosedTets,
    /// The pairs of tetrahedra that were looked at.
    pub visited: FxHashSet<[u32; 2]>,
    /// Those among them whose neighbours were not.
    pub queue: Vec<[u32; 2]>,
}

impl Scratch {
    /// Lends the thread's scratch memory. A search within a search gets memory of its own.
    pub fn lent<R>(search: impl FnOnce(&mut Self) -> R) -> R {
        let mut scratch = SCRATCH.take().unwrap_or_default();
        scratch.clear();
        let result = search(&mut scratch);
        SCRATCH.set(Some(scratch));
        result
    }

    fn clear(&mut self) {
        self.posed_tets.clear();
        self.visited.clear();
        self.queue.clear();
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

    /// The tetrahedron of B as A sees it.
    #[inline]
    pub fn of(&mut self, shadow: &PairShadow, index: usize) -> &PosedTet {
        if self.places.len() <= index {
            let count = shadow.shapes[1].field().tets().len();
            self.places.resize(count, [0; 2]);
        }
        let [round, place] = self.places[index];
        if round == self.round {
            return &self.tets[place as usize];
        }
        self.places[index] = [self.round, self.tets.len() as u32];
        self.tets.push(shadow.posed_tet(index));
        &self.tets[self.tets.len() - 1]
    }
}
