//! Communication between ranks: messages of bytes from one to another.
//!
//! Messages between two ranks arrive in the order in which they were sent; sending does not wait for the receiver.
//! Everything else, including the collectives, is built on that, so that a backend is small and all traffic is
//! counted in one place.

mod awaited;
pub mod collective;
mod group;
mod kind;
mod observed;
pub mod threads;

pub use awaited::{Awaited, RankNames, ReadySenders};
pub use group::Group;
pub use kind::Kind;
pub use observed::{Observed, PartnerTraffic};
use std::time::Duration;

use serde::{Deserialize, Serialize};

/// Messages that a rank sent and received, not counting those of [`Communicator::barrier`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Traffic {
    /// Messages sent to other ranks.
    pub sent_messages: u64,
    /// Their bytes.
    pub sent_bytes: u64,
    /// Messages received from other ranks.
    pub taken_messages: u64,
    /// Their bytes.
    pub taken_bytes: u64,
}

impl Traffic {
    /// The same messages as their other ends count them.
    pub fn reversed(self) -> Self {
        Self {
            sent_messages: self.taken_messages,
            sent_bytes: self.taken_bytes,
            taken_messages: self.sent_messages,
            taken_bytes: self.sent_bytes,
        }
    }

    /// The sum of two counts.
    pub fn plus(self, o: Self) -> Self {
        Self {
            sent_messages: self.sent_messages + o.sent_messages,
            sent_bytes: self.sent_bytes + o.sent_bytes,
            taken_messages: self.taken_messages + o.taken_messages,
            taken_bytes: self.taken_bytes + o.taken_bytes,
        }
    }

    /// The difference to an earlier count.
    pub fn since(self, earlier: Self) -> Self {
        Self {
            sent_messages: self.sent_messages - earlier.sent_messages,
            sent_bytes: self.sent_bytes - earlier.sent_bytes,
            taken_messages: self.taken_messages - earlier.taken_messages,
            taken_bytes: self.taken_bytes - earlier.taken_bytes,
        }
    }
}

/// Why a message could not be sent or received.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CommError {
    /// The other rank ended, by itself or by a panic.
    #[error("rank {rank} is gone")]
    Gone {
        /// The rank.
        rank: usize,
    },
    /// Other ranks sent nothing for longer than a rank was to wait.
    #[error(
        "{ranks} {} been silent for {seconds} s: {} may be stopped, or still read {} model",
        if ranks.count() == 1 { "has" } else { "have" },
        if ranks.count() == 1 { "it" } else { "they" },
        if ranks.count() == 1 { "its" } else { "their" },
    )]
    Silent {
        /// The ranks.
        ranks: RankNames,
        /// The seconds.
        seconds: u64,
    },
    /// There is no such rank, or it is this one.
    #[error(
        "rank {rank} is not a valid peer: there are {size} ranks, and a rank cannot exchange messages with itself"
    )]
    NoPartner {
        /// The rank.
        rank: usize,
        /// The number of ranks.
        size: usize,
    },
    /// The other rank sent something else than what is its turn: it draws another frame, or is of another version.
    #[error("rank {rank} sent {found}, expected {expected}: do all ranks draw the same frames?")]
    Unexpected {
        /// The sender.
        rank: usize,
        /// What was expected.
        expected: String,
        /// What it sent.
        found: String,
    },
    /// The transport of messages failed.
    #[error("a message to or from rank {rank}: {reason}")]
    Transport {
        /// The other rank.
        rank: usize,
        /// The reason given by the backend.
        reason: String,
    },
}

/// The children of a rank in the binomial tree of `size` ranks: those with one more bit, below its own lowest one.
pub(crate) fn children(rank: usize, size: usize) -> impl Iterator<Item = usize> {
    let bits = (0..usize::BITS).map(|bit| 1 << bit).take_while(move |bit| rank & bit == 0);
    bits.map(move |bit| rank + bit).take_while(move |&child| child < size)
}

