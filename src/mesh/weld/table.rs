//! A hash table of vertices or cells by their positions.

/// Open addressing; each key has the number that was inserted first.
pub struct Table {
    /// The upper half of the hash, and a number; all ones if free.
    slots: Vec<u64>,
}

const FREE_SLOT: u64 = u64::MAX;

impl Table {
    pub fn for_at_most(n: usize) -> Self {
        Table { slots: vec![FREE_SLOT; (2 * n).next_power_of_two()] }
    }

    /// The slot with this hash for which `same` holds, or the free one where it would be inserted.
    #[inline(always)]
    fn slot(&self, hash: u64, same: impl Fn(u32) -> bool) -> usize {
        let mask = self.slots.len() - 1;
        let mut slot = hash as usize & mask;
        loop {
            let taken = self.slots[slot];
            if taken == FREE_SLOT || (taken >> 32 == hash >> 32 && same(taken as u32)) {
                return slot;
            }
            slot = (slot + 1) & mask;
        }
    }

    pub fn find(&self, hash: u64, same: impl Fn(u32) -> bool) -> Option<u32> {
        let taken = self.slots[self.slot(hash, same)];
        (taken != FREE_SLOT).then_some(taken as u32)
    }

    #[inline(always)]
    pub fn find_or_insert(&mut self, hash: u64, new: u32, same: impl Fn(u32) -> bool) -> u32 {
        let slot = self.slot(hash, same);
        if self.slots[slot] == FREE_SLOT {
            self.slots[slot] = hash >> 32 << 32 | u64::from(new);
        }
        self.slots[slot] as u32
    }
}

/// Multiplies and folds the upper halves of the products onto the lower ones, because coordinates have trailing zeros.
#[inline(always)]
pub fn hash(words: [u64; 3]) -> u64 {
    words.into_iter().fold(0x9e37_79b9_7f4a_7c15, |hash, word| {
        let product = u128::from(hash ^ word) * 0xd6e8_feb8_6659_fd93;
        (product as u64 ^ (product >> 64) as u64).wrapping_add(0x2545_f491_4f6c_dd1d)
    })
}
