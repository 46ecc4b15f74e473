//! Sets of tiles.

use std::sync::Arc;

/// Bits per word of a set.
const BITS: usize = u64::BITS as usize;

/// A set of tiles of a picture. Tiles are numbered row by row.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TileSet(Option<Subset>);

/// Some of the tiles of a picture: the number of tiles of the picture, and a bit for each.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Subset {
    tiles: usize,
    bits: Arc<[u64]>,
}

impl TileSet {
    /// All tiles of any picture.
    pub const ALL: Self = Self(None);

    /// The tiles, in a picture of this many tiles, for which `contains` is true.
    pub fn from_fn(tiles: usize, contains: impl Fn(u32) -> bool) -> Self {
        let word = |first: usize| {
            let inside = first..(first + BITS).min(tiles);
            inside.fold(0, |word, tile| word | u64::from(contains(tile as u32)) << (tile - first))
        };
        Self(Some(Subset { tiles, bits: (0..tiles).step_by(BITS).map(word).collect() }))
    }

    /// Every `of`-th of this many tiles, from tile `first` on. Neighbours are in different sets, so that every set has
    /// a share of even a small model.
    ///
    /// ```
    /// use tercio_raster::TileSet;
    ///
    /// let odd = TileSet::every(2, 1, 5);
    /// assert_eq!((0..5).filter(|&tile| odd.contains(tile)).collect::<Vec<_>>(), [1, 3]);
    /// ```
    pub fn every(of: u32, first: u32, tiles: usize) -> Self {
        Self::from_fn(tiles, |tile| tile % of.max(1) == first)
    }

    /// Is a tile in the set?
    #[inline(always)]
    pub fn contains(&self, tile: u32) -> bool {
        match &self.0 {
            None => true,
            Some(Subset { bits, .. }) => {
                let word = bits.get(tile as usize / BITS).copied().unwrap_or(0);
                word >> (tile as usize % BITS) & 1 == 1
            }
        }
    }

    /// Does the set contain all tiles of any picture?
    #[inline(always)]
    pub fn is_all(&self) -> bool {
        self.0.is_none()
    }

    /// The tiles, in a picture of this many tiles, that are in the set, in order.
    pub fn numbers(&self, tiles: usize) -> impl Iterator<Item = u32> + '_ {
        (0..tiles as u32).filter(|&tile| self.contains(tile))
    }

    /// Number of tiles of the picture that the set is made for; `None` if it is valid for any picture.
    pub fn tiles(&self) -> Option<usize> {
        self.0.as_ref().map(|subset| subset.tiles)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_set_contains_exactly_the_tiles_it_was_made_of() {
        for tiles in [0, 1, 63, 64, 65, 200] {
            let thirds = TileSet::every(3, 2, tiles);
            assert_eq!(thirds.tiles(), Some(tiles));
            for tile in 0..300 {
                assert_eq!(
                    thirds.contains(tile),
                    tile % 3 == 2 && (tile as usize) < tiles,
                    "{tile} of {tiles}"
                );
                assert!(TileSet::ALL.contains(tile));
            }
        }
    }
}
