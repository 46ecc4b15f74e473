//! How the pictures of groups become one picture, and how that is delivered.
//!
//! Processors with the same position in their groups halve their part of the picture in every round and exchange the
//! halves (binary swap), with the nearest partner while the halves are large. If the number of groups is no power of
//! two, the excess groups first send their whole part to others. A smaller last group divides the screen in another
//! way; it first sends its pixels to those members of another group that own them there.

use super::regions::Regions;

/// Pixels that one processor sends to another, which merges them with its own, or keeps them in the end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Transfer {
    /// The sender.
    pub from: usize,
    /// The receiver.
    pub to: usize,
    /// How many.
    pub pixels: u64,
    /// Which.
    pub part: Part,
}

/// Some pixels of the screen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Numbers `first` to `end` - 1 of the pixels that a member of a whole group owns.
    Of {
        /// The member.
        member: usize,
        /// The first.
        first: u64,
        /// One after the last.
        end: u64,
    },
    /// Those that one member of the smaller last group and one of a whole group own.
    Common {
        /// The member of the last group.
        last: usize,
        /// That of a whole group.
        whole: usize,
    },
}

/// Groups of consecutive processors, each with the whole screen among its members.
#[derive(Clone, Debug)]
pub struct Groups {
    /// Processors.
    pub processors: usize,
    /// Processors of each group but the last, which may have fewer.
    pub size: usize,
    /// How a whole group divides the screen.
    pub whole: Regions,
    /// How the smaller last group does, if there is one.
    pub last: Regions,
}

impl Groups {
    /// Calls `round` with the transfers of each round of composition, then once more with those that deliver the
    /// finished picture to processor 0.
    pub fn compose(&self, mut round: impl FnMut(Step, &[Transfer])) {
        let (g, whole) = (self.size, self.processors / self.size);
        let owned = self.whole.owned();
        let swapping = 1usize << whole.ilog2();
        let mut transfers = Vec::new();
        for group in swapping..whole {
            transfers.extend(owned.iter().enumerate().map(|(member, &pixels)| Transfer {
                from: group * g + member,
                to: (group - swapping) * g + member,
                pixels,
                part: Part::Of { member, first: 0, end: pixels },
            }));
        }
        // To the first group that no excess group sends to: there is one.
        let beside = whole - swapping;
        if !self.processors.is_multiple_of(g) {
            transfers.extend(self.common().map(|(last, member, pixels)| Transfer {
                from: whole * g + last,
                to: beside * g + member,
                pixels,
                part: Part::Common { last, whole: member },
            }));
        }
        finish(Step::Composition, &mut transfers, &mut round);
        let mut held: Vec<[u64; 2]> = (0..swapping * g).map(|p| [0, owned[p % g]]).collect();
        for bit in 0..swapping.ilog2() {
            for group in 0..swapping {
                let partner = group ^ 1 << bit;
                for member in 0..g {
                    let [first, end] = &mut held[group * g + member];
                    let middle = *first + (*end - *first).div_ceil(2);
                    // The lower group keeps the first half and sends the second.
                    let sent = if group < partner { [middle, *end] } else { [*first, middle] };
                    *(if group < partner { end } else { first }) = middle;
                    transfers.push(Transfer {
                        from: group * g + member,
                        to: partner * g + member,
                        pixels: sent[1] - sent[0],
                        part: Part::Of { member, first: sent[0], end: sent[1] },
                    });
                }
            }
            finish(Step::Composition, &mut transfers, &mut round);
        }
        transfers.extend(held.iter().enumerate().skip(1).map(|(from, &[first, end])| Transfer {
            from,
            to: 0,
            pixels: end - first,
            part: Part::Of { member: from % g, first, end },
        }));
        finish(Step::Delivery, &mut transfers, &mut round);
    }

