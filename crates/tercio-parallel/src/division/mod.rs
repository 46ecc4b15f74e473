//! Who draws which tiles, and which clusters: divisions of the picture, and of the scene, among ranks.

pub mod cuts;

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::fmt;

use serde::Serialize;
use tercio_raster::TileSet;
use tercio_raster::screen::TileGrid;

/// How the clusters of a scene are divided among ranks that composite what they draw of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum ClusterDivision {
    /// Into parts that are compact in the picture and have about the same visible work
    /// ([`Renderer::divide_clusters`](tercio_raster::Renderer::divide_clusters)).
    #[default]
    Compact,
    /// As many consecutive clusters for each rank, whatever the view.
    Consecutive,
}

/// How the tiles of a picture are divided among ranks.
///
/// All but [`Division::Interleaved`] depend on the work in each tile, which is the same on all ranks: an estimate, or, for
/// [`Division::Adaptive`], what was counted in the last frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Division {
    /// Scattered: the tiles with the most work first, each to the rank that has the least (longest processing time first,
    /// Graham 1969).
    #[default]
    Balanced,
    /// Scattered: tile k, counted row by row, belongs to rank k modulo the number of ranks, whatever its work.
    Interleaved,
    /// Strips across the picture, row by row, with about the same work.
    Rows,
    /// Strips down the picture, column by column, with about the same work.
    Columns,
    /// Compact parts with about the same work: runs of tiles along a Z-order curve.
    Blocks,
    /// Compact regions between [cuts](cuts::Cuts) that move when the work has moved: by the work counted in the last frame,
    /// and in the first one by an estimate.
    Adaptive,
}

impl Division {
    /// All of them.
    pub const ALL: [Self; 6] =
        [Self::Balanced, Self::Interleaved, Self::Rows, Self::Columns, Self::Blocks, Self::Adaptive];

    /// Those that know nothing of earlier frames.
    pub const STATIC: [Self; 5] =
        [Self::Balanced, Self::Interleaved, Self::Rows, Self::Columns, Self::Blocks];

    /// The name on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Balanced => "balanced",
            Self::Interleaved => "interleaved",
            Self::Rows => "rows",
            Self::Columns => "columns",
            Self::Blocks => "blocks",
            Self::Adaptive => "adaptive",
        }
    }

    /// Does it depend on the work in the tiles?
    pub fn needs_load(self) -> bool {
        self != Self::Interleaved
    }

    /// The owner of each tile of a grid, a number below `ranks`; `load` is the work in each tile, in any unit. Tiles without
    /// work are divided, too. Of [`Division::Adaptive`] these are the regions of a first frame.
    ///
    /// # Panics
    /// If there are no ranks, or the load is needed and does not have one entry for each tile.
    pub fn owners(self, grid: &TileGrid, load: &[u64], ranks: usize) -> Vec<u32> {
        assert!(ranks > 0, "there must be at least one rank");
        assert!(!self.needs_load() || load.len() == grid.count(), "each tile has a load");
        let columns = grid.columns.max(1);
        let place = |tile: u32| [tile % columns, tile / columns];
        match self {
            Self::Interleaved => (0..grid.count()).map(|tile| (tile % ranks) as u32).collect(),
            Self::Balanced => balanced(load, ranks),
            Self::Rows => runs(load, ranks, u64::from),
            Self::Columns => runs(load, ranks, |tile| {
                let [column, row] = place(tile);
                u64::from(column) << 32 | u64::from(row)
            }),
            Self::Blocks => runs(load, ranks, |tile| z_order(place(tile))),
            Self::Adaptive => cuts::Cuts::default().owners(grid, load, ranks),
        }
    }
}

