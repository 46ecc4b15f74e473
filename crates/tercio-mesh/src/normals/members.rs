//! A set of vertices.

/// A set of vertex numbers that can return the rank of each of its members.
pub(crate) struct Members {
    words: Vec<u64>,
    /// Number of members before each word.
    before: Vec<u32>,
}

impl Members {
    /// A set of some of this many vertices.
    pub fn new(vertices: usize, members: impl Iterator<Item = u32>) -> Self {
        let mut words = vec![0u64; vertices.div_ceil(64)];
        members.for_each(|v| words[v as usize / 64] |= 1 << (v % 64));
        let counts = words.iter().map(|w| w.count_ones());
        let before = counts.scan(0, |sum, n| Some(std::mem::replace(sum, *sum + n))).collect();
        Self { words, before }
    }

    /// Is the vertex a member?
    pub fn has(&self, v: u32) -> bool {
        self.words[v as usize / 64] >> (v % 64) & 1 == 1
    }

    /// Number of members before the vertex.
    pub fn rank(&self, v: u32) -> u32 {
        let (word, bit) = (v as usize / 64, v % 64);
        self.before[word] + (self.words[word] & ((1 << bit) - 1)).count_ones()
    }

    /// All members, in order.
    pub fn list(&self) -> Vec<u32> {
        let bits = |(i, &word): (usize, &u64)| {
            (0..64).filter(move |bit| word >> bit & 1 == 1).map(move |bit| i as u32 * 64 + bit)
        };
        self.words.iter().enumerate().filter(|(_, word)| **word != 0).flat_map(bits).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_are_indices_in_the_list() {
        let members: Vec<u32> = (0..1000).filter(|v| v * v % 7 < 3 && !(200..400).contains(v)).collect();
        let set = Members::new(1000, members.iter().rev().copied());
        assert_eq!(set.list(), members);
        for v in 0..1000 {
            assert_eq!(set.has(v), members.contains(&v));
            assert_eq!(set.rank(v) as usize, members.partition_point(|&m| m < v));
        }
    }
}
