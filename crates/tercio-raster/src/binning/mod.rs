//! The sort between the front end and the back end: triangles into the tiles that they may touch.
//!
//! Each batch of clusters fills bins of its own, so that threads never share one; the back end reads a tile's
//! entries batch after batch. A batch is sorted by counting: entries are numbered by tile, then moved.

mod overlap;
pub mod small;

pub use overlap::covers_tile;
pub use small::SmallTriangle;

use crate::backend::edges::Edges;
use crate::conventions::{first_sample, last_sample};
use crate::settings::Binning;
use crate::view::ScreenVertex;

/// A triangle on the screen, ready for the back end. Its farthest corner comes first: depth is interpolated
/// from there.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ScreenTriangle {
    /// Screen coordinates of the corners.
    pub x: [i32; 3],
    /// Screen coordinates of the corners.
    pub y: [i32; 3],
    /// Depths of the corners.
    pub d: [f32; 3],
    /// Which triangle it is: cluster number times `MAX_TRIANGLES`, plus its number inside the cluster.
    pub slot: u32,
}

impl ScreenTriangle {
    /// From three projected corners in mesh order; turns the farthest one (the first among equals) to the
    /// front.
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

    /// Twice the signed area, in square sub-pixels; positive if the corners run clockwise on the screen.
    #[inline(always)]
    pub fn area(&self) -> i64 {
        let (x1, x2) = (i64::from(self.x[1] - self.x[0]), i64::from(self.x[2] - self.x[0]));
        let (y1, y2) = (i64::from(self.y[1] - self.y[0]), i64::from(self.y[2] - self.y[0]));
        x1 * y2 - x2 * y1
    }

    /// First and last column and row of pixels whose samples lie in the bounding box, inside the picture;
    /// `None` if there are none.
    #[inline(always)]
    pub fn samples(&self, width: u32, height: u32) -> Option<PixelRect> {
        let ([x0, x1, x2], [y0, y1, y2]) = (self.x, self.y);
        let rect = PixelRect {
            x0: first_sample(x0.min(x1).min(x2)).max(0),
            x1: last_sample(x0.max(x1).max(x2)).min(width as i32 - 1),
            y0: first_sample(y0.min(y1).min(y2)).max(0),
            y1: last_sample(y0.max(y1).max(y2)).min(height as i32 - 1),
        };
        (rect.x0 <= rect.x1 && rect.y0 <= rect.y1).then_some(rect)
    }
}

/// A rectangle of pixels, all borders inclusive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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

/// How the picture is divided into tiles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TileGrid {
    /// log2 of a tile's edge in pixels.
    pub shift: u32,
    /// Tiles across.
    pub columns: u32,
    /// Tiles down.
    pub rows: u32,
}

impl TileGrid {
    /// Divides a picture; `size` is a power of two.
    pub fn new(width: u32, height: u32, size: u32) -> Self {
        Self { shift: size.trailing_zeros(), columns: width.div_ceil(size), rows: height.div_ceil(size) }
    }

    /// Tiles of the picture.
    pub fn count(&self) -> usize {
        self.columns as usize * self.rows as usize
    }

    /// First column and row of pixels of a tile.
    pub fn corner(&self, tile: u32) -> (u32, u32) {
        ((tile % self.columns) << self.shift, (tile / self.columns) << self.shift)
    }
}

/// Adds an entry to every tile that a triangle's samples touch; by exact binning only to those that it
/// `covers`.
#[inline(never)]
fn push_pairs(
    pairs: &mut Vec<(u32, u32)>,
    grid: &TileGrid,
    binning: Binning,
    number: u32,
    rect: PixelRect,
    covers: impl Fn(PixelRect) -> bool,
) {
    let (s, edge) = (grid.shift, 1i32 << grid.shift);
    for ty in rect.y0 as u32 >> s..=rect.y1 as u32 >> s {
        for tx in rect.x0 as u32 >> s..=rect.x1 as u32 >> s {
            let (x, y) = ((tx << s) as i32, (ty << s) as i32);
            let part = PixelRect {
                x0: rect.x0.max(x),
                x1: rect.x1.min(x + edge - 1),
                y0: rect.y0.max(y),
                y1: rect.y1.min(y + edge - 1),
            };
            if binning == Binning::BoundingBox || covers(part) {
                pairs.push((ty * grid.columns + tx, number));
            }
        }
    }
}

/// The bit of an entry that tells it is a small triangle's.
const SMALL: u32 = 1 << 31;

