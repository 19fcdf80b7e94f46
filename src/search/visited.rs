/// Marks an empty place.
const NONE: u64 = u64::MAX;

/// Number of places at the start of a search: a power of two.
const LEAST: usize = 64;

/// Least number of places for each pair.
const PLACES_PER_PAIR: usize = 4;

/// A set of pairs of tetrahedra that are on a list: a hash table with open addressing.
///
/// Every search begins with a small table, because clearing a large one takes time. Its memory is kept.
#[derive(Default)]
pub(super) struct Visited {
    /// Memory. The first `used` places, a power of two, are in use.
    places: Vec<u64>,
    used: usize,
}

impl Visited {
    /// Clears the table for an empty list.
    pub fn clear(&mut self) {
        self.empty_places(LEAST);
    }

    /// Appends the pairs that are not on the list yet, and returns them. Requires that the table was cleared, and that the list is the
    /// same since then.
    ///
    /// All pairs are written and only new ones are counted, because a branch would be mispredicted.
    #[inline]
    pub fn append<'l>(
        &mut self,
        list: &'l mut Vec<[u32; 2]>,
        pairs: &[[u32; 2]],
    ) -> &'l [[u32; 2]] {
        let before = list.len();
        while PLACES_PER_PAIR * (before + pairs.len()) > self.used {
            self.grow(list);
        }
        list.extend_from_slice(pairs);
        let places = &mut self.places[..self.used];
        let added = &mut list[before..];
        let mut new = 0;
        for &pair in pairs {
            let key = key(pair);
            let place = place_of(places, key);
            let is_new = places[place] != key;
            places[place] = key;
            added[new] = pair;
            new += usize::from(is_new);
        }
        list.truncate(before + new);
        &list[before..]
    }

    #[cold]
    fn grow(&mut self, list: &[[u32; 2]]) {
        self.empty_places(4 * self.used);
        let places = &mut self.places[..self.used];
        for &pair in list {
            let key = key(pair);
            places[place_of(places, key)] = key;
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

#[inline]
fn key([tet_a, tet_b]: [u32; 2]) -> u64 {
    u64::from(tet_a) << 32 | u64::from(tet_b)
}

/// Returns the place of a pair, or the place where it would be added.
#[inline]
#[expect(clippy::needless_bitwise_bool, reason = "a lazy operator is a branch")]
fn place_of(places: &[u64], key: u64) -> usize {
    let last = places.len() - 1;
    // Fibonacci hashing: 2⁶⁴ over the golden ratio, odd.
    let product = key.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let mut place = (product >> 32) as usize & last;
    // Collisions are rare.
    while (places[place] != key) & (places[place] != NONE) {
        place = (place + 1) & last;
    }
    place
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn a_pair_is_new_once() {
        let mut visited = Visited::default();
        for round in [3_u32, 2000, 10] {
            let (mut expected, mut list) = (HashSet::new(), Vec::new());
            visited.clear();
            for k in 0..2 * round {
                let pairs = [2 * k, 2 * k + 1, 2 * k]
                    .map(|k| [k.wrapping_mul(2_654_435_761) % round, k % 7]);
                let new: Vec<_> = pairs
                    .into_iter()
                    .filter(|&pair| expected.insert(pair))
                    .collect();
                assert_eq!(visited.append(&mut list, &pairs), new);
            }
        }
    }
}
