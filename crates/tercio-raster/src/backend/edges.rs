//! Exact coverage by integer edge functions.

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

    /// Value of edge `k` at a pixel.
    #[inline(always)]
    pub fn at(&self, k: usize, x: i32, y: i32) -> i64 {
        i64::from(self.a[k]) * i64::from(x) + i64::from(self.b[k]) * i64::from(y) + self.c[k]
    }
}
