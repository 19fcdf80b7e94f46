/// Stands where there is no pair.
const NONE: u64 = u64::MAX;

/// Places of the table with which a search begins: a power of two.
const LEAST: usize = 64;

/// The pairs of tetrahedra that were entered: a table with open addressing, at most half full.
///
/// Every search begins with a small table, since emptying a large one takes time. Its memory is kept.
#[derive(Default)]
pub(super) struct Visited {
    /// Room, of which a power of two of places is in use.
    places: Vec<u64>,
    used: usize,
    pairs: Vec<u64>,
}

impl Visited {
    /// Forgets all pairs.
    pub fn clear(&mut self) {
        self.pairs.clear();
        self.empty_places(LEAST);
    }

    /// Adds a pair, and returns whether it was not there. The table must have been cleared once.
    #[inline]
    pub fn insert(&mut self, [tet_a, tet_b]: [u32; 2]) -> bool {
        let pair = u64::from(tet_a) << 32 | u64::from(tet_b);
        let place = self.place_of(pair);
        if self.places[place] == pair {
            return false;
        }
        self.places[place] = pair;
        self.pairs.push(pair);
        if 2 * self.pairs.len() > self.used {
            self.grow();
        }
        true
    }

    /// Where a pair is, or would be.
    #[inline]
    fn place_of(&self, pair: u64) -> usize {
        let places = &self.places[..self.used];
        let last = self.used - 1;
        // Fibonacci hashing: 2⁶⁴ over the golden ratio, odd.
        let product = pair.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let mut place = (product >> 32) as usize & last;
        while places[place] != pair && places[place] != NONE {
            place = (place + 1) & last;
        }
        place
    }

    #[cold]
    fn grow(&mut self) {
        self.empty_places(4 * self.used);
        for index in 0..self.pairs.len() {
            let place = self.place_of(self.pairs[index]);
            self.places[place] = self.pairs[index];
        }
    }

    fn empty_places(&mut self, used: usize) {
        self.used = used;
        if self.places.len() < used {
            self.places.resize(used, NONE);
        }
        self.places[..used].fill(NONE);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn a_pair_is_new_once() {
        let mut visited = Visited::default();
        for round in [3_u32, 2000, 10] {
            let mut expected = HashSet::new();
            visited.clear();
            for k in 0..4 * round {
                let pair = [k.wrapping_mul(2_654_435_761) % round, k % 7];
                assert_eq!(visited.insert(pair), expected.insert(pair));
            }
        }
    }
}
