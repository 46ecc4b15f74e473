//! Ranks as threads of one process.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{Receiver, Sender, channel};

use super::{CommError, Communicator, Traffic};
use crate::ParallelError;

/// A rank's ends of the channels. When it is dropped, also by a panic, the others notice that the rank is gone.
#[derive(Debug)]
pub struct ThreadComm {
    rank: usize,
    /// To each rank; the entry of this rank is unused.
    to: Vec<Sender<Vec<u8>>>,
    /// From each rank.
    from: Vec<Receiver<Vec<u8>>>,
    /// To each rank: its messages after they were read, for reuse.
    read: Vec<Sender<Vec<u8>>>,
    /// From each rank: this rank's messages to it after they were read. No more than were ever in transit at once.
    spare: Vec<Receiver<Vec<u8>>>,
    traffic: Traffic,
}

impl ThreadComm {
    /// Communicators of some ranks, in their order.
    pub fn for_ranks(ranks: usize) -> Vec<Self> {
        let mut comms: Vec<Self> = (0..ranks)
            .map(|rank| Self {
                rank,
                to: Vec::new(),
                from: Vec::new(),
                read: Vec::new(),
                spare: Vec::new(),
                traffic: Traffic::default(),
            })
            .collect();
        for from in 0..ranks {
            for to in 0..ranks {
                let (sender, receiver) = channel();
                comms[from].to.push(sender);
                comms[to].from.push(receiver);
                let (sender, receiver) = channel();
                comms[from].read.push(sender);
                comms[to].spare.push(receiver);
            }
        }
        comms
    }

    fn check(&self, rank: usize) -> Result<(), CommError> {
        let size = self.to.len();
        if rank < size && rank != self.rank { Ok(()) } else { Err(CommError::NoPartner { rank, size }) }
    }
}

impl Communicator for ThreadComm {
    fn rank(&self) -> usize {
        self.rank
    }

    fn size(&self) -> usize {
        self.to.len()
    }

    fn send(&mut self, to: usize, message: Vec<u8>) -> Result<(), CommError> {
        self.check(to)?;
        let bytes = message.len() as u64;
        self.to[to].send(message).map_err(|_| CommError::Gone { rank: to })?;
        self.traffic.sent_messages += 1;
        self.traffic.sent_bytes += bytes;
        Ok(())
    }

    fn receive(&mut self, from: usize) -> Result<Vec<u8>, CommError> {
        self.check(from)?;
        let message = self.from[from].recv().map_err(|_| CommError::Gone { rank: from })?;
        self.traffic.taken_messages += 1;
        self.traffic.taken_bytes += message.len() as u64;
        Ok(message)
    }

    fn buffer(&mut self, to: usize) -> Vec<u8> {
        let mut buffer = self.spare.get(to).and_then(|spare| spare.try_recv().ok()).unwrap_or_default();
        buffer.clear();
        buffer
    }

    fn give_back(&mut self, from: usize, message: Vec<u8>) {
        // A rank that is gone needs no memory.
        if let Some(read) = self.read.get(from) {
            read.send(message).ok();
        }
    }

    fn traffic(&self) -> Traffic {
        self.traffic
    }

    fn signal(&mut self, to: usize) -> Result<(), CommError> {
        self.check(to)?;
        self.to[to].send(Vec::new()).map_err(|_| CommError::Gone { rank: to })
    }

    fn await_signal(&mut self, from: usize) -> Result<(), CommError> {
        self.check(from)?;
        self.from[from].recv().map(drop).map_err(|_| CommError::Gone { rank: from })
    }
}

/// Runs the same work on some ranks, each on a thread of its own, and returns the results in the order of the ranks.
///
/// # Errors
/// The error of the first rank that failed by itself. A rank that panics affects only those that wait for its
/// messages; they get [`CommError::Gone`].
///
/// # Panics
/// If there are no ranks.
pub fn run<T: Send>(
    ranks: usize,
    work: impl Fn(&mut ThreadComm) -> Result<T, ParallelError> + Sync,
) -> Result<Vec<T>, ParallelError> {
    assert!(ranks > 0, "there must be at least one rank");
    let work = &work;
    let results: Vec<Result<T, ParallelError>> = std::thread::scope(|scope| {
        let start = |mut comm: ThreadComm| {
            let rank = comm.rank;
            let thread = std::thread::Builder::new().spawn_scoped(scope, move || {
                // The communicator is dropped in here, before the thread ends.
                catch_unwind(AssertUnwindSafe(move || work(&mut comm)))
                    .unwrap_or_else(|panic| Err(panicked(rank, &*panic)))
            });
            thread.map_err(|source| ParallelError::Thread { rank, source })
        };
        let threads: Vec<_> = ThreadComm::for_ranks(ranks).into_iter().map(start).collect();
        let join = |(rank, thread): (usize, Result<std::thread::ScopedJoinHandle<_>, _>)| {
            thread?.join().unwrap_or_else(|panic| Err(panicked(rank, &*panic)))
        };
        threads.into_iter().enumerate().map(join).collect()
    });
    let mut done = Vec::new();
    let mut failed: Option<ParallelError> = None;
    for result in results {
        match result {
            Ok(value) => done.push(value),
            Err(error) if failed.as_ref().is_none_or(|f| f.is_consequence() && !error.is_consequence()) => {
                failed = Some(error);
            }
            Err(_) => {}
        }
    }
    failed.map_or(Ok(done), Err)
}

fn panicked(rank: usize, panic: &(dyn Any + Send)) -> ParallelError {
    let text = panic.downcast_ref::<&str>().map(ToString::to_string);
    let message = text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_default();
    ParallelError::Panicked { rank, message }
}

#[cfg(test)]
mod tests;
