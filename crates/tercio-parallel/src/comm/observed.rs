//! Counts of messages by partner and kind.

use std::collections::BTreeMap;
use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::{Awaited, CommError, Communicator, Kind, Traffic};

/// Messages of one kind between a rank and another one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PartnerTraffic {
    /// The other rank.
    pub partner: usize,
    /// What the messages are for.
    pub kind: Kind,
    /// Their counts. Signals are messages without bytes here, although [`Communicator::traffic`] does not count them.
    #[serde(flatten)]
    pub traffic: Traffic,
}

/// A rank's access to the other ranks that counts messages by partner and kind.
#[derive(Debug)]
pub struct Observed<'a, C> {
    inner: &'a mut C,
    kind: Kind,
    counts: BTreeMap<(usize, Kind), Traffic>,
}

impl<'a, C: Communicator> Observed<'a, C> {
    /// No messages yet; the next ones are of this kind.
    pub fn new(inner: &'a mut C, kind: Kind) -> Self {
        Self { inner, kind, counts: BTreeMap::new() }
    }

    /// From now on messages are of this kind.
    pub fn begin(&mut self, kind: Kind) {
        self.kind = kind;
    }

    /// The counts, in the order of partners, then of kinds.
    pub fn finish(self) -> Vec<PartnerTraffic> {
        let counts = self.counts.into_iter();
        counts.map(|((partner, kind), traffic)| PartnerTraffic { partner, kind, traffic }).collect()
    }

    fn with(&mut self, partner: usize) -> &mut Traffic {
        self.counts.entry((partner, self.kind)).or_default()
    }

    fn sent(&mut self, to: usize, bytes: u64) {
        let traffic = self.with(to);
        traffic.sent_messages += 1;
        traffic.sent_bytes += bytes;
    }

    fn taken(&mut self, from: usize, bytes: u64) {
        let traffic = self.with(from);
        traffic.taken_messages += 1;
        traffic.taken_bytes += bytes;
    }
}

impl<C: Communicator> Communicator for Observed<'_, C> {
    fn rank(&self) -> usize {
        self.inner.rank()
    }

    fn size(&self) -> usize {
        self.inner.size()
    }

    fn outer_rank(&self, rank: usize) -> usize {
        self.inner.outer_rank(rank)
    }

    fn machine(&self) -> String {
        self.inner.machine()
    }

    fn send(&mut self, to: usize, message: Vec<u8>) -> Result<(), CommError> {
        let bytes = message.len() as u64;
        self.inner.send(to, message)?;
        self.sent(to, bytes);
        Ok(())
    }

    fn receive(&mut self, from: usize) -> Result<Vec<u8>, CommError> {
        let message = self.inner.receive(from)?;
        self.taken(from, message.len() as u64);
        Ok(message)
    }

    fn receive_within(&mut self, from: usize, time: Duration) -> Result<Option<Vec<u8>>, CommError> {
        let message = self.inner.receive_within(from, time)?;
        if let Some(message) = &message {
            self.taken(from, message.len() as u64);
        }
        Ok(message)
    }

    fn receive_any(&mut self, awaited: &mut Awaited) -> Result<(usize, Vec<u8>), CommError> {
        let (from, message) = self.inner.receive_any(awaited)?;
        self.taken(from, message.len() as u64);
        Ok((from, message))
    }

    fn flush(&mut self) -> Result<(), CommError> {
        self.inner.flush()
    }

    fn buffer(&mut self, to: usize) -> Vec<u8> {
        self.inner.buffer(to)
    }

    fn give_back(&mut self, from: usize, message: Vec<u8>) {
        self.inner.give_back(from, message);
    }

    fn traffic(&self) -> Traffic {
        self.inner.traffic()
    }

    fn signal(&mut self, to: usize) -> Result<(), CommError> {
        self.inner.signal(to)?;
        self.sent(to, 0);
        Ok(())
    }

    fn await_signal(&mut self, from: usize) -> Result<(), CommError> {
        self.inner.await_signal(from)?;
        self.taken(from, 0);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::comm::threads::run;

    #[test]
    fn messages_are_counted_by_partner_and_kind() {
        let counted = run(3, |comm| {
            let rank = comm.rank();
            let mut observed = Observed::new(comm, Kind::Barrier);
            observed.barrier()?;
            observed.begin(Kind::Bins);
            match rank {
                0 => {
                    let mut awaited = Awaited::new([1, 2]);
                    while !awaited.is_empty() {
                        observed.receive_any(&mut awaited)?;
                    }
                }
                _ => observed.send(0, vec![7; 10 * rank])?,
            }
            Ok(observed.finish())
        });
        let counted = counted.expect("no errors");
        let of = |partner, kind, sent: (u64, u64), taken: (u64, u64)| {
            let traffic = Traffic {
                sent_messages: sent.0,
                sent_bytes: sent.1,
                taken_messages: taken.0,
                taken_bytes: taken.1,
            };
            PartnerTraffic { partner, kind, traffic }
        };
        // A barrier of three: each signals both others, and gets their signals.
        let signals = |partner| of(partner, Kind::Barrier, (1, 0), (1, 0));
        let bins = |partner, bytes| of(partner, Kind::Bins, (0, 0), (1, bytes));
        assert_eq!(counted[0], [signals(1), bins(1, 10), signals(2), bins(2, 20)]);
        assert_eq!(counted[2], [signals(0), of(0, Kind::Bins, (1, 20), (0, 0)), signals(1)]);
    }
}
