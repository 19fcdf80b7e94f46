/// Marks an empty slot.
const NONE: u64 = u64::MAX;

/// Number of slots at the start of a search: a power of two.
const LEAST: usize = 64;

/// Least number of slots for each pair.
const SLOTS_PER_PAIR: usize = 4;

/// A set of pairs of tetrahedra that are on a list: a hash table with open addressing.
///
/// Every search begins with a small table, because clearing a large one takes time. Its memory is kept.
#[derive(Default)]
pub(super) struct Visited {
    /// Memory. The first `used` slots, a power of two, are in use.
    slots: Vec<u64>,
    used: usize,
}

impl Visited {
    /// Clears the table for an empty list.
    pub fn clear(&mut self) {
        self.empty_slots(LEAST);
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
        while SLOTS_PER_PAIR * (before + pairs.len()) > self.used {
            self.grow(list);
        }
        list.extend_from_slice(pairs);
        let slots = &mut self.slots[..self.used];
        let added = &mut list[before..];
        let mut new = 0;
        for &pair in pairs {
            let key = key(pair);
            let slot = slot_of(slots, key);
            let is_new = slots[slot] != key;
            slots[slot] = key;
            added[new] = pair;
            new += usize::from(is_new);
        }
        list.truncate(before + new);
        &list[before..]
    }

    #[cold]
    fn grow(&mut self, list: &[[u32; 2]]) {
        self.empty_slots(4 * self.used);
        let slots = &mut self.slots[..self.used];
        for &pair in list {
            let key = key(pair);
            slots[slot_of(slots, key)] = key;
        }
    }

    fn empty_slots(&mut self, used: usize) {
        self.used = used;
        if self.slots.len() < used {
            self.slots.resize(used, NONE);
        }
        self.slots[..used].fill(NONE);
    }
}

#[inline]
fn key([tet_a, tet_b]: [u32; 2]) -> u64 {
    u64::from(tet_a) << 32 | u64::from(tet_b)
}

/// Returns the slot of a pair, or the slot where it would be added.
#[inline]
#[expect(clippy::needless_bitwise_bool, reason = "a lazy operator is a branch")]
fn slot_of(slots: &[u64], key: u64) -> usize {
    let last = slots.len() - 1;
    // Fibonacci hashing: 2⁶⁴ over the golden ratio, odd.
    let product = key.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let mut slot = (product >> 32) as usize & last;
    // Collisions are rare.
    while (slots[slot] != key) & (slots[slot] != NONE) {
        slot = (slot + 1) & last;
    }
    slot
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
