//! Exact coverage with integer edge functions.

use super::{PixelRect, ScreenTriangle};
use crate::sampling::SampleCells;

/// The three edge functions of a triangle at samples: the sample in cell (i, j) of the picture is covered if and only if
/// `a * i + b * j + c >= 0` for all three. With one sample per pixel, cells are pixels.
///
/// At the middles of cells, the values of an edge function differ by multiples of a cell's edge in sub-pixels, so it is
/// divided by that and rounded down, which keeps its sign. The top-left rule subtracts 1 before that from edges that are
/// neither top nor left.
#[derive(Clone, Copy, Debug)]
pub struct Edges {
    /// Increment per cell to the right.
    pub a: [i32; 3],
    /// Increment per cell downwards.
    pub b: [i32; 3],
    /// Value at cell (0, 0).
    pub c: [i64; 3],
}

impl Edges {
    /// The edge functions at the centres of pixels of a triangle of either winding. Precondition: its area is not zero.
    #[inline(always)]
    pub fn new(t: &ScreenTriangle) -> Self {
        Self::of_cells(t, &SampleCells::CENTER)
    }

    /// The edge functions at the cells of samples. Precondition: the triangle's area is not zero.
    #[inline(always)]
    pub fn of_cells(t: &ScreenTriangle, cells: &SampleCells) -> Self {
        let clockwise = t.area() > 0;
        let mut edges = Self { a: [0; 3], b: [0; 3], c: [0; 3] };
        for k in 0..3 {
            let next = (k + 1) % 3;
            let (mut a, mut b) = (t.y[k] - t.y[next], t.x[next] - t.x[k]);
            if !clockwise {
                (a, b) = (-a, -b);
            }
            let top_left = a > 0 || (a == 0 && b > 0);
            let at_origin = i64::from(a) * i64::from(cells.origin - t.x[k])
                + i64::from(b) * i64::from(cells.origin - t.y[k]);
            edges.a[k] = a;
            edges.b[k] = b;
            edges.c[k] = (at_origin - i64::from(!top_left)) >> cells.pitch_bits;
        }
        edges
    }

    /// Are all cells of a rectangle outside the same edge? The triangle then covers none of them.
    #[inline(always)]
    pub fn leave_out(&self, r: PixelRect) -> bool {
        // The value at the corner of the rectangle that is farthest inside.
        let farthest = |k: usize| {
            self.at(k, if self.a[k] > 0 { r.x1 } else { r.x0 }, if self.b[k] > 0 { r.y1 } else { r.y0 })
        };
        farthest(0).min(farthest(1)).min(farthest(2)) < 0
    }

    /// Are all cells of a rectangle inside all edges? The triangle then covers all of them.
    #[inline(always)]
    pub fn enclose(&self, r: PixelRect) -> bool {
        // The value at the corner of the rectangle that is least far inside.
        let nearest = |k: usize| {
            self.at(k, if self.a[k] > 0 { r.x0 } else { r.x1 }, if self.b[k] > 0 { r.y0 } else { r.y1 })
        };
        nearest(0).min(nearest(1)).min(nearest(2)) >= 0
    }

    /// Value of edge `k` at a cell.
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
        fn rectangle_tests_equal_the_tests_of_all_their_pixels(
            x in prop::array::uniform3(-40_000i32..40_000),
            y in prop::array::uniform3(-40_000i32..40_000),
            corner in prop::array::uniform2(-100i32..100),
            size in prop::array::uniform2(0i32..16),
        ) {
            let t = ScreenTriangle { x, y, d: [1.0; 3], slot: 0 };
            prop_assume!(t.area() != 0);
            let edges = Edges::new(&t);
            let [x0, y0] = corner;
            let rect = PixelRect { x0, x1: x0 + size[0], y0, y1: y0 + size[1] };
            let pixels = || (y0..=rect.y1).flat_map(|y| (x0..=rect.x1).map(move |x| (x, y)));
            let left_out = (0..3).any(|k| pixels().all(|(x, y)| edges.at(k, x, y) < 0));
            let enclosed = pixels().all(|(x, y)| (0..3).all(|k| edges.at(k, x, y) >= 0));
            prop_assert_eq!(edges.leave_out(rect), left_out);
            prop_assert_eq!(edges.enclose(rect), enclosed);
        }
    }
}
