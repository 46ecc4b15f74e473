//! Regions between cuts, which move when the work has moved.
//!
//! The picture is cut in two for two halves of the ranks, each half again for two halves of its ranks, and so on (recursive
//! bisection). A cut goes down or across: it parts the tiles of a region in the order of columns or of rows. So it has at most one step,
//! and can be placed to a tile: with cuts from border to border, the work of a whole column or row would be the grain.

use std::ops::Range;

use tercio_raster::screen::TileGrid;

use super::works;

/// A rank may have an eighth more than the mean before cuts move, shared among the halvings.
const TOLERANCE: u128 = 8;

/// Where a region is cut.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Cut {
    order: Order,
    /// The place in the order of the first tile behind the cut.
    behind: u64,
}

/// The order in which a cut parts tiles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Order {
    /// Column by column: a cut down the picture.
    #[default]
    Columns,
    /// Row by row: a cut across the picture.
    Rows,
}

/// The cuts of a picture, kept from frame to frame.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Cuts {
    /// That of the whole picture, then those of its first half, then those of its second half, and so on; one less than ranks that
    /// have tiles.
    cuts: Vec<Cut>,
}

impl Cuts {
    /// The owner of each tile of a grid, a number below `ranks`; `load` is the work in each tile, in any unit. A cut stays where it was
    /// if no half would have much more than its share, and otherwise goes to where the shares are best.
    ///
    /// No rank is without a tile if there are enough of them, and none has more than 1.3 times the sum of the mean of all ranks and the
    /// work in the dearest tile.
    ///
    /// # Panics
    /// If there are no ranks, or the load does not have one entry for each tile.
    pub fn owners(&mut self, grid: &TileGrid, load: &[u64], ranks: usize) -> Vec<u32> {
        assert!(ranks > 0, "there must be at least one rank");
        assert_eq!(load.len(), grid.count(), "each tile has a load");
        let used = ranks.min(load.len()).max(1);
        let old = std::mem::take(&mut self.cuts);
        let is_kept = old.len() == used - 1;
        self.cuts = if is_kept { old } else { vec![Cut::default(); used - 1] };
        let columns = grid.columns.max(1);
        let halvings = u128::from(used.next_power_of_two().ilog2()).max(1);
        let mut owners = vec![0; load.len()];
        let mut tiles: Vec<u32> = (0..load.len() as u32).collect();
        let work = works(load);
        let mut picture =
            Picture { columns, work: &work, is_kept, tolerance: TOLERANCE * halvings, owners: &mut owners };
        picture.divide(&mut tiles, 0..used as u32, &mut self.cuts);
        owners
    }
}

/// A picture that is divided.
struct Picture<'a> {
    columns: u32,
    /// In each tile.
    work: &'a [u128],
    /// Are there cuts of the last frame?
    is_kept: bool,
    /// A half may have more than its share by this divisor of it.
    tolerance: u128,
    owners: &'a mut [u32],
}

impl Picture<'_> {
    /// Divides a region, which has at least as many tiles as ranks, and one rank at least. There is a cut less than ranks.
    fn divide(&mut self, tiles: &mut [u32], ranks: Range<u32>, cuts: &mut [Cut]) {
        let Some((cut, cuts)) = cuts.split_first_mut() else {
            tiles.iter().for_each(|&tile| self.owners[tile as usize] = ranks.start);
            return;
        };
        let [columns, rows] = self.extent(tiles);
        // Across the longer side, so that regions are compact; the cut of the last frame may have the other direction for a while.
        let order = match cut.order {
            Order::Columns if self.is_kept && rows <= 2 * columns => Order::Columns,
            Order::Rows if self.is_kept && columns <= 2 * rows => Order::Rows,
            _ if rows > columns => Order::Rows,
            _ => Order::Columns,
        };
        let (all, half) = (ranks.len(), ranks.len() / 2);
        let place = |tile: u32| self.place(order, tile);
        tiles.sort_unstable_by_key(|&tile| place(tile));
        let mut before = vec![0];
        before.extend(tiles.iter().scan(0, |sum: &mut u128, &tile| {
            *sum += self.work[tile as usize];
            Some(*sum)
        }));
        let whole = before[tiles.len()];
        // Without a product of the sum and the number of ranks, which may be too large a number.
        let share = whole / all as u128 * half as u128 + whole % all as u128 * half as u128 / all as u128;
        let apart = |first: usize| before[first].abs_diff(share);
        let allowed = half..=tiles.len() - (all - half);
        let kept = tiles.partition_point(|&tile| place(tile) < cut.behind);
        let stays = self.is_kept && order == cut.order && allowed.contains(&kept) && {
            let most = if before[kept] > share { share } else { whole - share };
            apart(kept) <= most / self.tolerance
        };
        let at = if stays { kept } else { allowed.min_by_key(|&first| apart(first)).unwrap_or(half) };
        if !stays {
            *cut = Cut { order, behind: place(tiles[at]) };
        }
        let (first, second) = tiles.split_at_mut(at);
        let middle = ranks.start + half as u32;
        let (of_first, of_second) = cuts.split_at_mut(half - 1);
        self.divide(first, ranks.start..middle, of_first);
        self.divide(second, middle..ranks.end, of_second);
    }

    /// Columns and rows that tiles are in.
    fn extent(&self, tiles: &[u32]) -> [u32; 2] {
        let length = |of: fn(u32, u32) -> u32| {
            let places = || tiles.iter().map(|&tile| of(tile, self.columns));
            places().max().zip(places().min()).map_or(0, |(most, least)| most - least + 1)
        };
        [length(|tile, columns| tile % columns), length(|tile, columns| tile / columns)]
    }

    /// The place of a tile in an order.
    fn place(&self, order: Order, tile: u32) -> u64 {
        match order {
            Order::Columns => u64::from(tile % self.columns) << 32 | u64::from(tile / self.columns),
            Order::Rows => u64::from(tile),
        }
    }
}

#[cfg(test)]
mod tests;
