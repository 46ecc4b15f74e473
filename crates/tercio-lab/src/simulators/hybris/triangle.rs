//! A triangle on the screen by the rounding rules of Hybris.
//!
//! Coordinates are rounded down and the end is exclusive (document 001, 3.2.6, the simpler rules). This is equivalent
//! to sampling pixel (p, r) at its lower right corner (p + 1, r + 1): a span from x to x' has the pixels floor(x) to
//! floor(x') - 1, and a triangle from y to y' the rows floor(y) to floor(y') - 1. Edges are followed exactly, in
//! integers, where the machine uses 12 fractional bits.

/// Sub-pixels along a pixel's edge.
pub const SUBPIXELS: i32 = 256;

/// Corners on the screen, in sub-pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Triangle {
    /// From the left.
    pub x: [i32; 3],
    /// From the top.
    pub y: [i32; 3],
}

/// Pixels `x0` to `x1` - 1 of rows `y0` to `y1` - 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PixelBox {
    /// First column.
    pub x0: i32,
    /// Column after the last.
    pub x1: i32,
    /// First row.
    pub y0: i32,
    /// Row after the last.
    pub y1: i32,
}

impl PixelBox {
    /// The intersection; `None` if it is empty.
    pub fn and(self, o: Self) -> Option<Self> {
        let both = Self {
            x0: self.x0.max(o.x0),
            x1: self.x1.min(o.x1),
            y0: self.y0.max(o.y0),
            y1: self.y1.min(o.y1),
        };
        (both.x0 < both.x1 && both.y0 < both.y1).then_some(both)
    }
}

impl Triangle {
    /// Corners in sub-pixels.
    pub fn new(corners: [(i32, i32); 3]) -> Self {
        Self { x: corners.map(|c| c.0), y: corners.map(|c| c.1) }
    }

    /// Twice the signed area in square sub-pixels; negative if the corners run counter-clockwise on the screen,
    /// which is the front.
    pub fn area(&self) -> i64 {
        let d = |v: [i32; 3], k: usize| i64::from(v[k]) - i64::from(v[0]);
        d(self.x, 1) * d(self.y, 2) - d(self.x, 2) * d(self.y, 1)
    }

    /// The bounding box after rounding; `None` if it has no width or no height: the triangle is then culled
    /// (document 001, 3.2.7).
    pub fn rounded_box(&self) -> Option<PixelBox> {
        let range = |v: [i32; 3]| {
            let (low, high) = (v[0].min(v[1]).min(v[2]), v[0].max(v[1]).max(v[2]));
            (low.div_euclid(SUBPIXELS), high.div_euclid(SUBPIXELS))
        };
        let ((x0, x1), (y0, y1)) = (range(self.x), range(self.y));
        (x0 < x1 && y0 < y1).then_some(PixelBox { x0, x1, y0, y1 })
    }

    /// The span of one row: first pixel and pixel after the last; equal if the span is empty.
    pub fn span(&self, row: i32) -> (i32, i32) {
        let y = (i64::from(row) + 1) * i64::from(SUBPIXELS);
        let (mut first, mut end) = (i64::MAX, i64::MIN);
        for k in 0..3 {
            let (mut a, mut b) = (k, (k + 1) % 3);
            if self.y[a] > self.y[b] {
                (a, b) = (b, a);
            }
            let (ya, yb) = (i64::from(self.y[a]), i64::from(self.y[b]));
            if ya < y && y <= yb {
                let (xa, dx) = (i64::from(self.x[a]), i64::from(self.x[b]) - i64::from(self.x[a]));
                let height = yb - ya;
                let x = (xa * height + (y - ya) * dx).div_euclid(height * i64::from(SUBPIXELS));
                (first, end) = (first.min(x), end.max(x));
            }
        }
        if first > end { (0, 0) } else { (first as i32, end as i32) }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn covered(t: &Triangle, size: i32) -> Vec<(i32, i32)> {
        (0..size).flat_map(|r| (t.span(r).0.max(0)..t.span(r).1.min(size)).map(move |p| (p, r))).collect()
    }

    #[test]
    fn a_right_triangle_by_hand() {
        // Corners (0,0), (4,0), (0,4) in pixels: row r is sampled at y = r + 1, where the slope is at 3 - r.
        let t = Triangle::new([(0, 0), (0, 1024), (1024, 0)]);
        assert_eq!([0, 1, 2, 3].map(|r| t.span(r)), [(0, 3), (0, 2), (0, 1), (0, 0)]);
        assert_eq!(t.rounded_box(), Some(PixelBox { x0: 0, x1: 4, y0: 0, y1: 4 }));
        assert!(t.area() < 0);
    }

    #[test]
    fn a_triangle_inside_one_pixel_is_culled() {
        assert_eq!(Triangle::new([(10, 10), (200, 40), (90, 250)]).rounded_box(), None);
        // So is one that is thin in one direction only.
        assert_eq!(Triangle::new([(10, 10), (200, 40), (90, 5000)]).rounded_box(), None);
    }

    proptest! {
        /// A square split in two at any point inside it: every pixel is drawn exactly once.
        #[test]
        fn neighbours_neither_overlap_nor_leave_holes(x in 1i32..4095, y in 1i32..4095) {
            let c = [(0, 0), (4096, 0), (4096, 4096), (0, 4096)];
            let mut count = vec![0; 256];
            for k in 0..4 {
                for (p, r) in covered(&Triangle::new([c[k], c[(k + 1) % 4], (x, y)]), 16) {
                    count[(r * 16 + p) as usize] += 1;
                }
            }
            prop_assert!(count.iter().all(|&n| n == 1), "{count:?}");
        }

        /// A triangle that is culled by its box has no pixel, and no pixel lies outside the box.
        #[test]
        fn the_box_holds_all_spans(c in prop::array::uniform3((-600i32..4600, -600i32..4600))) {
            let t = Triangle::new(c);
            let of_box = t.rounded_box().unwrap_or(PixelBox { x0: 0, x1: 0, y0: 0, y1: 0 });
            for row in -5..25 {
                let (a, b) = t.span(row);
                prop_assert!(a == b || (of_box.y0 <= row && row < of_box.y1 && of_box.x0 <= a && b <= of_box.x1));
            }
        }
    }
}
