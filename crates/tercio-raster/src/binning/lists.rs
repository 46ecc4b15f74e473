//! Lists of entries, one per tile.

use crate::screen::{PixelRect, TileGrid};

/// Entries sorted by tile with a counting sort: they are added with the number of their tile, and sorted all at once.
#[derive(Debug)]
pub struct TileLists<T> {
    /// Tile and entry, in the order in which they were added.
    pairs: Vec<(u32, T)>,
    /// Index in `entries` of each tile's first entry; one more element than there are tiles.
    starts: Vec<u32>,
    /// The entries, sorted by tile.
    entries: Vec<T>,
}

impl<T> Default for TileLists<T> {
    fn default() -> Self {
        Self { pairs: Vec::new(), starts: Vec::new(), entries: Vec::new() }
    }
}

impl<T: Copy + Default> TileLists<T> {
    /// Clears the lists, keeping their memory.
    pub fn clear(&mut self) {
        self.pairs.clear();
        self.starts.clear();
        self.entries.clear();
    }

    /// Adds an entry to a tile, if the tile is drawn.
    #[inline(always)]
    pub fn push(&mut self, grid: &TileGrid, tile: u32, entry: T) {
        if grid.draws(tile) {
            self.pairs.push((tile, entry));
        }
    }

    /// Adds an entry to every drawn tile that needs pixels of `rect`, if `covers` is true for these pixels.
    #[inline(always)]
    pub fn push_rect(
        &mut self,
        grid: &TileGrid,
        entry: T,
        rect: PixelRect,
        covers: impl Fn(PixelRect) -> bool,
    ) {
        let (s, edge) = (grid.shift, 1i32 << grid.shift);
        let [x0, x1, y0, y1] =
            grid.tiles_that_need([rect.x0, rect.x1, rect.y0, rect.y1].map(|pixel| pixel as u32));
        for ty in y0..=y1 {
            for tx in x0..=x1 {
                let (x, y) = ((tx << s) as i32, (ty << s) as i32);
                let tile = PixelRect { x0: x, x1: x + edge - 1, y0: y, y1: y + edge - 1 };
                if covers(rect.intersect(tile.grow(grid.halo as i32))) {
                    self.push(grid, grid.number(tx, ty), entry);
                }
            }
        }
    }

    /// Sorts the entries by tile; the sort is stable.
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
        self.entries.resize(self.pairs.len(), T::default());
        // Moving an entry advances its tile's start, so that in the end each start is that of the next tile.
        for &(tile, entry) in &self.pairs {
            let at = &mut self.starts[tile as usize];
            self.entries[*at as usize] = entry;
            *at += 1;
        }
        self.starts.copy_within(0..grid.count(), 1);
        self.starts[0] = 0;
    }

    /// The entries of a tile, in the order in which they were added.
    #[inline(always)]
    pub fn tile(&self, tile: u32) -> &[T] {
        if self.starts.is_empty() {
            return &[];
        }
        let (from, to) = (self.starts[tile as usize], self.starts[tile as usize + 1]);
        &self.entries[from as usize..to as usize]
    }

    /// Number of entries in all tiles.
    pub fn count(&self) -> u64 {
        self.entries.len() as u64
    }

    /// Bytes of the entries, both before and after sorting.
    pub fn bytes_used(&self) -> u64 {
        (size_of_val(&self.pairs[..]) + size_of_val(&self.entries[..])) as u64
    }

    /// Bytes of memory allocated.
    pub fn bytes(&self) -> u64 {
        (self.pairs.capacity() * size_of::<(u32, T)>()
            + self.starts.capacity() * 4
            + self.entries.capacity() * size_of::<T>()) as u64
    }
}