/// A triangle in a tile's bin.
#[derive(Clone, Copy, Debug)]
pub enum Binned<'a> {
    /// A small one.
    Small(&'a SmallTriangle),
    /// One of any size.
    Any(&'a ScreenTriangle),
}

/// What one batch of clusters sorted into the tiles.
#[derive(Debug, Default)]
pub struct Bins {
    /// The small triangles, in the order they came.
    small: Vec<SmallTriangle>,
    /// The others, in the order they came.
    triangles: Vec<ScreenTriangle>,
    /// Tile and triangle number of each entry, not sorted yet.
    pairs: Vec<(u32, u32)>,
    /// Where each tile's entries begin in `entries`; one more than there are tiles.
    starts: Vec<u32>,
    /// Triangle numbers, tile after tile; see [`SMALL`].
    entries: Vec<u32>,
}

impl Bins {
    /// Empties the bins, keeping their memory.
    pub fn clear(&mut self) {
        self.small.clear();
        self.triangles.clear();
        self.pairs.clear();
        self.entries.clear();
        self.starts.clear();
    }

    /// Adds a triangle of any size to the tiles that it may touch; `rect` are its samples.
    #[inline(never)]
    pub fn push(&mut self, grid: &TileGrid, binning: Binning, triangle: ScreenTriangle, rect: PixelRect) {
        let number = self.triangles.len() as u32;
        self.triangles.push(triangle);
        let covers = |tile: PixelRect| covers_tile(&Edges::new(&triangle), tile);
        push_pairs(&mut self.pairs, grid, binning, number, rect, covers);
    }

    /// Adds a small triangle to the tiles that it may touch; `rect` are its samples.
    #[inline(always)]
    pub fn push_small(
        &mut self,
        grid: &TileGrid,
        binning: Binning,
        triangle: SmallTriangle,
        rect: PixelRect,
    ) {
        let number = self.small.len() as u32 | SMALL;
        self.small.push(triangle);
        let s = grid.shift;
        let (tx, ty) = (rect.x0 as u32 >> s, rect.y0 as u32 >> s);
        if tx == rect.x1 as u32 >> s && ty == rect.y1 as u32 >> s {
            self.pairs.push((ty * grid.columns + tx, number));
        } else {
            let covers = |tile: PixelRect| covers_tile(&triangle.edges(), tile);
            push_pairs(&mut self.pairs, grid, binning, number, rect, covers);
        }
    }

    /// Sorts the entries by tile, keeping their order inside a tile.
    pub fn sort(&mut self, grid: &TileGrid) {
        self.starts.clear();
        self.starts.resize(grid.count() + 1, 0);
        for &(tile, _) in &self.pairs {
            self.starts[tile as usize + 1] += 1;
        }
        let mut sum = 0;
        for start in &mut self.starts {
            sum += *start;
            *start = sum;
        }
        self.entries.clear();
        self.entries.resize(self.pairs.len(), 0);
        // Moving an entry advances its tile's start; afterwards each start is the next tile's.
        for &(tile, number) in &self.pairs {
            let at = &mut self.starts[tile as usize];
            self.entries[*at as usize] = number;
            *at += 1;
        }
        self.starts.copy_within(0..grid.count(), 1);
        self.starts[0] = 0;
    }

    /// How many triangles a tile's bin holds.
    pub fn fill(&self, tile: u32) -> usize {
        self.tile(tile).len()
    }

    /// The triangles of a tile, in the order they came.
    #[inline(always)]
    pub fn in_tile(&self, tile: u32) -> impl Iterator<Item = Binned<'_>> {
        self.tile(tile).iter().map(|&number| {
            if number & SMALL != 0 {
                Binned::Small(&self.small[(number & !SMALL) as usize])
            } else {
                Binned::Any(&self.triangles[number as usize])
            }
        })
    }

    fn tile(&self, tile: u32) -> &[u32] {
        if self.starts.is_empty() {
            return &[];
        }
        let (from, to) = (self.starts[tile as usize], self.starts[tile as usize + 1]);
        &self.entries[from as usize..to as usize]
    }

    /// Triangles of all sizes.
    pub fn len(&self) -> u64 {
        (self.small.len() + self.triangles.len()) as u64
    }

    /// No triangle was added.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Entries in all tiles.
    pub fn entries(&self) -> u64 {
        self.entries.len() as u64
    }

    /// Bytes of memory held.
    pub fn bytes(&self) -> u64 {
        (self.small.capacity() * size_of::<SmallTriangle>()
            + self.triangles.capacity() * size_of::<ScreenTriangle>()
            + self.pairs.capacity() * 8
            + self.starts.capacity() * 4
            + self.entries.capacity() * 4) as u64
    }
}
