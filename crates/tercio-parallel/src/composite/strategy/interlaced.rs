//! Parts of interlaced tiles: tiles in an order in which each part of it has tiles of the whole picture.

use std::ops::Range;

use crate::numbers::gcd;

/// Part `number` of `of` about equal parts of a range.
pub fn part(range: &Range<usize>, number: usize, of: usize) -> Range<usize> {
    let at = |number: usize| range.start + range.len() * number / of;
    at(number)..at(number + 1)
}

/// Tiles in the order in which they are divided: neighbours in the picture get far apart, so that every part of the order has tiles of
/// the whole picture. Otherwise the ranks whose parts are in the middle of the picture would merge most.
pub fn interlaced(tiles: &[u32]) -> Vec<u32> {
    order(tiles.len()).map(|at| tiles[at]).collect()
}

/// The owner of each of so many tiles, from parts of the tiles as [`interlaced`] and their owners.
pub fn owners_of_parts(tiles: usize, parts: impl Iterator<Item = (Range<usize>, usize)>) -> Vec<usize> {
    let order: Vec<usize> = order(tiles).collect();
    let mut owners = vec![0; tiles];
    for (part, owner) in parts {
        order[part].iter().for_each(|&at| owners[at] = owner);
    }
    owners
}

/// The places of interlaced tiles. Each step is about the golden section of the number of tiles, which spreads the rows and columns
/// of a part of any length, whatever the number of columns.
fn order(tiles: usize) -> impl Iterator<Item = usize> {
    let near = (tiles as f64 * 0.618_034) as usize;
    let step = (near..).find(|&step| gcd(step, tiles) == 1).unwrap_or(1);
    (0..tiles).map(move |number| number * step % tiles)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_are_divided_in_an_order_that_has_each_once() {
        for tiles in [0, 1, 2, 3, 7, 8, 100, 256, 1023] {
            let mut order: Vec<usize> = order(tiles).collect();
            let are_apart = |pair: &[usize]| pair[0].abs_diff(pair[1]) >= tiles / 4;
            assert!(order.windows(2).all(are_apart), "{tiles}: {order:?}");
            order.sort_unstable();
            assert!(order.into_iter().eq(0..tiles), "{tiles}");
        }
    }

    #[test]
    fn owners_have_the_tiles_of_their_parts() {
        let tiles: Vec<u32> = (0..10).collect();
        let owners = owners_of_parts(10, (0..3).map(|number| (part(&(0..10), number, 3), number)));
        for number in 0..3 {
            let of_part = &interlaced(&tiles)[part(&(0..10), number, 3)];
            assert!(of_part.iter().all(|&tile| owners[tile as usize] == number), "{number}: {owners:?}");
        }
    }
}
