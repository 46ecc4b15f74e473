//! Receiving one message from each of several ranks, in the order in which they arrive.

use std::collections::{BTreeSet, HashSet, VecDeque};
use std::fmt;
use std::sync::atomic::{AtomicU64, Ordering};

use super::CommError;

/// Ranks of which one more message is received each, by [`receive_any`](super::Communicator::receive_any).
#[derive(Debug)]
pub struct Awaited {
    ranks: BTreeSet<usize>,
    /// No other one of this process has this number.
    number: u64,
}

impl Awaited {
    /// One message of each of these ranks.
    pub fn new(ranks: impl IntoIterator<Item = usize>) -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(1);
        Self { ranks: ranks.into_iter().collect(), number: NEXT.fetch_add(1, Ordering::Relaxed) }
    }

    /// The same of ranks with other numbers.
    pub(crate) fn map(&self, number: impl Fn(usize) -> usize) -> Self {
        // The number of the series stays: the backend continues it.
        Self { ranks: self.ranks.iter().map(|&rank| number(rank)).collect(), number: self.number }
    }

    /// Whether all messages have been received.
    pub fn is_empty(&self) -> bool {
        self.ranks.is_empty()
    }

    /// Whether the message of a rank has not been received yet.
    pub fn contains(&self, rank: usize) -> bool {
        self.ranks.contains(&rank)
    }

    /// The lowest rank whose message has not been received yet.
    pub fn first(&self) -> Option<usize> {
        self.ranks.first().copied()
    }

    /// Whether a rank of `size` can await all of them: they are other ranks.
    ///
    /// # Errors
    /// [`CommError::NoPartner`].
    pub fn check(&self, rank: usize, size: usize) -> Result<(), CommError> {
        let outside = self.ranks.last().copied().filter(|&last| last >= size);
        match outside.or_else(|| self.contains(rank).then_some(rank)) {
            Some(rank) => Err(CommError::NoPartner { rank, size }),
            None => Ok(()),
        }
    }

    /// The message of a rank has been received.
    pub fn remove(&mut self, rank: usize) {
        self.ranks.remove(&rank);
    }

    /// The ranks whose messages have not been received yet, in order.
    pub fn iter(&self) -> impl Iterator<Item = usize> + '_ {
        self.ranks.iter().copied()
    }

    /// Their names, for messages.
    pub fn names(&self) -> RankNames {
        RankNames { first: self.iter().take(RankNames::MOST).collect(), count: self.ranks.len() }
    }
}

/// Names of ranks: of a few of them, if there are many.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RankNames {
    first: Vec<usize>,
    count: usize,
}

impl RankNames {
    /// Most ranks that are named.
    const MOST: usize = 4;

    /// The lowest rank, if there is one.
    pub fn first(&self) -> Option<usize> {
        self.first.first().copied()
    }

    /// Number of ranks.
    pub fn count(&self) -> usize {
        self.count
    }
}

impl From<usize> for RankNames {
    fn from(rank: usize) -> Self {
        Self { first: vec![rank], count: 1 }
    }
}

impl fmt::Display for RankNames {
    /// "rank 3"; "3 ranks (1, 4 and 5)"; "20 ranks (1, 4, 5, 6 and others)".
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<String> = self.first.iter().map(ToString::to_string).collect();
        match &names[..] {
            [] => f.write_str("no rank"),
            [rank] if self.count == 1 => write!(f, "rank {rank}"),
            _ if self.count > names.len() => {
                write!(f, "{} ranks ({} and others)", self.count, names.join(", "))
            }
            [others @ .., last] => write!(f, "{} ranks ({} and {last})", self.count, others.join(", ")),
        }
    }
}

/// The senders of messages that were not received yet, in the order of arrival: a backend finds an awaited one without
/// asking for every rank. Memory and time grow with the senders, each of which is in here at most once.
#[derive(Debug, Default)]
pub struct ReadySenders {
    queue: VecDeque<usize>,
    /// Those that are not awaited by [`Self::series`].
    others: Vec<usize>,
    /// All in [`Self::queue`] and [`Self::others`].
    listed: HashSet<usize>,
    /// The number of the [`Awaited`] that asked last.
    series: u64,
}

impl ReadySenders {
    /// A message of a rank has arrived.
    pub fn arrived(&mut self, sender: usize) {
        if self.listed.insert(sender) {
            self.queue.push_back(sender);
        }
    }

    /// An awaited rank that has a message, which is then received: it is not awaited any longer. `has_message` returns
    /// whether a rank still has one: it may have been received by [`receive`](super::Communicator::receive).
    pub fn next(&mut self, awaited: &mut Awaited, has_message: impl Fn(usize) -> bool) -> Option<usize> {
        if self.series != awaited.number {
            self.series = awaited.number;
            self.queue.extend(self.others.drain(..));
        }
        while let Some(sender) = self.queue.pop_front() {
            if !has_message(sender) {
                self.listed.remove(&sender);
            } else if awaited.contains(sender) {
                awaited.remove(sender);
                // It may have more messages.
                self.others.push(sender);
                return Some(sender);
            } else {
                self.others.push(sender);
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_ranks_are_named() {
        let names = |ranks: std::ops::Range<usize>| Awaited::new(ranks).names().to_string();
        assert_eq!(names(0..0), "no rank");
        assert_eq!(names(3..4), "rank 3");
        assert_eq!(RankNames::from(3).to_string(), "rank 3");
        assert_eq!(names(3..5), "2 ranks (3 and 4)");
        assert_eq!(names(1..5), "4 ranks (1, 2, 3 and 4)");
        assert_eq!(names(1..90), "89 ranks (1, 2, 3, 4 and others)");
    }

    #[test]
    fn senders_are_found_in_the_order_of_arrival() {
        let mut ready = ReadySenders::default();
        [5, 2, 9, 2, 7].into_iter().for_each(|sender| ready.arrived(sender));
        let mut awaited = Awaited::new([2, 7, 9, 11]);
        // The message of 9 was received in another way.
        let mut next = |awaited: &mut Awaited| ready.next(awaited, |sender| sender != 9);
        assert_eq!(next(&mut awaited), Some(2));
        // Others ask in between.
        assert_eq!(next(&mut Awaited::new([5])), Some(5));
        assert_eq!(next(&mut awaited), Some(7));
        assert_eq!(next(&mut awaited), None);
        assert_eq!(awaited.iter().collect::<Vec<_>>(), [9, 11]);
        // 2 had another message, and 9 gets one.
        assert_eq!(next(&mut Awaited::new([2])), Some(2));
        ready.arrived(9);
        assert_eq!(ready.next(&mut awaited, |_| true), Some(9));
    }

    #[test]
    fn memory_does_not_grow_with_messages() {
        let mut ready = ReadySenders::default();
        for _ in 0..1000 {
            [1, 2, 3].into_iter().for_each(|sender| ready.arrived(sender));
            let mut awaited = Awaited::new([2]);
            assert_eq!(ready.next(&mut awaited, |_| true), Some(2));
            assert!(ready.queue.len() + ready.others.len() <= 3, "{ready:?}");
        }
    }
}