    /// Pixels that members of the last group and of a whole one own both: the members and the number.
    fn common(&self) -> impl Iterator<Item = (usize, usize, u64)> {
        let mut pieces = Vec::new();
        for region in 0..self.last.count() {
            let last = self.last.owner(region);
            let touched = self.whole.touched(self.last.pixels(region));
            pieces.extend(touched.map(|(other, pixels)| ((last, self.whole.owner(other)), pixels)));
        }
        pieces.sort_unstable();
        let mut pieces = pieces.into_iter().peekable();
        std::iter::from_fn(move || {
            let (pair, mut sum) = pieces.next()?;
            while let Some((_, pixels)) = pieces.next_if(|next| next.0 == pair) {
                sum += pixels;
            }
            Some((pair.0, pair.1, sum))
        })
    }
}

/// What transfers are for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// Pictures are merged.
    Composition,
    /// The finished picture is put together.
    Delivery,
}

fn finish(step: Step, transfers: &mut Vec<Transfer>, round: &mut impl FnMut(Step, &[Transfer])) {
    transfers.retain(|t| t.pixels > 0);
    if !transfers.is_empty() {
        round(step, transfers);
    }
    transfers.clear();
}

#[cfg(test)]
mod tests {
    use std::collections::{BTreeMap, BTreeSet};

    use proptest::prelude::*;

    use super::*;
    use crate::simulators::sorting::Assignment;

    /// The owner of each pixel, and its number among the owner's.
    fn owners(regions: &Regions) -> Vec<(usize, u64)> {
        let mut owners = vec![(0, 0); (regions.width * regions.height) as usize];
        let mut count = vec![0; regions.owners];
        for region in 0..regions.count() {
            let (owner, pixels) = (regions.owner(region), regions.pixels(region));
            for y in pixels.y0..=pixels.y1 {
                for x in pixels.x0..=pixels.x1 {
                    owners[(y * regions.width as i32 + x) as usize] = (owner, count[owner]);
                    count[owner] += 1;
                }
            }
        }
        owners
    }

    proptest! {
        /// Plays the transfers with every pixel: each group's is merged exactly once, and all end on processor 0.
        #[test]
        fn every_pixel_of_every_group_reaches_the_picture_once(
            processors in 1usize..40, size in 1usize..40, edge in 1u32..7, width in 1u32..20, height in 1u32..9,
            blocks in any::<bool>(),
        ) {
            let size = size.min(processors);
            let assignment = if blocks { Assignment::Blocks } else { Assignment::Interleaved };
            let regions = |owners| Regions { width, height, edge, owners, assignment };
            let last = (processors % size).max(1);
            let groups = Groups { processors, size, whole: regions(size), last: regions(last) };
            let (of_whole, of_last) = (owners(&groups.whole), owners(&groups.last));
            // What each processor has: of which groups each of its pixels is.
            let mut has = vec![BTreeMap::<usize, BTreeSet<usize>>::new(); processors];
            let all = processors.div_ceil(size);
            for group in 0..all {
                let members = if (group + 1) * size <= processors { &of_whole } else { &of_last };
                for (pixel, (owner, _)) in members.iter().enumerate() {
                    has[group * size + owner].insert(pixel, BTreeSet::from([group]));
                }
            }
            groups.compose(|_, transfers| {
                let mut moved = Vec::new();
                for t in transfers {
                    let is_part = |pixel: usize| match t.part {
                        Part::Of { member, first, end } => {
                            of_whole[pixel].0 == member && (first..end).contains(&of_whole[pixel].1)
                        }
                        Part::Common { last, whole } => of_last[pixel].0 == last && of_whole[pixel].0 == whole,
                    };
                    let pixels: Vec<_> = (0..of_whole.len()).filter(|&pixel| is_part(pixel)).collect();
                    assert_eq!(pixels.len() as u64, t.pixels, "{t:?}");
                    for pixel in pixels {
                        let groups = has[t.from].remove(&pixel).expect("the sender has it");
                        moved.push((t.to, pixel, groups));
                    }
                }
                for (to, pixel, groups) in moved {
                    let own = has[to].entry(pixel).or_default();
                    for group in groups {
                        assert!(own.insert(group), "pixel {pixel} of group {group} is merged twice");
                    }
                }
            });
            prop_assert!(has[1..].iter().all(BTreeMap::is_empty));
            prop_assert_eq!(has[0].len(), (width * height) as usize);
            prop_assert!(has[0].values().all(|groups| groups.len() == all));
        }
    }
}
