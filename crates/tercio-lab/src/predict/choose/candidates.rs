//! The ways to share a frame that are compared.

use tercio_parallel::{Composition, Division, Organisation, Radices, Sharing};

use super::compose::even_groups;

/// Above this many ranks fewer candidates are compared, so that choosing does not take longer than it gains.
pub const MANY: usize = 64;

/// What the caller has decided already: only ways that use it are candidates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Limits {
    /// Ranks of a group: only sort-twice.
    pub group: Option<usize>,
    /// How tiles are divided: not sort-last, which does not divide the picture.
    pub division: Option<Division>,
    /// How pictures are composited: only sort-last and sort-twice.
    pub composition: Option<Composition>,
    /// Compares what is seldom the fastest, too, for who has the time: all divisions and, of few ranks, groups of any size and any
    /// radix; 2-3 swap where it is not another strategy; the serial ring, which has the work of a tree in more rounds.
    pub all: bool,
}

/// No way to share a frame fits the limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoCandidate {
    /// There are not so many ranks.
    #[error("groups of {group} ranks: there are {ranks} ranks")]
    Group {
        /// Ranks of a group.
        group: usize,
        /// Ranks.
        ranks: usize,
    },
    /// Only sort-twice divides and composites, and needs three ranks for that.
    #[error(
        "a division of the picture together with a composition is for sort-twice, which needs 3 ranks or more: there are \
         {ranks}"
    )]
    TooFewToDoBoth {
        /// Ranks.
        ranks: usize,
    },
}

impl Limits {
    /// All that there is, at the price of time.
    pub const ALL: Self = Self { group: None, division: None, composition: None, all: true };

    /// The candidates for so many ranks, at least 1, simple ones first: of equally fast ones the first is taken. Never empty.
    ///
    /// # Errors
    /// [`NoCandidate`].
    pub fn candidates(&self, ranks: usize) -> Result<Vec<Sharing>, NoCandidate> {
        let ranks = ranks.max(1);
        if let Some(group) = self.group.filter(|&group| group > ranks || group == 0) {
            return Err(NoCandidate::Group { group, ranks });
        }
        let mut found = Vec::new();
        for organisation in self.organisations(ranks) {
            let divides = organisation != Organisation::SortLast;
            let composites = matches!(organisation, Organisation::SortLast | Organisation::SortTwice { .. });
            if self.division.is_some() && !divides || self.composition.is_some() && !composites {
                continue;
            }
            let usual = Sharing::from(organisation);
            let divisions = if divides { self.divisions(organisation, ranks) } else { vec![usual.division] };
            let compositions = if composites { self.compositions(ranks) } else { vec![usual.composition] };
            for &composition in &compositions {
                let with = |&division: &Division| Sharing { division, composition, ..usual };
                found.extend(divisions.iter().map(with));
            }
        }
        if found.is_empty() { Err(NoCandidate::TooFewToDoBoth { ranks }) } else { Ok(found) }
    }

    fn organisations(&self, ranks: usize) -> Vec<Organisation> {
        use Organisation::{SortFirst, SortLast, SortMiddle, SortTwice};
        if let Some(group) = self.group {
            return vec![SortTwice { group }];
        }
        if ranks == 1 {
            // All are the same; one that has what was decided.
            let both = self.division.is_some() && self.composition.is_some();
            return vec![if both {
                SortTwice { group: 1 }
            } else if self.composition.is_some() {
                SortLast
            } else {
                SortMiddle
            }];
        }
        let groups = group_sizes(ranks, self.all).into_iter().map(|group| SortTwice { group });
        [SortMiddle, SortFirst, SortLast].into_iter().chain(groups).collect()
    }

    fn divisions(&self, organisation: Organisation, ranks: usize) -> Vec<Division> {
        use Division::{Balanced, Blocks, Interleaved};
        if let Some(division) = self.division {
            return vec![division];
        }
        if ranks == 1 {
            return vec![Balanced];
        }
        match organisation {
            Organisation::SortTwice { .. } if !self.all || ranks > MANY => vec![Balanced, Interleaved],
            _ if ranks > MANY => vec![Balanced, Interleaved, Blocks],
            // What is counted in the last frame is not predicted.
            _ => Division::STATIC.to_vec(),
        }
    }