/// The parent of a rank above 0 in the binomial tree.
pub(crate) fn parent(rank: usize) -> usize {
    rank & (rank - 1)
}

/// A rank's access to the other ranks.
pub trait Communicator {
    /// This rank's number, below [`Communicator::size`].
    fn rank(&self) -> usize;

    /// Number of ranks, at least 1.
    fn size(&self) -> usize;

    /// What errors call a rank: its number among all ranks, if this is a [`Group`] of them.
    fn outer_rank(&self, rank: usize) -> usize {
        rank
    }

    /// Name of the machine that this rank runs on, the same for all its ranks; empty if all ranks are on one.
    fn machine(&self) -> String {
        String::new()
    }

    /// Sends a message, which may be empty. Does not wait until it is received.
    ///
    /// # Errors
    /// [`CommError`].
    fn send(&mut self, to: usize, message: Vec<u8>) -> Result<(), CommError>;

    /// Waits for the next message of a rank.
    ///
    /// # Errors
    /// [`CommError`]; never waits for a rank that is gone.
    fn receive(&mut self, from: usize) -> Result<Vec<u8>, CommError>;

    /// Waits at most so long for the next message of a rank, or, for no time at all, returns one that has arrived; `None` if there is none.
    ///
    /// # Errors
    /// [`CommError`]; never waits for a rank that is gone.
    fn receive_within(&mut self, from: usize, time: Duration) -> Result<Option<Vec<u8>>, CommError>;

    /// Waits for a message of any awaited rank, which is not awaited any longer then; returns the rank, too. The ones that
    /// arrived first are received first, if the backend knows.
    ///
    /// # Errors
    /// [`CommError`], also if an awaited rank is gone; never waits for that.
    ///
    /// # Panics
    /// If no rank is awaited.
    fn receive_any(&mut self, awaited: &mut Awaited) -> Result<(usize, Vec<u8>), CommError> {
        let Some(first) = awaited.first() else { panic!("no rank is awaited") };
        let message = self.receive(first)?;
        awaited.remove(first);
        Ok((first, message))
    }

    /// Waits until the messages that this rank has sent need nothing more from it: before it does other work for long, while which
    /// no message moves. Others are received from meanwhile.
    ///
    /// # Errors
    /// [`CommError`].
    fn flush(&mut self) -> Result<(), CommError> {
        Ok(())
    }

    /// An empty buffer for a message to a rank: memory of an earlier message to it, if it was returned.
    fn buffer(&mut self, to: usize) -> Vec<u8> {
        let _ = to;
        Vec::new()
    }

    /// Returns the memory of a message that was read for reuse by [`Communicator::buffer`]. A frame like the one
    /// before then allocates no memory for messages, whose pages the system would have to provide and clear every
    /// time.
    fn give_back(&mut self, from: usize, message: Vec<u8>) {
        let _ = from;
        drop(message);
    }

    /// Messages sent and received so far.
    fn traffic(&self) -> Traffic;

    /// Sends a message that is not counted; used by the communicator itself.
    ///
    /// # Errors
    /// [`CommError`].
    fn signal(&mut self, to: usize) -> Result<(), CommError>;

    /// Waits for a message that is not counted.
    ///
    /// # Errors
    /// [`CommError`].
    fn await_signal(&mut self, from: usize) -> Result<(), CommError>;

    /// Waits until all ranks have called this. In round k every rank signals the one 2^k further, so that after log2
    /// of the ranks all know of all (dissemination barrier, Hensgen, Finkel and Manber 1988).
    ///
    /// # Errors
    /// [`CommError`].
    fn barrier(&mut self) -> Result<(), CommError> {
        let (rank, size) = (self.rank(), self.size());
        let mut step = 1;
        while step < size {
            self.signal((rank + step) % size)?;
            self.await_signal((rank + size - step) % size)?;
            step *= 2;
        }
        Ok(())
    }

