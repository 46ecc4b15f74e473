//! The Hilbert curve through the cells of a cube.
//!
//! Source: J. Skilling, "Programming the Hilbert curve", AIP Conf. Proc. 707 (2004): coordinates to the
//! transposed index in place, then the bits of the three words are interleaved.

/// Position along the curve of cell (x, y, z) in a cube with `2^bits` cells along each edge; `bits` is 1 to 10.
pub(super) fn rank([x, y, z]: [u32; 3], bits: u32) -> u32 {
    let mut v = [x, y, z];
    let top = 1u32 << (bits - 1);
    let mut q = top;
    while q > 1 {
        let low = q - 1;
        for i in 0..3 {
            if v[i] & q != 0 {
                v[0] ^= low;
            } else {
                let swap = (v[0] ^ v[i]) & low;
                v[0] ^= swap;
                v[i] ^= swap;
            }
        }
        q >>= 1;
    }
    v[1] ^= v[0];
    v[2] ^= v[1];
    let mut flip = 0;
    let mut q = top;
    while q > 1 {
        if v[2] & q != 0 {
            flip ^= q - 1;
        }
        q >>= 1;
    }
    interleave(v.map(|word| word ^ flip))
}

/// The low ten bits of three numbers by turns, those of the first one in front: position along the Morton curve of cell (x, y, z) of a
/// cube. Cells whose positions are near each other are near each other.
pub fn interleave([x, y, z]: [u32; 3]) -> u32 {
    spread(x) << 2 | spread(y) << 1 | spread(z)
}

/// Puts two zero bits between any two of the low ten bits.
fn spread(v: u32) -> u32 {
    let v = v & 0x3ff;
    let v = (v | v << 16) & 0x0300_00ff;
    let v = (v | v << 8) & 0x0300_f00f;
    let v = (v | v << 4) & 0x030c_30c3;
    (v | v << 2) & 0x0924_9249
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_are_taken_by_turns() {
        let numbers = (0..8).map(|i| interleave([i >> 2 & 1, i >> 1 & 1, i & 1]));
        assert!(numbers.eq(0..8));
        assert_eq!(interleave([1023; 3]), (1 << 30) - 1);
        assert_eq!(interleave([512, 0, 1]), 1 << 29 | 1);
    }

    #[test]
    fn the_curve_visits_every_cell_once_and_steps_to_a_neighbour() {
        for bits in 1..=4 {
            let n = 1u32 << bits;
            let mut cells: Vec<_> =
                (0..n * n * n).map(|i| [i % n, i / n % n, i / n / n]).map(|c| (rank(c, bits), c)).collect();
            cells.sort_unstable();
            for (i, pair) in cells.windows(2).enumerate() {
                assert_eq!(pair[0].0, i as u32);
                let step: u32 = (0..3).map(|k| pair[0].1[k].abs_diff(pair[1].1[k])).sum();
                assert_eq!(step, 1, "{pair:?}");
            }
        }
    }
}
