//! Radix-k.

use std::fmt;

use super::interlaced::{interlaced, owners_of_parts, part};
use super::{Round, Shared, Strategy};

/// The largest sizes of the groups of radix-k, round by round; the last one is that of all further rounds.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Radices {
    of_round: [u16; Self::MOST],
    rounds: usize,
}

impl Radices {
    /// The largest number of rounds with sizes of their own: those of 1,024 ranks in pairs.
    pub const MOST: usize = 10;

    /// The same in every round.
    ///
    /// # Panics
    /// If it is less than 2 or more than 65,535.
    pub const fn same(radix: u32) -> Self {
        assert!(radix >= 2 && radix <= u16::MAX as u32, "groups of 2 to 65,535 ranks");
        Self { of_round: [radix as u16; Self::MOST], rounds: 1 }
    }

    /// Those of the first rounds, each 2 to 65,535; `None` for others, for none and for more than [`Radices::MOST`].
    pub fn new(radices: &[u32]) -> Option<Self> {
        let mut new = Self::same(*radices.first().filter(|&&first| (2..=u16::MAX.into()).contains(&first))?);
        for (to, &radix) in new.of_round.get_mut(..radices.len())?.iter_mut().zip(radices) {
            *to = u16::try_from(radix).ok().filter(|&radix| radix >= 2)?;
        }
        new.rounds = radices.len();
        Some(new)
    }

    /// One, or as many as were given.
    pub fn as_slice(&self) -> &[u16] {
        &self.of_round[..self.rounds]
    }

    /// The sizes of the groups of each round, of so many ranks: their product. Each is the largest factor of what is left that is no
    /// larger than the radix of the round, or else the smallest one.
    pub fn groups(&self, mut ranks: usize) -> Vec<usize> {
        let mut sizes = Vec::new();
        while ranks > 1 {
            let radix = usize::from(self.of_round[sizes.len().min(self.rounds - 1)]).min(ranks);
            let fitting = (2..=radix).rev().find(|size| ranks.is_multiple_of(*size));
            let prime = || (radix + 1..=ranks).find(|size| ranks.is_multiple_of(*size));
            let Some(size) = fitting.or_else(prime) else { unreachable!("a number divides itself") };
            sizes.push(size);
            ranks /= size;
        }
        sizes
    }
}

impl fmt::Display for Radices {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (round, radix) in self.as_slice().iter().enumerate() {
            let comma = if round > 0 { "," } else { "" };
            write!(f, "{comma}{radix}")?;
        }
        Ok(())
    }
}

impl fmt::Debug for Radices {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self}")
    }
}

/// Rounds of groups, which exchange as many parts of their tiles as they have members.
pub struct RadixK {
    /// The sizes of groups.
    pub radices: Radices,
}

impl Strategy for RadixK {
    fn rounds(&self, shared: &Shared, place: usize) -> Vec<Round> {
        rounds_of_groups(&self.radices.groups(shared.ranks.len()), shared.tiles, place, |place| place)
    }

    fn owners(&self, shared: &Shared) -> Vec<usize> {
        owners_of_groups(&self.radices.groups(shared.ranks.len()), shared.tiles.len(), |place| place)
    }
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
    let order = interlaced(tiles);
    let (mut kept, mut distance) = (0..tiles.len(), 1);
    let mut round = |&size: &usize| {
        let digit = own / distance % size;
        let member = |other: usize| own - digit * distance + other * distance;
        let others = |step: usize| (digit + step) % size;
        let send = |other: usize| (place(member(other)), order[part(&kept, other, size)].to_vec());
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
    let kept_by = |member: usize| {
        let (mut kept, mut rest) = (0..tiles, member);
        for &size in sizes {
            kept = part(&kept, rest % size, size);
            rest /= size;
        }
        (kept, place(member))
    };
    owners_of_parts(tiles, (0..sizes.iter().product()).map(kept_by))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_have_the_sizes_that_were_chosen_where_these_divide_the_ranks() {
        let groups = |radices: &[u32], ranks| Radices::new(radices).unwrap().groups(ranks);
        assert_eq!(groups(&[4], 64), [4, 4, 4]);
        assert_eq!(groups(&[16, 2], 64), [16, 2, 2]);
        assert_eq!(groups(&[2, 8, 4], 64), [2, 8, 4]);
        // 5 does not divide 48, and 3 is the smallest factor of 9 that is larger than 2.
        assert_eq!(groups(&[5, 2], 48), [4, 2, 2, 3]);
        assert_eq!(groups(&[2], 9), [3, 3]);
        assert_eq!(groups(&[8, 8], 1), [0usize; 0]);
        assert_eq!(Radices::same(4), Radices::new(&[4]).unwrap());
        assert_eq!(Radices::new(&[2, 8, 4]).unwrap().to_string(), "2,8,4");
        for wrong in [&[][..], &[1], &[4, 1], &[4, 70_000], &[70_000], &[2; 11]] {
            assert_eq!(Radices::new(wrong), None, "{wrong:?}");
        }
    }
}