    /// Sends a message of each of the ranks below `senders` to rank 0, which gets them in the order of the ranks,
    /// without its own; the others get nothing. A rank that is not below `senders` need not call it.
    ///
    /// # Errors
    /// [`CommError`].
    fn gather(&mut self, senders: usize, message: Vec<u8>) -> Result<Vec<Vec<u8>>, CommError> {
        if self.rank() == 0 {
            return (1..senders).map(|from| self.receive(from)).collect();
        }
        if self.rank() < senders {
            self.send(0, message)?;
        }
        Ok(Vec::new())
    }

    /// Sends a block of bytes of each rank to all others: returns those of all ranks, in their order. All blocks have the same
    /// length. In round k every rank sends what it has, at most 2^k blocks, to the one 2^k before it (Bruck et al. 1997): so each
    /// sends log2 of the ranks messages, rounded up, with all blocks but one.
    ///
    /// # Errors
    /// [`CommError`], also if the blocks of other ranks have another length.
    fn all_gather(&mut self, block: Vec<u8>) -> Result<Vec<Vec<u8>>, CommError> {
        let (rank, size, length) = (self.rank(), self.size(), block.len());
        // The blocks of this rank and those behind it.
        let mut have = block;
        let mut step = 1;
        while step < size {
            let blocks = step.min(size - step);
            // Not from a buffer: those are for large messages.
            self.send((rank + size - step) % size, have[..blocks * length].to_vec())?;
            let from = (rank + step) % size;
            let message = self.receive(from)?;
            if message.len() != blocks * length {
                let reason = format!("{} bytes, expected {blocks} blocks of {length}", message.len());
                return Err(CommError::Transport { rank: self.outer_rank(from), reason });
            }
            have.extend_from_slice(&message);
            step *= 2;
        }
        let block_of = |of: usize| {
            let first = (of + size - rank) % size * length;
            have[first..first + length].to_vec()
        };
        Ok((0..size).map(block_of).collect())
    }
}

/// So that what takes a communicator can be lent one.
impl<C: Communicator + ?Sized> Communicator for &mut C {
    fn rank(&self) -> usize {
        (**self).rank()
    }

    fn size(&self) -> usize {
        (**self).size()
    }

    fn outer_rank(&self, rank: usize) -> usize {
        (**self).outer_rank(rank)
    }

    fn machine(&self) -> String {
        (**self).machine()
    }

    fn send(&mut self, to: usize, message: Vec<u8>) -> Result<(), CommError> {
        (**self).send(to, message)
    }

    fn receive(&mut self, from: usize) -> Result<Vec<u8>, CommError> {
        (**self).receive(from)
    }

    fn receive_within(&mut self, from: usize, time: Duration) -> Result<Option<Vec<u8>>, CommError> {
        (**self).receive_within(from, time)
    }

    fn receive_any(&mut self, awaited: &mut Awaited) -> Result<(usize, Vec<u8>), CommError> {
        (**self).receive_any(awaited)
    }

    fn flush(&mut self) -> Result<(), CommError> {
        (**self).flush()
    }

    fn buffer(&mut self, to: usize) -> Vec<u8> {
        (**self).buffer(to)
    }

    fn give_back(&mut self, from: usize, message: Vec<u8>) {
        (**self).give_back(from, message);
    }

    fn traffic(&self) -> Traffic {
        (**self).traffic()
    }

    fn signal(&mut self, to: usize) -> Result<(), CommError> {
        (**self).signal(to)
    }

    fn await_signal(&mut self, from: usize) -> Result<(), CommError> {
        (**self).await_signal(from)
    }

    fn barrier(&mut self) -> Result<(), CommError> {
        (**self).barrier()
    }

    fn gather(&mut self, senders: usize, message: Vec<u8>) -> Result<Vec<Vec<u8>>, CommError> {
        (**self).gather(senders, message)
    }

    fn all_gather(&mut self, block: Vec<u8>) -> Result<Vec<Vec<u8>>, CommError> {
        (**self).all_gather(block)
    }
}
