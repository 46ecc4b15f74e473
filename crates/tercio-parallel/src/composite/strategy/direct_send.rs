//! Direct send.

use super::{Round, Shared, Strategy};

/// Every rank sends its part of a tile to the tile's owner, all in one round.
pub struct DirectSend;

impl Strategy for DirectSend {
    fn rounds(&self, shared: &Shared, place: usize) -> Vec<Round> {
        let (owners, count) = (self.owners(shared), shared.ranks.len());
        let has = |place: usize, tile: u32| shared.touched.is_touched(shared.ranks[place], tile);
        let mut to_owner = vec![Vec::new(); count];
        let mut sends_to_this = vec![false; count];
        for (&tile, &owner) in shared.tiles.iter().zip(&owners) {
            if owner == place {
                (0..count).for_each(|from| sends_to_this[from] |= has(from, tile));
            } else if has(place, tile) {
                to_owner[owner].push(tile);
            }
        }
        // Every rank begins with the next one, so that no rank gets all messages at once.
        let others = || (1..count).map(|step| (place + step) % count);
        let sends = others().map(|to| (to, std::mem::take(&mut to_owner[to])));
        let sends = sends.filter(|(_, tiles)| !tiles.is_empty()).collect();
        let receives = (1..count).map(|step| (place + count - step) % count);
        let receives = receives.filter(|&from| sends_to_this[from]).collect();
        vec![Round { sends, receives }]
    }

    /// Each tile to that of its ranks that merges the fewest parts of other tiles; those with the most parts first.
    fn owners(&self, shared: &Shared) -> Vec<usize> {
        let places = |tile: u32| {
            (0..shared.ranks.len()).filter(move |&place| shared.touched.is_touched(shared.ranks[place], tile))
        };
        let mut order: Vec<(usize, usize)> =
            shared.tiles.iter().map(|&tile| places(tile).count()).enumerate().collect();
        order.sort_by_key(|(_, parts)| std::cmp::Reverse(*parts));
        let mut merged = vec![0; shared.ranks.len()];
        let mut owners = vec![0; shared.tiles.len()];
        for (at, parts) in order {
            let Some(least) = places(shared.tiles[at]).min_by_key(|&place| merged[place]) else {
                unreachable!("a shared tile has several ranks")
            };
            merged[least] += parts;
            owners[at] = least;
        }
        owners
    }
}
