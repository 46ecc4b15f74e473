//! Some ranks of a communicator as a communicator of their own.

use std::time::Duration;

use tercio_mesh::checksum;

use super::{Awaited, CommError, Communicator, Traffic};

/// Access to some ranks of a communicator, the *members*, which are numbered from 0 in their order. Messages go through that
/// communicator: two ranks get theirs in the order in which they were sent, whether by a group or not. So a group costs no messages,
/// and members may call its functions while other ranks do something else.
///
/// Errors name ranks by their numbers in the communicator.
#[derive(Debug)]
pub struct Group<'a, C> {
    inner: &'a mut C,
    /// Their numbers in the communicator.
    members: Vec<usize>,
    rank: usize,
}

impl<'a, C: Communicator> Group<'a, C> {
    /// The group of these ranks, of which this rank is one.
    ///
    /// # Panics
    /// If this rank is not a member, or a member is listed twice or is not a rank of the communicator.
    pub fn new(inner: &'a mut C, members: impl IntoIterator<Item = usize>) -> Self {
        let members: Vec<usize> = members.into_iter().collect();
        let mut sorted = members.clone();
        sorted.sort_unstable();
        assert!(sorted.is_sorted_by(|a, b| a < b), "a rank is a member twice");
        assert!(sorted.last().is_none_or(|&last| last < inner.size()), "a member is no rank");
        let Some(rank) = members.iter().position(|&member| member == inner.rank()) else {
            panic!("rank {} is not a member", inner.rank())
        };
        Self { inner, members, rank }
    }

    /// Divides the ranks of a communicator, all of which have to call this, into the groups of those with the same `color`; members
    /// are in the order of their `key`, then of their ranks.
    ///
    /// # Errors
    /// [`CommError`].
    pub fn split(inner: &'a mut C, color: u64, key: u64) -> Result<Self, CommError> {
        let blocks = inner.all_gather([color, key].map(u64::to_le_bytes).concat())?;
        let mut members = Vec::new();
        for (rank, block) in blocks.iter().enumerate() {
            let &[of, key] = block.as_chunks().0 else {
                let reason = "colour and key of a group".into();
                return Err(CommError::Transport { rank: inner.outer_rank(rank), reason });
            };
            if u64::from_le_bytes(of) == color {
                members.push((u64::from_le_bytes(key), rank));
            }
        }
        members.sort_unstable();
        Ok(Self::new(inner, members.into_iter().map(|(_, rank)| rank)))
    }

    /// Divides the ranks of a communicator, all of which have to call this, into the groups of those on one
    /// [machine](Communicator::machine).
    ///
    /// # Errors
    /// [`CommError`].
    pub fn of_machine(inner: &'a mut C) -> Result<Self, CommError> {
        let machine = checksum::of(inner.machine().as_bytes());
        Self::split(inner, machine, 0)
    }

    /// The members' numbers in the communicator.
    pub fn members(&self) -> &[usize] {
        &self.members
    }

    /// A member's number in the communicator.
    fn member(&self, rank: usize) -> Result<usize, CommError> {
        let size = self.members.len();
        self.members.get(rank).copied().ok_or(CommError::NoPartner { rank, size })
    }
}