    fn compositions(&self, ranks: usize) -> Vec<Composition> {
        if let Some(composition) = self.composition {
            return vec![composition];
        }
        let mut all = vec![Composition::DirectSend];
        if ranks > 1 {
            all.push(Composition::Tree);
        }
        let radices = radices(ranks, self.all);
        if ranks > 2 {
            all.push(Composition::BinarySwap);
            let known = |groups: Vec<usize>| {
                is_usual(&groups) || radices.iter().any(|&radix| Radices::same(radix).groups(ranks) == groups)
            };
            if self.all && !even_groups(ranks).is_some_and(known) {
                all.push(Composition::TwoThreeSwap);
            }
        }
        all.extend(radices.into_iter().map(Composition::radix_k));
        if self.all && ranks > 2 {
            all.push(Composition::Ring);
        }
        all
    }
}

/// Radices: 4 and 8; of few ranks `all`. Of those whose rounds have groups of the same sizes one, and none whose rounds are those of direct
/// send or binary swap.
fn radices(ranks: usize, all: bool) -> Vec<u32> {
    let more = if all && ranks <= FEW { 2..ranks as u32 } else { 0..0 };
    let mut found: Vec<(u32, Vec<usize>)> = Vec::new();
    for radix in [4, 8].into_iter().chain(more) {
        let rounds = Radices::same(radix).groups(ranks);
        if !is_usual(&rounds) && found.iter().all(|(_, known)| *known != rounds) {
            found.push((radix, rounds));
        }
    }
    found.into_iter().map(|(radix, _)| radix).collect()
}

/// Whether rounds with groups of these sizes are direct send or binary swap.
fn is_usual(groups: &[usize]) -> bool {
    groups.len() < 2 || groups.iter().all(|&size| size == 2)
}

/// Up to so many ranks groups of all divisors of their number are compared, too, or of all sizes.
const FEW: usize = 16;

/// Sizes of the groups of sort-twice: powers of two; of few ranks divisors, too, or `all`; of many, three powers of two around the
/// square root.
fn group_sizes(ranks: usize, all: bool) -> Vec<usize> {
    let inside = 2..ranks;
    if ranks > MANY {
        let middle = 1 << (ranks.ilog2() / 2);
        return [middle / 4, middle, middle * 4].into_iter().filter(|size| inside.contains(size)).collect();
    }
    let is_one = |size: usize| size.is_power_of_two() || ranks <= FEW && (all || ranks.is_multiple_of(size));
    inside.filter(|&size| is_one(size)).collect()
}

#[cfg(test)]
mod tests {
    use tercio_parallel::composite::{Round, Shared, Touched};

    use super::*;

    const NONE: Limits = Limits { group: None, division: None, composition: None, all: false };

    #[test]
    fn candidates_are_different_and_fewer_for_many_ranks() {
        for ranks in [1, 2, 3, 4, 6, 16, 48, 64, 65, 256, 1000, 1024] {
            let all = NONE.candidates(ranks).expect("there are always some");
            for (number, one) in all.iter().enumerate() {
                assert!(!all[..number].contains(one), "{ranks}: {one:?} twice");
                assert!(one.organisation.group(ranks) <= ranks);
            }
            assert_eq!(all[0], Organisation::SortMiddle.into());
            assert!(all.len() <= if ranks > MANY { 45 } else { 90 }, "{ranks}: {}", all.len());
        }
        assert_eq!(NONE.candidates(1).map(|all| all.len()), Ok(1));
        assert_eq!(group_sizes(6, false), [2, 3, 4]);
        assert_eq!(group_sizes(1024, false), [8, 32, 128]);
    }

