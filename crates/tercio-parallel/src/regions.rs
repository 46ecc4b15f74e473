//! Who owns which part of the picture.

use std::ops::Range;

/// The picture in square regions, which are the renderer's tiles: region k, counted row by row, belongs to rank k
/// modulo the number of ranks. Neighbours have different owners, so that even a small model is distributed over all
/// ranks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Regions {
    /// Width of the picture in pixels.
    pub width: u32,
    /// Height of the picture in pixels.
    pub height: u32,
    /// Pixels along the edge of a region, at least 1. Regions at the right and lower border may be smaller.
    pub edge: u32,
    /// Number of ranks, at least 1.
    pub ranks: usize,
    /// The regions that are meant, by number: from the first one to before the second one.
    pub numbers: [u64; 2],
}

/// A region's columns and rows in a frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Region {
    /// Columns.
    pub x: Range<u32>,
    /// Rows.
    pub y: Range<u32>,
}

impl Regions {
    fn columns(&self) -> u64 {
        u64::from(self.width.div_ceil(self.edge))
    }

    /// Number of regions.
    pub fn count(&self) -> u64 {
        self.columns() * u64::from(self.height.div_ceil(self.edge))
    }

    /// Number of ranks that own a region: the first ones.
    pub fn owners(&self) -> usize {
        usize::try_from(self.count()).map_or(self.ranks, |count| count.min(self.ranks))
    }

    /// The rank that owns a region.
    pub fn owner(&self, number: u64) -> usize {
        (number % self.ranks as u64) as usize
    }

    /// The numbers of the regions of a rank that are meant, in order.
    pub fn numbers_of(&self, rank: usize) -> impl Iterator<Item = u64> + use<> {
        let ([first, end], ranks) = (self.numbers, self.ranks as u64);
        // The first one from there on.
        let own = first + (rank as u64 + ranks - first % ranks) % ranks;
        (own..end.min(self.count())).step_by(self.ranks)
    }

    /// The regions of a rank that are meant, in order.
    pub fn of(&self, rank: usize) -> impl Iterator<Item = Region> + use<> {
        let regions = *self;
        self.numbers_of(rank).map(move |k| {
            let along = |place: u64, size: u32| {
                let first = place as u32 * regions.edge;
                first..first.saturating_add(regions.edge).min(size)
            };
            let x = along(k % regions.columns(), regions.width);
            Region { x, y: along(k / regions.columns(), regions.height) }
        })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn every_pixel_has_one_owner(
            width in 1u32..70, height in 1u32..70, edge in 1u32..40, ranks in 1usize..12, cut in 0u64..30,
        ) {
            let regions = Regions { width, height, edge, ranks, numbers: [0, u64::MAX] };
            let mut owned = vec![0; (width * height) as usize];
            for rank in 0..ranks {
                let mut pixels = 0;
                let [first, rest] = [[0, cut], [cut, u64::MAX]].map(|numbers| Regions { numbers, ..regions });
                prop_assert!(first.numbers_of(rank).chain(rest.numbers_of(rank)).eq(regions.numbers_of(rank)));
                prop_assert!(regions.numbers_of(rank).all(|number| regions.owner(number) == rank));
                for Region { x, y } in first.of(rank).chain(rest.of(rank)) {
                    for y in y {
                        for x in x.clone() {
                            owned[(y * width + x) as usize] += 1;
                            pixels += 1;
                        }
                    }
                }
                prop_assert_eq!(pixels > 0, rank < regions.owners());
            }
            prop_assert!(owned.iter().all(|&o| o == 1));
        }
    }
}
