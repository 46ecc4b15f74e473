//! Which processor rasterizes which pixel (document 000, Eldridge 1995, appendix A.1.1, figure A-2).
//!
//! ```text
//! 0 (0, 0) (383, 255)
//! 1 (0, 256) (383, 511)
//! ```
//!
//! One line per rectangle of pixels, inclusive on both sides, after the number of its processor. Every pixel of the
//! screen belongs to precisely one processor; a processor may have several rectangles, or none.

mod file;
#[cfg(test)]
mod tests;

use super::PixelBox;

/// A map from the pixels of a screen to processors.
///
/// Stored as a grid of cells: the screen is split at every side of a rectangle, so that a cell has one owner.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ScreenMap {
    /// Column of cells that contains a column of pixels.
    cell_of_x: Vec<u32>,
    /// Row of cells that contains a row of pixels.
    cell_of_y: Vec<u32>,
    /// First pixel column of every column of cells, and the width of the screen.
    starts_x: Vec<i32>,
    /// First pixel row of every row of cells, and the height of the screen.
    starts_y: Vec<i32>,
    /// Owners of the cells, row by row.
    owners: Vec<u32>,
    /// The largest owner plus one.
    processors: u32,
}

/// Why rectangles do not form a map.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MapError {
    /// There is no rectangle.
    #[error("a map needs at least one rectangle")]
    Empty,
    /// A rectangle extends to the left of or above pixel (0, 0), or the screen is too large.
    #[error("rectangle {rectangle} lies outside the pixels (0, 0) to ({MAX_SIDE}, {MAX_SIDE})")]
    Outside {
        /// Its number, from 0.
        rectangle: usize,
    },
    /// A pixel has two owners.
    #[error("rectangle {rectangle} covers pixel ({x}, {y}), which already belongs to processor {owner}")]
    Overlap {
        /// Number of the later rectangle, from 0.
        rectangle: usize,
        /// Column.
        x: i32,
        /// Row.
        y: i32,
        /// The earlier owner.
        owner: u32,
    },
    /// A pixel has no owner.
    #[error("no rectangle covers pixel ({x}, {y})")]
    Hole {
        /// Column.
        x: i32,
        /// Row.
        y: i32,
    },
    /// The rectangles split the screen into too many cells.
    #[error("the rectangles cut the screen into {cells} cells, more than {MAX_CELLS}")]
    TooFine {
        /// Columns times rows of cells.
        cells: u64,
    },
}

/// Maximum number of pixels along a side of a screen.
const MAX_SIDE: i32 = 1 << 15;
/// Bounds the memory of a map (4 bytes a cell).
const MAX_CELLS: u64 = 1 << 26;
/// Owner of a cell that no rectangle has covered yet.
const NOBODY: u32 = u32::MAX;

impl ScreenMap {
    /// The map of rectangles with owners. The screen extends to their last pixel.
    ///
    /// # Errors
    /// [`MapError`] if some pixel has no owner or two.
    pub fn of_rectangles(rectangles: &[(u32, PixelBox)]) -> Result<Self, MapError> {
        let outside = |b: &PixelBox| b.x0 < 0 || b.y0 < 0 || b.x1 >= MAX_SIDE || b.y1 >= MAX_SIDE;
        if let Some(rectangle) = rectangles.iter().position(|(_, b)| outside(b)) {
            return Err(MapError::Outside { rectangle });
        }
        let starts_x = starts(rectangles.iter().map(|(_, b)| (b.x0, b.x1)));
        let starts_y = starts(rectangles.iter().map(|(_, b)| (b.y0, b.y1)));
        if rectangles.is_empty() {
            return Err(MapError::Empty);
        }
        let cells = (starts_x.len() as u64 - 1) * (starts_y.len() as u64 - 1);
        if cells > MAX_CELLS {
            return Err(MapError::TooFine { cells });
        }
        let mut map = Self {
            cell_of_x: cell_of(&starts_x),
            cell_of_y: cell_of(&starts_y),
            owners: vec![NOBODY; cells as usize],
            starts_x,
            starts_y,
            processors: rectangles.iter().map(|(owner, _)| owner + 1).max().unwrap_or(0),
        };
        for (rectangle, &(owner, pixels)) in rectangles.iter().enumerate() {
            let columns = map.starts_x.len() - 1;
            let ([cx0, cx1], [cy0, cy1]) = map.cells(&pixels);
            for cy in cy0..=cy1 {
                for cx in cx0..=cx1 {
                    let cell = &mut map.owners[cy * columns + cx];
                    if *cell != NOBODY {
                        let (x, y) = (map.starts_x[cx], map.starts_y[cy]);
                        return Err(MapError::Overlap { rectangle, x, y, owner: *cell });
                    }
                    *cell = owner;
                }
            }
        }
        if let Some(hole) = map.owners.iter().position(|&o| o == NOBODY) {
            let columns = map.starts_x.len() - 1;
            return Err(MapError::Hole { x: map.starts_x[hole % columns], y: map.starts_y[hole / columns] });
        }
        Ok(map)
    }

