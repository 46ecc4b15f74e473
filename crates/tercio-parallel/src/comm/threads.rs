//! Ranks as threads of one process.

use std::any::Any;
use std::collections::{HashMap, VecDeque};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard};
use std::time::{Duration, Instant};

use super::{Awaited, CommError, Communicator, ReadySenders, Traffic};
use crate::{ParallelError, placement};

/// A rank's access to the mailboxes. When it is dropped, also by a panic, the others notice that the rank is gone.
#[derive(Debug)]
pub struct ThreadComm {
    rank: usize,
    /// One for each rank.
    mailboxes: Arc<[Mailbox]>,
    traffic: Traffic,
}

/// What a rank has received. Memory grows with the messages and those who sent them, not with the number of ranks.
#[derive(Debug, Default)]
struct Mailbox {
    content: Mutex<Content>,
    /// The rank waits for this.
    changed: Condvar,
    is_gone: AtomicBool,
}

#[derive(Debug, Default)]
struct Content {
    /// Messages by sender.
    messages: HashMap<usize, VecDeque<Vec<u8>>>,
    /// This rank's messages, by receiver, after they were read. No more than were ever in transit at once.
    spare: HashMap<usize, Vec<Vec<u8>>>,
    /// Who has sent messages.
    ready: ReadySenders,
    /// Ranks that ended.
    gone: Vec<usize>,
}

impl Mailbox {
    fn lock(&self) -> MutexGuard<'_, Content> {
        self.content.lock().unwrap_or_else(|e| e.into_inner())
    }

    fn is_gone(&self) -> bool {
        self.is_gone.load(Ordering::SeqCst)
    }
}

impl ThreadComm {
    /// The communicator of the only rank.
    pub fn alone() -> Self {
        Self { rank: 0, mailboxes: [Mailbox::default()].into(), traffic: Traffic::default() }
    }

    /// Communicators of some ranks, in their order.
    pub fn for_ranks(ranks: usize) -> Vec<Self> {
        let mailboxes: Arc<[Mailbox]> = (0..ranks).map(|_| Mailbox::default()).collect();
        let comm = |rank| Self { rank, mailboxes: mailboxes.clone(), traffic: Traffic::default() };
        (0..ranks).map(comm).collect()
    }

    fn check(&self, rank: usize) -> Result<(), CommError> {
        let size = self.mailboxes.len();
        if rank < size && rank != self.rank { Ok(()) } else { Err(CommError::NoPartner { rank, size }) }
    }

    fn put(&self, to: usize, message: Vec<u8>) -> Result<(), CommError> {
        self.check(to)?;
        let mailbox = &self.mailboxes[to];
        if mailbox.is_gone() {
            return Err(CommError::Gone { rank: to });
        }
        let mut content = mailbox.lock();
        content.messages.entry(self.rank).or_default().push_back(message);
        content.ready.arrived(self.rank);
        drop(content);
        mailbox.changed.notify_one();
        Ok(())
    }

    fn take(&self, from: usize) -> Result<Vec<u8>, CommError> {
        loop {
            if let Some(message) = self.take_until(from, None)? {
                return Ok(message);
            }
        }
    }

    /// The next message of a rank; `None` after a deadline, if there is one.
    fn take_until(&self, from: usize, deadline: Option<Instant>) -> Result<Option<Vec<u8>>, CommError> {
        self.check(from)?;
        let own = &self.mailboxes[self.rank];
        let mut content = own.lock();
        loop {
            if let Some(message) = content.messages.get_mut(&from).and_then(VecDeque::pop_front) {
                return Ok(Some(message));
            }
            // After the messages that it sent before it ended.
            if self.mailboxes[from].is_gone() {
                return Err(CommError::Gone { rank: from });
            }
            let Some(deadline) = deadline else {
                content = own.changed.wait(content).unwrap_or_else(|e| e.into_inner());
                continue;
            };
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Ok(None);
            }
            content = own.changed.wait_timeout(content, left).unwrap_or_else(|e| e.into_inner()).0;
        }
    }

    fn take_any(&self, awaited: &mut Awaited) -> Result<(usize, Vec<u8>), CommError> {
        assert!(!awaited.is_empty(), "no rank is awaited");
        let own = &self.mailboxes[self.rank];
        let mut content = own.lock();
        loop {
            if let Some(received) = content.take_any(awaited) {
                return Ok(received);
            }
            if let Some(&rank) = content.gone.iter().find(|rank| awaited.contains(**rank)) {
                return Err(CommError::Gone { rank });
            }
            content = own.changed.wait(content).unwrap_or_else(|e| e.into_inner());
        }
    }
}