    /// Every sharing that the options of `tercio render` can name with one radix, for few ranks, except those whose messages are the same.
    #[test]
    fn all_are_all_that_the_options_can_name() {
        use Composition::{BinarySwap, DirectSend, Ring, Tree, TwoThreeSwap};
        for ranks in 1..=FEW {
            let all = Limits::ALL.candidates(ranks).expect("there are always some");
            let usual = NONE.candidates(ranks).expect("there are always some");
            assert!(usual.iter().all(|one| all.contains(one)), "{ranks}");
            if ranks < 2 {
                continue;
            }
            let mut named = Vec::new();
            for division in Division::STATIC {
                named.push(Sharing { division, ..Organisation::SortFirst.into() });
                named.push(Sharing { division, ..Organisation::SortMiddle.into() });
            }
            let radices = (2..=ranks as u32).map(Composition::radix_k);
            let compositions = [DirectSend, BinarySwap, TwoThreeSwap, Tree, Ring].into_iter().chain(radices);
            for composition in compositions.clone() {
                named.push(Sharing { composition, ..Organisation::SortLast.into() });
                for (group, division) in
                    (2..ranks).flat_map(|g| Division::STATIC.map(|division| (g, division)))
                {
                    let organisation = Organisation::SortTwice { group };
                    named.push(Sharing { division, composition, ..organisation.into() });
                }
            }
            for (number, one) in all.iter().enumerate() {
                assert!(!all[..number].contains(one), "{ranks}: {one:?} twice");
                assert!(named.contains(one), "{ranks}: {one:?}");
            }
            // As many tiles as all parts divide evenly: then the same messages have as many tiles, whichever these are.
            let (tiles, places): (Vec<u32>, Vec<usize>) =
                ((0..16 * ranks as u32).collect(), (0..ranks).collect());
            let touched = Touched::new(tiles.len(), (0..ranks).map(|_| |_| true));
            let shared = Shared { tiles: &tiles, ranks: &places, touched: &touched };
            let messages = |round: &Round| {
                let mut sends: Vec<_> = round.sends.iter().map(|(to, tiles)| (*to, tiles.len())).collect();
                sends.sort_unstable();
                sends
            };
            let rounds = |c: Composition| -> Vec<Vec<_>> {
                places.iter().map(|&p| c.rounds(&shared, p).iter().map(messages).collect()).collect()
            };
            let known: Vec<Composition> = Limits::ALL.compositions(ranks);
            for (number, one) in known.iter().enumerate() {
                let same = known[..number].iter().find(|&&other| rounds(other) == rounds(*one));
                assert_eq!(same, None, "{ranks}: {one} has the same rounds");
            }
            // Of these the rounds of 2-3 swap are those of another strategy.
            let other = ![1, 2, 3, 4, 6, 8, 12, 16].contains(&ranks);
            assert_eq!(known.contains(&TwoThreeSwap), other, "{ranks}");
            // Which of the candidates' compositions has the rounds of one that can be named.
            let stands_for: Vec<(Composition, Composition)> = compositions
                .clone()
                .map(|named| {
                    let like = known.iter().find(|&&k| k == named || rounds(k) == rounds(named));
                    (named, *like.unwrap_or_else(|| panic!("{ranks}: {named}")))
                })
                .collect();
            for one in &named {
                let like = stands_for.iter().find(|(named, _)| *named == one.composition).expect("named").1;
                assert!(all.contains(&Sharing { composition: like, ..*one }), "{ranks}: {one:?}");
            }
        }
    }

    /// Radix-4 and radix-8 of 25 ranks are two rounds of groups of five, and of 17 direct send.
    #[test]
    fn no_two_radices_have_the_same_rounds() {
        for ranks in (1..=100).chain([1000, 1024, 4096]) {
            for limits in [NONE, Limits::ALL] {
                let mut plans =
                    vec![Radices::same((ranks as u32).max(2)).groups(ranks), Radices::same(2).groups(ranks)];
                plans.retain(|plan| plan.len() < 2 || ranks.is_power_of_two());
                for radix in radices(ranks, limits.all) {
                    let plan = Radices::same(radix).groups(ranks);
                    assert!(
                        !plans.contains(&plan),
                        "{ranks}: radix-{radix} has the groups {plan:?} of another"
                    );
                    plans.push(plan);
                }
            }
        }
        assert_eq!(
            [25, 17, 64, 60].map(|ranks| radices(ranks, false)),
            [vec![4], vec![], vec![4, 8], vec![4, 8]]
        );
    }

    #[test]
    fn what_was_decided_is_kept() {
        let rows = Limits { division: Some(Division::Rows), ..NONE };
        let all = rows.candidates(4).expect("some");
        assert!(all.iter().all(|c| c.division == Division::Rows && c.organisation != Organisation::SortLast));
        let tree = Limits { composition: Some(Composition::Tree), ..NONE };
        let all = tree.candidates(4).expect("some");
        assert!(all.iter().all(|c| c.composition == Composition::Tree && c.organisation.composites(4)));
        let both = Limits { division: Some(Division::Rows), ..tree };
        let all = both.candidates(3).expect("sort-twice");
        assert_eq!(
            all,
            [Sharing {
                division: Division::Rows,
                composition: Composition::Tree,
                ..Organisation::SortTwice { group: 2 }.into()
            }]
        );
        assert_eq!(both.candidates(2), Err(NoCandidate::TooFewToDoBoth { ranks: 2 }));
        assert_eq!(both.candidates(1).map(|all| all.len()), Ok(1));
        let group = Limits { group: Some(5), ..NONE };
        assert_eq!(group.candidates(4), Err(NoCandidate::Group { group: 5, ranks: 4 }));
        let twice = Organisation::SortTwice { group: 5 };
        assert!(group.candidates(8).expect("some").iter().all(|c| c.organisation == twice));
    }
}