impl fmt::Display for Division {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Each tile, in order of decreasing load, to the rank with the least load so far.
fn balanced(load: &[u64], ranks: usize) -> Vec<u32> {
    let work = works(load);
    let mut tiles: Vec<u32> = (0..load.len() as u32).collect();
    tiles.sort_by_key(|&tile| Reverse(load[tile as usize]));
    let mut idle: BinaryHeap<Reverse<(u128, u32)>> =
        (0..ranks as u32).map(|rank| Reverse((0, rank))).collect();
    let mut owners = vec![0; load.len()];
    for tile in tiles {
        let Some(mut least) = idle.peek_mut() else { unreachable!("there is at least one rank") };
        let Reverse((sum, rank)) = *least;
        owners[tile as usize] = rank;
        *least = Reverse((sum + work[tile as usize], rank));
    }
    owners
}

/// The work in each tile, in another unit: a sixteenth of the mean more, because a load is an estimate, and tiles that seem to be
/// empty may not be.
fn works(load: &[u64]) -> Vec<u128> {
    let sum: u128 = load.iter().map(|&load| u128::from(load)).sum();
    let unit = 16 * load.len() as u128;
    load.iter().map(|&load| unit * u128::from(load) + sum + 1).collect()
}

/// Cuts the tiles, sorted by a key, into runs of about the same load.
fn runs(load: &[u64], ranks: usize, key: impl Fn(u32) -> u64) -> Vec<u32> {
    let mut tiles: Vec<u32> = (0..load.len() as u32).collect();
    tiles.sort_by_key(|&tile| key(tile));
    let work = works(load);
    let total: u128 = work.iter().sum();
    let (mut before, mut owners) = (0, vec![0; load.len()]);
    for tile in tiles {
        let work = work[tile as usize];
        // The rank in whose share of the work the middle of the tile's lies.
        let middle = 2 * before + work;
        owners[tile as usize] = (middle * ranks as u128 / (2 * total)).min(ranks as u128 - 1) as u32;
        before += work;
    }
    owners
}

/// The position along a Z-order curve: the bits of column and row, interleaved.
fn z_order([column, row]: [u32; 2]) -> u64 {
    let spread = |n: u32| (0..32).fold(0, |bits, k| bits | u64::from(n >> k & 1) << (2 * k));
    spread(column) | spread(row) << 1
}

/// The tiles of one owner.
pub fn tiles_of(owners: &[u32], owner: usize) -> TileSet {
    TileSet::from_fn(owners.len(), |tile| owners[tile as usize] as usize == owner)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn grid(columns: u32, rows: u32) -> TileGrid {
        TileGrid::new(columns * 16, rows * 16, 16, TileSet::ALL)
    }

    proptest! {
        #[test]
        fn every_tile_has_an_owner_and_no_rank_much_more_than_its_share(
            (columns, rows) in (1u32..20, 1u32..20), ranks in 1usize..12,
            seed in prop::collection::vec(0u64..1000, 400),
        ) {
            let grid = grid(columns, rows);
            let load = &seed[..grid.count()];
            for division in Division::ALL {
                let owners = division.owners(&grid, load, ranks);
                prop_assert_eq!(owners.len(), grid.count());
                let mut sums = vec![0; ranks];
                let mut counts = vec![0; ranks];
                for (&owner, &load) in owners.iter().zip(load) {
                    sums[owner as usize] += load;
                    counts[owner as usize] += 1;
                }
                // A scattered picture has something for every rank while there are tiles.
                let scattered = matches!(division, Division::Balanced | Division::Interleaved);
                let used = counts.iter().filter(|&&count| count > 0).count();
                prop_assert!(!scattered || load.contains(&0) || used == ranks.min(grid.count()));
                if division.needs_load() {
                    let (mean, largest) = (load.iter().sum::<u64>() / ranks as u64, *load.iter().max().unwrap());
                    // No rank begins a tile when it has its share already; empty tiles count for a sixteenth of the mean.
                    let most = mean + mean / 8 + 2 * largest + 1;
                    prop_assert!(sums.iter().all(|&sum| sum <= most), "{division}: {sums:?}");
                }
            }
        }
    }

    #[test]
    fn tiles_without_work_are_divided_evenly() {
        for division in Division::ALL {
            let owners = division.owners(&grid(4, 4), &[0; 16], 4);
            for rank in 0..4 {
                assert_eq!(owners.iter().filter(|&&owner| owner == rank).count(), 4, "{division}");
            }
        }
        let owners = Division::Blocks.owners(&grid(4, 4), &[5; 16], 4);
        assert_eq!(owners, [0, 0, 1, 1, 0, 0, 1, 1, 2, 2, 3, 3, 2, 2, 3, 3]);
        let owners = Division::Columns.owners(&grid(4, 4), &[5; 16], 2);
        assert_eq!(owners, [0, 0, 1, 1].repeat(4));
    }

    #[test]
    fn tiles_that_seem_to_be_empty_are_divided_among_those_that_are_not() {
        let load: Vec<u64> = (0..400).map(|tile| if tile % 3 == 0 { 100 + tile % 7 } else { 0 }).collect();
        for division in Division::ALL {
            let owners = division.owners(&grid(20, 20), &load, 8);
            let empty = |rank: u32| {
                let of_rank = owners.iter().zip(&load).filter(|(owner, load)| **owner == rank && **load == 0);
                of_rank.count()
            };
            let counts: Vec<usize> = (0..8).map(empty).collect();
            // A third of them would be 88.
            assert!(counts.iter().all(|count| (10..=88).contains(count)), "{division}: {counts:?}");
        }
    }

    #[test]
    fn the_largest_tiles_are_given_out_first() {
        // 9 alone, 5 with 3, 4 with 4.
        let owners = Division::Balanced.owners(&grid(5, 1), &[4, 3, 9, 4, 5], 3);
        assert_eq!(owners, [2, 1, 0, 2, 1]);
    }
}
