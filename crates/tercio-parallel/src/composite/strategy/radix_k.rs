//! Radix-k.

use std::ops::Range;

use super::{Round, Shared, Strategy};

/// Rounds of groups, which exchange as many parts of their tiles as they have members.
pub struct RadixK {
    /// The largest size of a group, if the number of ranks has such factors.
    pub radix: u32,
}

impl RadixK {
    /// The sizes of the groups of each round. Their product is the number of ranks.
    fn sizes(&self, mut count: usize) -> Vec<usize> {
        let mut sizes = Vec::new();
        while count > 1 {
            let radix = (self.radix.max(2) as usize).min(count);
            let fitting = (2..=radix).rev().find(|size| count.is_multiple_of(*size));
            let prime = || (radix + 1..=count).find(|size| count.is_multiple_of(*size));
            let Some(size) = fitting.or_else(prime) else { unreachable!("a number divides itself") };
            sizes.push(size);
            count /= size;
        }
        sizes
    }
}

impl Strategy for RadixK {
    fn rounds(&self, shared: &Shared, place: usize) -> Vec<Round> {
        rounds_of_groups(&self.sizes(shared.ranks.len()), shared.tiles, place, |place| place)
    }

    fn owners(&self, shared: &Shared) -> Vec<usize> {
        owners_of_groups(&self.sizes(shared.ranks.len()), shared.tiles.len(), |place| place)
    }
}

/// Part `number` of `of` about equal parts of a range.
pub fn part(range: &Range<usize>, number: usize, of: usize) -> Range<usize> {
    let at = |number: usize| range.start + range.len() * number / of;
    at(number)..at(number + 1)
}

/// The rounds of member `own` of as many as the product of `sizes`. In each round members whose numbers differ in one digit
/// (of a number system with these sizes as bases) exchange the parts of the tiles that they have. `place` is where a member is
/// among all ranks.
pub fn rounds_of_groups(
    sizes: &[usize],
    tiles: &[u32],
    own: usize,
    place: impl Fn(usize) -> usize,
) -> Vec<Round> {
    let (mut kept, mut distance) = (0..tiles.len(), 1);
    let mut round = |&size: &usize| {
        let digit = own / distance % size;
        let member = |other: usize| own - digit * distance + other * distance;
        let others = |step: usize| (digit + step) % size;
        let send = |other: usize| (place(member(other)), tiles[part(&kept, other, size)].to_vec());
        let sends = (1..size).map(|step| send(others(step))).collect();
        let receives = (1..size).map(|step| place(member(others(size - step)))).collect();
        kept = part(&kept, digit, size);
        distance *= size;
        Round { sends, receives }
    };
    sizes.iter().map(&mut round).collect()
}

/// The place of the owner of each of so many tiles, after the rounds of [`rounds_of_groups`].
pub fn owners_of_groups(sizes: &[usize], tiles: usize, place: impl Fn(usize) -> usize) -> Vec<usize> {
    let mut owners = vec![0; tiles];
    for member in 0..sizes.iter().product::<usize>() {
        let (mut kept, mut rest) = (0..tiles, member);
        for &size in sizes {
            kept = part(&kept, rest % size, size);
            rest /= size;
        }
        owners[kept].fill(place(member));
    }
    owners
}
