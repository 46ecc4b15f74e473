//! Screen-space geometry, in pixels and sub-pixels: triangles, edge functions, depth planes, rectangles, tiles.

mod depth_plane;
mod edges;
mod grid;
mod tile_set;

pub use depth_plane::DepthPlane;
pub use edges::Edges;
pub use grid::TileGrid;
pub use tile_set::TileSet;

use bytemuck::{Pod, Zeroable};

use crate::conventions::{SAMPLE, first_pixel, last_pixel};
use crate::view::ScreenVertex;

/// A triangle in screen space. The farthest corner, from which depth is interpolated, comes first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct ScreenTriangle {
    /// Screen coordinates of the corners.
    pub x: [i32; 3],
    /// Screen coordinates of the corners.
    pub y: [i32; 3],
    /// Depths of the corners.
    pub d: [f32; 3],
    /// Slot of the triangle: cluster number times `MAX_TRIANGLES`, plus its number in the cluster.
    pub slot: u32,
}

impl ScreenTriangle {
    /// From three projected corners in mesh order; rotates the farthest (the first among equals) to the front.
    #[inline(always)]
    pub fn new(v: [ScreenVertex; 3], slot: u32) -> Self {
        let mut first = 0;
        if v[1].d < v[first].d {
            first = 1;
        }
        if v[2].d < v[first].d {
            first = 2;
        }
        const NEXT: [usize; 3] = [1, 2, 0];
        let (a, b, c) = (v[first], v[NEXT[first]], v[NEXT[NEXT[first]]]);
        Self { x: [a.x, b.x, c.x], y: [a.y, b.y, c.y], d: [a.d, b.d, c.d], slot }
    }

    /// Twice the signed area, in square sub-pixels; positive if the corners appear clockwise on the screen.
    #[inline(always)]
    pub fn area(&self) -> i64 {
        let (x1, x2) = (i64::from(self.x[1] - self.x[0]), i64::from(self.x[2] - self.x[0]));
        let (y1, y2) = (i64::from(self.y[1] - self.y[0]), i64::from(self.y[2] - self.y[0]));
        x1 * y2 - x2 * y1
    }

    /// The pixels of the picture whose centres are in the bounding box; `None` if there are none.
    #[inline(always)]
    pub fn samples(&self, width: u32, height: u32) -> Option<PixelRect> {
        self.pixels(SAMPLE, width, height)
    }

    /// The pixels of the picture of which a column and a row of samples are in the bounding box; `None` if there are
    /// none. The samples of a pixel are at least `origin` sub-pixels from its borders.
    #[inline(always)]
    pub fn pixels(&self, origin: i32, width: u32, height: u32) -> Option<PixelRect> {
        let ([x0, x1, x2], [y0, y1, y2]) = (self.x, self.y);
        let rect = PixelRect {
            x0: first_pixel(x0.min(x1).min(x2), origin).max(0),
            x1: last_pixel(x0.max(x1).max(x2), origin).min(width as i32 - 1),
            y0: first_pixel(y0.min(y1).min(y2), origin).max(0),
            y1: last_pixel(y0.max(y1).max(y2), origin).min(height as i32 - 1),
        };
        (rect.x0 <= rect.x1 && rect.y0 <= rect.y1).then_some(rect)
    }
}

/// A rectangle of pixels, all borders inclusive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PixelRect {
    /// First column.
    pub x0: i32,
    /// Last column.
    pub x1: i32,
    /// First row.
    pub y0: i32,
    /// Last row.
    pub y1: i32,
}

impl PixelRect {
    /// The pixels that are in both rectangles.
    #[inline(always)]
    pub fn intersect(self, o: Self) -> Self {
        Self { x0: self.x0.max(o.x0), x1: self.x1.min(o.x1), y0: self.y0.max(o.y0), y1: self.y1.min(o.y1) }
    }

    /// The rectangle with a border of some pixels around it.
    #[inline(always)]
    pub fn grow(self, border: i32) -> Self {
        Self { x0: self.x0 - border, x1: self.x1 + border, y0: self.y0 - border, y1: self.y1 + border }
    }

    /// The cells of these pixels, if a pixel is divided into 2^bits by 2^bits cells.
    #[inline(always)]
    pub fn cells(self, bits: u32) -> Self {
        let last = |pixel: i32| ((pixel + 1) << bits) - 1;
        Self { x0: self.x0 << bits, x1: last(self.x1), y0: self.y0 << bits, y1: last(self.y1) }
    }

    /// Does the rectangle contain no pixel?
    #[inline(always)]
    pub fn is_empty(self) -> bool {
        self.x0 > self.x1 || self.y0 > self.y1
    }
}
