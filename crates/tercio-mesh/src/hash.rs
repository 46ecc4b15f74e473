//! Keyed hashes, against crafted collisions.
//!
//! A table with a fixed hash can be filled with keys that all fall into one bucket, and then takes time quadratic in
//! their number. These hashes depend on a random key, drawn once per run. No result may depend on it: tables are only
//! queried for equal keys, never iterated over.

use std::hash::{BuildHasher as _, Hasher as _, RandomState};
use std::sync::OnceLock;

/// What hashes depend on besides the data.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Key([u64; 3]);

impl Key {
    /// The key of this run.
    pub(crate) fn of_this_run() -> Self {
        static KEY: OnceLock<Key> = OnceLock::new();
        // The standard library's hasher has a random seed.
        let random = || RandomState::new().build_hasher().finish();
        *KEY.get_or_init(|| Key([random(), random(), random() | 1]))
    }

    #[cfg(test)]
    pub(crate) fn fixed(seed: u64) -> Self {
        let word = |i: u64| {
            let z = (seed + i).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            (z ^ z >> 31).wrapping_mul(0xbf58_476d_1ce4_e5b9) ^ z << 17
        };
        Self([word(1), word(1 << 20), word(1 << 40) | 1])
    }

    /// The hash of three words.
    #[inline]
    pub(crate) fn of_three(self, [x, y, z]: [u32; 3]) -> u64 {
        fold((u64::from(x) | u64::from(y) << 32) ^ self.0[0], u64::from(z) ^ self.0[1])
    }

    /// Adds a word to a hash.
    #[inline]
    pub(crate) fn add(self, hash: u64, word: u64) -> u64 {
        fold(hash ^ self.0[1] ^ word, self.0[2])
    }
}

/// Both halves of the product, combined by exclusive or: each bit depends on all bits of both factors.
#[inline]
fn fold(a: u64, b: u64) -> u64 {
    let product = u128::from(a) * u128::from(b);
    product as u64 ^ (product >> 64) as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn consecutive_and_crafted_words_do_not_collide() {
        for seed in [1, 2, 0x1234_5678_9abc_def0] {
            let key = Key::fixed(seed);
            let spread = |words: &mut dyn Iterator<Item = [u32; 3]>| {
                let mut hashes: Vec<_> =
                    words.map(|w| key.of_three(w)).map(|h| [h & 0xffff, h >> 48]).collect();
                let n = hashes.len();
                let distinct = |k: usize, hashes: &mut Vec<[u64; 2]>| {
                    hashes.sort_unstable_by_key(|h| h[k]);
                    hashes.dedup_by_key(|h| h[k]);
                    hashes.len()
                };
                (n, distinct(0, &mut hashes.clone()), distinct(1, &mut hashes))
            };
            let float = |i: u32| (i as f32).to_bits();
            let lattice = &mut (0..1u32 << 15).map(|i| [float(i % 32), float(i / 32 % 32), float(i / 1024)]);
            // These collided in an earlier hash: x and y compensate for what a multiple of z changes.
            let crafted = &mut (0..1u32 << 15).map(|z| {
                let xy = u64::from(z).wrapping_mul(0xa24b_aed4_963e_e407);
                [xy as u32, (xy >> 32) as u32, z]
            });
            for (n, low, high) in [spread(lattice), spread(crafted)] {
                // Random hashes: 2^15 balls in 2^16 bins hit 39 % of them.
                assert!(low > n * 7 / 10 && high > n * 7 / 10, "{n} words: {low} low ends, {high} high ends");
            }
        }
    }
}
