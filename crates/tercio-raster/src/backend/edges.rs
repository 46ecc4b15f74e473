//! Exact coverage by integer edge functions.

use super::visibility::BLOCK_BITS;
use crate::binning::ScreenTriangle;
use crate::conventions::{SAMPLE, SUBPIXEL_BITS};

/// The three edge functions of a triangle at samples: pixel (i, j) is covered exactly if
/// `a * i + b * j + c >= 0` for all three.
///
/// At samples an edge function takes only every 256th value, so it is divided by 256 and rounded down, which
/// keeps its sign. The top-left rule is the 1 that is taken off before.
#[derive(Clone, Copy, Debug)]
pub struct Edges {
    /// Growth a pixel to the right.
    pub a: [i32; 3],
    /// Growth a pixel downwards.
    pub b: [i32; 3],
    /// Value at pixel (0, 0).
    pub c: [i64; 3],
}

impl Edges {
    /// Of a triangle of either orientation; one without area covers nothing, but must not come here.
    #[inline(always)]
    pub fn new(t: &ScreenTriangle) -> Self {
        let clockwise = t.area() > 0;
        let mut edges = Self { a: [0; 3], b: [0; 3], c: [0; 3] };
        for k in 0..3 {
            let next = (k + 1) % 3;
            let (mut a, mut b) = (t.y[k] - t.y[next], t.x[next] - t.x[k]);
            if !clockwise {
                (a, b) = (-a, -b);
            }
            let top_left = a > 0 || (a == 0 && b > 0);
            let at_origin =
                i64::from(a) * i64::from(SAMPLE - t.x[k]) + i64::from(b) * i64::from(SAMPLE - t.y[k]);
            edges.a[k] = a;
            edges.b[k] = b;
            edges.c[k] = (at_origin - i64::from(!top_left)) >> SUBPIXEL_BITS;
        }
        edges
    }

    /// First and last block of the row of 4x4 blocks that begins at pixel (x, y) which an edge does not leave
    /// outside; the first is greater if there is none.
    #[inline(always)]
    pub fn blocks_in_row(&self, x: i32, y: i32) -> [i32; 2] {
        const EDGE: i32 = 1 << BLOCK_BITS;
        let (mut first, mut last) = (i64::from(i32::MIN), i64::from(i32::MAX));
        for k in 0..3 {
            // At the sample of block 0 that lies farthest inside.
            let dx = if self.a[k] > 0 { EDGE - 1 } else { 0 };
            let dy = if self.b[k] > 0 { EDGE - 1 } else { 0 };
            let value = self.at(k, x + dx, y + dy);
            let step = i64::from(self.a[k]) * i64::from(EDGE);
            match step {
                1.. => first = first.max(-value.div_euclid(step)),
                0 if value < 0 => return [1, 0],
                0 => {}
                // Rounded down, as the step is negative.
                _ => last = last.min(value.div_euclid(-step)),
            }
        }
        let whole = |block: i64| block.clamp(i64::from(i32::MIN), i64::from(i32::MAX)) as i32;
        [whole(first), whole(last)]
    }

    /// Value of edge `k` at a pixel.
    #[inline(always)]
    pub fn at(&self, k: usize, x: i32, y: i32) -> i64 {
        i64::from(self.a[k]) * i64::from(x) + i64::from(self.b[k]) * i64::from(y) + self.c[k]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn blocks_in_a_row_are_those_that_no_edge_leaves_outside(
            x in prop::array::uniform3(-40_000i32..40_000),
            y in prop::array::uniform3(-40_000i32..40_000),
            corner in prop::array::uniform2(-30i32..30),
        ) {
            let t = ScreenTriangle { x, y, d: [1.0; 3], slot: 0 };
            prop_assume!(t.area() != 0);
            let edges = Edges::new(&t);
            let [first, last] = edges.blocks_in_row(4 * corner[0], 4 * corner[1]);
            for block in -60..60 {
                let inside = (0..3).all(|k| {
                    let samples = (0..16).map(|i| edges.at(k, 4 * (corner[0] + block) + i % 4, 4 * corner[1] + i / 4));
                    samples.max() >= Some(0)
                });
                prop_assert_eq!(inside, (first..=last).contains(&block), "block {}", block);
            }
        }
    }
}
