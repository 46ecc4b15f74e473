//! Huffman codes for deflate (RFC 1951).

/// The most symbols that a code has: 256 bytes, the end of a block, and 29 lengths of repetitions.
pub const SYMBOLS: usize = 286;

/// The lengths of the code words of an optimal code for symbols with these counts, in which none is longer than `limit` bits. With a
/// smaller limit than an optimal code needs, counts are flattened until it suffices. A count of 0 is of a symbol without a code word.
pub fn lengths<const N: usize>(mut counts: [u32; N], limit: u8) -> [u8; N] {
    loop {
        let lengths = optimal_lengths(&counts);
        if lengths.iter().all(|&length| length <= limit) {
            return lengths;
        }
        counts = counts.map(|count| count.div_ceil(2));
    }
}

/// Huffman's algorithm, with one queue of symbols and one of the trees made of them.
fn optimal_lengths<const N: usize>(counts: &[u32; N]) -> [u8; N] {
    let mut lengths = [0; N];
    let mut symbols: Vec<usize> = (0..N).filter(|&symbol| counts[symbol] > 0).collect();
    symbols.sort_unstable_by_key(|&symbol| (counts[symbol], symbol));
    if let [only] = symbols[..] {
        lengths[only] = 1;
        return lengths;
    }
    let leaves = symbols.len();
    // The nodes: leaves, then trees in the order in which they are made, which is that of their weights.
    let mut weights: Vec<u64> = symbols.iter().map(|&symbol| counts[symbol].into()).collect();
    let mut parents = vec![0; (2 * leaves).saturating_sub(1)];
    let (mut leaf, mut tree) = (0, leaves);
    while weights.len() < parents.len() {
        let parent = weights.len();
        let mut lightest = || {
            let is_leaf = leaf < leaves && (tree >= parent || weights[leaf] <= weights[tree]);
            let next = if is_leaf { &mut leaf } else { &mut tree };
            *next += 1;
            parents[*next - 1] = parent;
            weights[*next - 1]
        };
        let weight = lightest() + lightest();
        weights.push(weight);
    }
    // The root is the last node, and a parent comes after its children.
    let mut depths = vec![0_u8; parents.len()];
    for node in (0..parents.len().saturating_sub(1)).rev() {
        depths[node] = depths[parents[node]].saturating_add(1);
    }
    for (&symbol, &depth) in symbols.iter().zip(&depths) {
        lengths[symbol] = depth;
    }
    lengths
}

/// The code words of the canonical code with these lengths, each with its first bit lowest, as deflate writes them.
pub fn words<const N: usize>(lengths: &[u8; N]) -> [u16; N] {
    let mut words = [0; N];
    let mut next = 0_u16;
    for length in 1..=15 {
        for (word, _) in words.iter_mut().zip(lengths).filter(|&(_, &own)| own == length) {
            *word = next.reverse_bits() >> (16 - length);
            next += 1;
        }
        next <<= 1;
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The bits that symbols with these counts take at least, of all codes: the sum of the weights of all inner nodes, found with a
    /// sorted list.
    fn least_bits(counts: &[u32]) -> u64 {
        let mut weights: Vec<u64> = counts.iter().filter(|&&c| c > 0).map(|&c| c.into()).collect();
        let mut bits = 0;
        while weights.len() > 1 {
            weights.sort_unstable_by(|a, b| b.cmp(a));
            let sum = weights.pop().unwrap() + weights.pop().unwrap();
            bits += sum;
            weights.push(sum);
        }
        bits
    }

    #[test]
    fn codes_are_complete_prefix_free_and_optimal() {
        let mut state = 7_u32;
        for round in 0..200 {
            let counts: [u32; 40] = std::array::from_fn(|_| {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                if state >> 30 == 0 { 0 } else { (state >> 8) >> (round % 24) }
            });
            if counts.iter().filter(|&&c| c > 0).count() < 2 {
                continue;
            }
            let optimal = lengths(counts, 255);
            let bits: u64 = counts.iter().zip(&optimal).map(|(&c, &l)| u64::from(c) * u64::from(l)).sum();
            assert_eq!(bits, least_bits(&counts));
            for limit in [6, 7, 14] {
                let lengths = lengths(counts, limit);
                assert!(lengths.iter().zip(&counts).all(|(&l, &c)| l <= limit && (l > 0) == (c > 0)));
                // Kraft's sum is 1: every string of bits is one of words.
                let sum: u32 = lengths.iter().filter(|&&l| l > 0).map(|&l| 1 << (limit - l)).sum();
                assert_eq!(sum, 1 << limit);
                let words = words(&lengths);
                for a in (0..40).filter(|&a| lengths[a] > 0) {
                    for b in (0..40).filter(|&b| b != a && lengths[b] >= lengths[a]) {
                        assert_ne!(words[a], words[b] & ((1 << lengths[a]) - 1), "{a} begins {b}");
                    }
                }
            }
        }
        assert_eq!(lengths([0, 5, 0], 7), [0, 1, 0]);
        assert_eq!(lengths([0; 3], 7), [0; 3]);
    }

    /// The example of RFC 1951, section 3.2.2.
    #[test]
    fn canonical_words_are_those_of_the_specification() {
        let lengths = [3, 3, 3, 3, 3, 2, 4, 4];
        let expected: [u16; 8] = [0b010, 0b011, 0b100, 0b101, 0b110, 0b00, 0b1110, 0b1111];
        let reversed: [u16; 8] =
            std::array::from_fn(|k| expected[k].reverse_bits() >> (16 - u32::from(lengths[k])));
        assert_eq!(words(&lengths), reversed);
    }
}