impl<C: Communicator> Communicator for Group<'_, C> {
    fn rank(&self) -> usize {
        self.rank
    }

    fn size(&self) -> usize {
        self.members.len()
    }

    fn outer_rank(&self, rank: usize) -> usize {
        self.inner.outer_rank(self.members[rank])
    }

    fn machine(&self) -> String {
        self.inner.machine()
    }

    fn send(&mut self, to: usize, message: Vec<u8>) -> Result<(), CommError> {
        self.inner.send(self.member(to)?, message)
    }

    fn receive(&mut self, from: usize) -> Result<Vec<u8>, CommError> {
        self.inner.receive(self.member(from)?)
    }

    fn receive_within(&mut self, from: usize, time: Duration) -> Result<Option<Vec<u8>>, CommError> {
        self.inner.receive_within(self.member(from)?, time)
    }

    fn receive_any(&mut self, awaited: &mut Awaited) -> Result<(usize, Vec<u8>), CommError> {
        awaited.check(self.rank, self.members.len())?;
        let mut outer = awaited.map(|rank| self.members[rank]);
        let (member, message) = self.inner.receive_any(&mut outer)?;
        let Some(from) = awaited.iter().find(|&rank| self.members[rank] == member) else {
            unreachable!("only messages of awaited ranks are received")
        };
        awaited.remove(from);
        Ok((from, message))
    }

    fn flush(&mut self) -> Result<(), CommError> {
        self.inner.flush()
    }

    fn buffer(&mut self, to: usize) -> Vec<u8> {
        self.inner.buffer(self.members[to])
    }

    fn give_back(&mut self, from: usize, message: Vec<u8>) {
        self.inner.give_back(self.members[from], message);
    }

    fn traffic(&self) -> Traffic {
        self.inner.traffic()
    }

    fn signal(&mut self, to: usize) -> Result<(), CommError> {
        self.inner.signal(self.member(to)?)
    }

    fn await_signal(&mut self, from: usize) -> Result<(), CommError> {
        self.inner.await_signal(self.member(from)?)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::time::Instant;

    use super::*;
    use crate::comm::collective::{all_sum, broadcast};
    use crate::comm::threads::{ThreadComm, run};

    #[test]
    fn ranks_are_divided_by_colour_and_ordered_by_key() {
        for size in 1..=13 {
            let got = run(size, |comm| {
                let rank = comm.rank();
                // Three colours; within one, the order of ranks reversed, but for the last one, whose keys are the same.
                let key = if rank % 3 == 2 { 7 } else { (size - rank) as u64 };
                let mut group = Group::split(comm, rank as u64 % 3, key)?;
                assert_eq!((group.size(), group.members()[group.rank()]), (group.members().len(), rank));
                assert_eq!(group.outer_rank(group.rank()), rank);
                let [sum, count] = all_sum(&mut group, [rank as u64, 1])?;
                let first = broadcast(&mut group, vec![rank as u8])?;
                group.barrier()?;
                let all = group.all_gather(vec![rank as u8])?;
                Ok((group.members().to_vec(), sum, count, first, all.concat()))
            });
            for (rank, (members, sum, count, first, all)) in got.expect("no errors").into_iter().enumerate() {
                let mut expected: Vec<usize> = (0..size).filter(|other| other % 3 == rank % 3).collect();
                if rank % 3 < 2 {
                    expected.reverse();
                }
                assert_eq!(members, expected);
                assert_eq!(sum, expected.iter().sum::<usize>() as u64);
                assert_eq!(count, expected.len() as u64);
                let bytes: Vec<u8> = expected.iter().map(|&rank| rank as u8).collect();
                assert_eq!((first, all), (bytes[..1].to_vec(), bytes));
            }
        }
    }

    #[test]
    fn groups_have_groups_and_errors_name_the_outermost_ranks() {
        let got = run(12, |comm| {
            // 1, 3, 5, 7, 9, 11; of these 3, 7, 11.
            let rank = comm.rank();
            let mut odd = Group::split(comm, rank as u64 % 2, 0)?;
            let color = odd.rank() as u64 % 2;
            let mut fourth = Group::split(&mut odd, color, 0)?;
            if rank % 4 == 3 {
                let place = fourth.rank();
                assert_eq!((fourth.outer_rank(0), fourth.outer_rank(place)), (3, rank));
                assert_eq!(fourth.send(3, Vec::new()), Err(CommError::NoPartner { rank: 3, size: 3 }));
                let own = fourth.send(place, Vec::new());
                assert!(matches!(own, Err(CommError::NoPartner { .. })), "{own:?}");
                // Ranks that call with other arrays.
                let sums = if place == 2 {
                    all_sum(&mut fourth, [1]).map(|_| ())
                } else {
                    all_sum(&mut fourth, [1, 2]).map(|_| ())
                };
                return Ok(sums.err());
            }
            Ok(None)
        });
        let errors = got.expect("no errors");
        let named = errors[3].as_ref().expect("rank 11 sends something else").to_string();
        assert!(named.contains("rank 11"), "{named}");
    }

    #[test]
    fn messages_of_any_member_are_received() {
        let got = run(7, |comm| {
            let members = [5, 1, 3];
            if !members.contains(&comm.rank()) {
                return Ok(Vec::new());
            }
            let mut group = Group::new(comm, members);
            if group.rank() > 0 {
                let own = group.rank() as u8;
                group.send(0, vec![own])?;
                return Ok(Vec::new());
            }
            let mut awaited = Awaited::new([1, 2]);
            let mut all = Vec::new();
            while !awaited.is_empty() {
                let (from, message) = group.receive_any(&mut awaited)?;
                assert_eq!(usize::from(message[0]), from);
                all.push(from);
            }
            let traffic = group.traffic();
            assert_eq!((traffic.taken_messages, traffic.taken_bytes), (2, 2));
            all.sort_unstable();
            Ok(all)
        });
        assert_eq!(got.expect("no errors")[5], [1, 2]);
    }

    #[test]
    fn threads_are_on_one_machine() {
        let sizes = run(3, |comm| Ok(Group::of_machine(comm)?.size()));
        assert_eq!(sizes.expect("no errors"), [3; 3]);
    }

    #[test]
    fn a_message_is_waited_for_no_longer_than_that() {
        let waiting = AtomicUsize::new(0);
        run(2, |comm| {
            let mut group = Group::new(comm, [1, 0]);
            if group.rank() == 1 {
                while waiting.load(Ordering::SeqCst) == 0 {
                    std::thread::yield_now();
                }
                group.send(0, vec![7])?;
                group.await_signal(0)?;
                return Ok(());
            }
            let begin = Instant::now();
            assert_eq!(group.receive_within(1, Duration::ZERO), Ok(None));
            assert_eq!(group.receive_within(1, Duration::from_millis(30)), Ok(None));
            assert!(begin.elapsed() >= Duration::from_millis(30));
            waiting.store(1, Ordering::SeqCst);
            assert_eq!(group.receive_within(1, Duration::MAX), Ok(Some(vec![7])));
            assert_eq!((group.traffic().taken_messages, group.traffic().taken_bytes), (1, 1));
            group.signal(1)?;
            // It ends then.
            assert_eq!(group.receive_within(1, Duration::from_secs(60)), Err(CommError::Gone { rank: 0 }));
            Ok(())
        })
        .expect("no errors");
    }

    #[test]
    #[should_panic(expected = "rank 0 is not a member")]
    fn a_rank_is_a_member_of_its_group() {
        let mut comms = ThreadComm::for_ranks(3);
        let _ = Group::new(&mut comms[0], [1, 2]);
    }
}