    /// The default of document 000: columns of the screen to processors 0, 1, 2 and so on. With fewer processors than
    /// columns each has a block of neighbouring columns, as equal as possible; with more, the rest has none.
    ///
    /// # Panics
    /// If the screen has no pixel or more than 32,768 along a side, or there is no processor.
    pub fn columns(width: u32, height: u32, processors: u32) -> Self {
        assert!(processors > 0, "a machine has processors");
        let used = processors.min(width);
        let start = |p: u32| (u64::from(p) * u64::from(width) / u64::from(used)) as i32;
        let rectangles = (0..used).map(|p| {
            let pixels = PixelBox { x0: start(p), x1: start(p + 1) - 1, ..PixelBox::screen(width, height) };
            (p, pixels)
        });
        Self::of_valid(&rectangles.collect::<Vec<_>>())
    }

    /// Square tiles of `side` pixels, assigned to the processors round-robin, row by row.
    ///
    /// # Panics
    /// If the screen has no pixel or more than 32,768 along a side, or there is no processor, or the tiles have
    /// no pixel.
    pub fn tiles(width: u32, height: u32, side: u32, processors: u32) -> Self {
        assert!(processors > 0 && side > 0, "a machine has processors, a tile has pixels");
        let screen = PixelBox::screen(width, height);
        let (across, down) = (width.div_ceil(side), height.div_ceil(side));
        let tiles = (0..down).flat_map(|j| (0..across).map(move |i| (i, j)));
        let rectangles = tiles.enumerate().map(|(number, (i, j))| {
            let (x, y) = ((i * side) as i32, (j * side) as i32);
            let tile = PixelBox { x0: x, y0: y, x1: x + side as i32 - 1, y1: y + side as i32 - 1 };
            (number as u32 % processors, tile.intersection(&screen).unwrap_or(tile))
        });
        Self::of_valid(&rectangles.collect::<Vec<_>>())
    }

    fn of_valid(rectangles: &[(u32, PixelBox)]) -> Self {
        match Self::of_rectangles(rectangles) {
            Ok(map) => map,
            Err(error) => panic!("{error}"),
        }
    }

    /// Pixels across.
    pub fn width(&self) -> u32 {
        self.cell_of_x.len() as u32
    }

    /// Pixels down.
    pub fn height(&self) -> u32 {
        self.cell_of_y.len() as u32
    }

    /// The largest processor number that has pixels, plus one.
    pub fn processors(&self) -> u32 {
        self.processors
    }

    /// The processor of a pixel, `None` outside the screen.
    pub fn owner(&self, x: i32, y: i32) -> Option<u32> {
        let cx = *self.cell_of_x.get(usize::try_from(x).ok()?)?;
        let cy = *self.cell_of_y.get(usize::try_from(y).ok()?)?;
        Some(self.owners[cy as usize * (self.starts_x.len() - 1) + cx as usize])
    }

    /// The processors with pixels in a box, in ascending order, each with the number of these pixels. The part of the
    /// box outside the screen is ignored. `into` is cleared first.
    pub fn overlap(&self, pixels: &PixelBox, into: &mut Vec<(u32, u64)>) {
        into.clear();
        let screen = PixelBox::screen(self.width(), self.height());
        let Some(pixels) = pixels.intersection(&screen) else { return };
        let columns = self.starts_x.len() - 1;
        let ([cx0, cx1], [cy0, cy1]) = self.cells(&pixels);
        for cy in cy0..=cy1 {
            let rows = self.starts_y[cy + 1].min(pixels.y1 + 1) - self.starts_y[cy].max(pixels.y0);
            for cx in cx0..=cx1 {
                let across = self.starts_x[cx + 1].min(pixels.x1 + 1) - self.starts_x[cx].max(pixels.x0);
                into.push((self.owners[cy * columns + cx], rows as u64 * across as u64));
            }
        }
        // Column maps yield sorted processors; others have to be sorted, and their processors' pieces merged.
        if !into.is_sorted_by(|a, b| a.0 < b.0) {
            into.sort_unstable_by_key(|&(owner, _)| owner);
            into.dedup_by(|piece, sum| {
                let same = piece.0 == sum.0;
                sum.1 += if same { piece.1 } else { 0 };
                same
            });
        }
    }

    /// First and last column and row of cells of a box inside the screen.
    fn cells(&self, b: &PixelBox) -> ([usize; 2], [usize; 2]) {
        let x = |x: i32| self.cell_of_x[x as usize] as usize;
        let y = |y: i32| self.cell_of_y[y as usize] as usize;
        ([x(b.x0), x(b.x1)], [y(b.y0), y(b.y1)])
    }
}

/// Start positions of the pieces of an axis that is split at both ends of every range, followed by the end of the last
/// one.
fn starts(ranges: impl Iterator<Item = (i32, i32)>) -> Vec<i32> {
    let mut starts: Vec<i32> = ranges.flat_map(|(first, last)| [first, last + 1]).chain([0]).collect();
    starts.sort_unstable();
    starts.dedup();
    starts
}

fn cell_of(starts: &[i32]) -> Vec<u32> {
    let cells = starts.windows(2).enumerate();
    cells.flat_map(|(cell, s)| (s[0]..s[1]).map(move |_| cell as u32)).collect()
}