impl Content {
    /// The next message of an awaited rank, if one has arrived.
    fn take_any(&mut self, awaited: &mut Awaited) -> Option<(usize, Vec<u8>)> {
        let Self { messages, ready, .. } = self;
        let has_message = |sender| messages.get(&sender).is_some_and(|queue| !queue.is_empty());
        let from = ready.next(awaited, has_message)?;
        Some((from, messages.get_mut(&from)?.pop_front()?))
    }
}

impl Drop for ThreadComm {
    fn drop(&mut self) {
        self.mailboxes[self.rank].is_gone.store(true, Ordering::SeqCst);
        for other in &self.mailboxes[..] {
            // Whoever looked before is waiting when the lock is free, and is woken.
            other.lock().gone.push(self.rank);
            other.changed.notify_one();
        }
    }
}

impl Communicator for ThreadComm {
    fn rank(&self) -> usize {
        self.rank
    }

    fn size(&self) -> usize {
        self.mailboxes.len()
    }

    fn send(&mut self, to: usize, message: Vec<u8>) -> Result<(), CommError> {
        let bytes = message.len() as u64;
        self.put(to, message)?;
        self.traffic.sent_messages += 1;
        self.traffic.sent_bytes += bytes;
        Ok(())
    }

    fn receive(&mut self, from: usize) -> Result<Vec<u8>, CommError> {
        let message = self.take(from)?;
        self.traffic.taken_messages += 1;
        self.traffic.taken_bytes += message.len() as u64;
        Ok(message)
    }

    fn receive_within(&mut self, from: usize, time: Duration) -> Result<Option<Vec<u8>>, CommError> {
        // A time beyond what clocks count has no end.
        let message = match Instant::now().checked_add(time) {
            Some(deadline) => self.take_until(from, Some(deadline))?,
            None => Some(self.take(from)?),
        };
        if let Some(message) = &message {
            self.traffic.taken_messages += 1;
            self.traffic.taken_bytes += message.len() as u64;
        }
        Ok(message)
    }

    fn receive_any(&mut self, awaited: &mut Awaited) -> Result<(usize, Vec<u8>), CommError> {
        awaited.check(self.rank, self.mailboxes.len())?;
        let (from, message) = self.take_any(awaited)?;
        self.traffic.taken_messages += 1;
        self.traffic.taken_bytes += message.len() as u64;
        Ok((from, message))
    }

    fn buffer(&mut self, to: usize) -> Vec<u8> {
        let spare = self.mailboxes[self.rank].lock().spare.get_mut(&to).and_then(Vec::pop);
        let mut buffer = spare.unwrap_or_default();
        buffer.clear();
        buffer
    }

    fn give_back(&mut self, from: usize, message: Vec<u8>) {
        // A rank that is gone needs no memory.
        if let Some(sender) = self.mailboxes.get(from).filter(|sender| !sender.is_gone()) {
            sender.lock().spare.entry(self.rank).or_default().push(message);
        }
    }

    fn traffic(&self) -> Traffic {
        self.traffic
    }

    fn signal(&mut self, to: usize) -> Result<(), CommError> {
        self.put(to, Vec::new())
    }

    fn await_signal(&mut self, from: usize) -> Result<(), CommError> {
        self.take(from).map(drop)
    }
}

/// Runs the same work on some ranks, each on a thread of its own that starts on a [processor](placement) of its own, and returns the results in the order of the ranks.
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
    let first = placement::current();
    let results: Vec<Result<T, ParallelError>> = std::thread::scope(|scope| {
        let start = |mut comm: ThreadComm| {
            let rank = comm.rank;
            let thread = std::thread::Builder::new().spawn_scoped(scope, move || {
                placement::move_to(first + rank);
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
