//! Messages between the processes of an MPI job.

use std::collections::VecDeque;
use std::fmt;
use std::time::{Duration, Instant};

use mpi::ffi::MPI_Comm;
use tercio_parallel::comm::{Awaited, CommError, Communicator, RankNames, ReadySenders, Traffic};

use crate::StartError;
use crate::raw::{Envelope, Failed, Link, Outgoing};
use crate::spare::Spare;
use crate::waiting::until;

/// Tag of a message, or of its last part.
const MESSAGE: i32 = 1;
/// Tag of a part of a message that is followed by another part.
const PART: i32 = 2;
/// Tag of a message that is not counted.
const SIGNAL: i32 = 3;
/// Tag of the last message of a rank.
const FAREWELL: i32 = 4;

/// So few outgoing messages are not looked through: their memory is reused from frame to frame anyway.
const FEW_OUTGOING: usize = 4;

/// Most bytes that are sent in one piece. MPI counts in C ints, below 2^31; larger messages are sent in parts.
const PART_BYTES: usize = 1 << 30;

/// A process's access to the others of its job; made by [`run`](crate::run).
///
/// Messages of all kinds are received in the order in which they were sent, and queued until their kind is requested;
/// so signals and messages never wait for each other. The memory of a sent message is kept until MPI has transferred
/// it; MPI does so while this rank sends or waits, and at the end.
pub struct MpiComm {
    link: Link,
    outgoing: Vec<Outgoing>,
    /// So many outgoing messages are looked through when another one is sent: twice as many as were left the last time, so that no
    /// message is looked at more than a few times however many there are.
    look_at: usize,
    /// Received from each rank.
    arrived: Vec<Arrived>,
    /// Who has sent messages.
    ready: ReadySenders,
    /// Ranks whose last message has arrived.
    left: Vec<usize>,
    /// Memory of messages that were sent or read, for reuse.
    spare: Spare,
    traffic: Traffic,
    part_bytes: usize,
    patience: Patience,
}

/// What happens if a rank waits for long: the other one may be stopped, or its memory swapped out.
pub struct Patience {
    /// After this time of one wait `notice` is called, once.
    pub silence: Duration,
    /// Gets the rank, or the ranks of any of which a message is waited for.
    pub notice: Box<dyn FnMut(&RankNames)>,
    /// After this time the wait ends with [`CommError::Silent`], if it is given.
    pub timeout: Option<Duration>,
}

impl Patience {
    /// After waiting for so long for these ranks: the notice, unless there was one, and the end.
    fn check(
        &mut self,
        waited: Duration,
        noticed: &mut bool,
        names: impl Fn() -> RankNames,
    ) -> Result<(), CommError> {
        if waited >= self.silence && !*noticed {
            *noticed = true;
            (self.notice)(&names());
        }
        match self.timeout {
            Some(timeout) if waited >= timeout => {
                Err(CommError::Silent { ranks: names(), seconds: waited.as_secs() })
            }
            _ => Ok(()),
        }
    }
}

impl Default for Patience {
    /// Waits for ever, without notice.
    fn default() -> Self {
        Self { silence: Duration::MAX, notice: Box::new(|_| ()), timeout: None }
    }
}

/// Messages from a rank that were not requested yet.
#[derive(Debug, Default)]
struct Arrived {
    messages: VecDeque<Vec<u8>>,
    /// The parts received so far of an incomplete message.
    unfinished: Vec<u8>,
    signals: u64,
    has_left: bool,
}

impl MpiComm {
    pub(crate) fn new(link: Link) -> Self {
        let arrived = (0..link.size()).map(|_| Arrived::default()).collect();
        // A frame sends and receives one or two messages per rank.
        let spare = Spare::new(4 * link.size());
        let traffic = Traffic::default();
        Self {
            link,
            outgoing: Vec::new(),
            look_at: FEW_OUTGOING,
            arrived,
            ready: ReadySenders::default(),
            left: Vec::new(),
            spare,
            traffic,
            part_bytes: PART_BYTES,
            patience: Patience::default(),
        }
    }

    /// Access to the other processes of a communicator that belongs to the program, which has initialized MPI; all of them have to
    /// call this. Messages are sent over a duplicate, so that they never meet those of the program.
    ///
    /// # Errors
    /// [`StartError`].
    ///
    /// # Safety
    /// It is [closed](Self::close), or dropped, before MPI is finalized. The handle is that of a live communicator of processes (not between groups), of the MPI library that this one was built with;
    /// and this thread is the one that may call MPI, unless all may ([`mpi::Threading::Multiple`]).
    pub unsafe fn duplicate(of: MPI_Comm) -> Result<Self, StartError> {
        if !mpi::environment::is_initialized() || mpi::environment::is_finalized() {
            return Err(StartError::Missing);
        }
        if mpi::environment::threading_support() < mpi::Threading::Funneled {
            return Err(StartError::Threads);
        }
        // SAFETY: as required from the caller.
        let link = unsafe { Link::of_handle(of) };
        link.map(Self::new).map_err(|Failed(reason)| StartError::Failed(reason))
    }

    /// Waits until all processes of the communicator have called this, or dropped it.
    ///
    /// # Errors
    /// [`CommError`] if MPI fails.
    pub fn close(mut self) -> Result<(), CommError> {
        self.leave(None)
    }

    /// Sends messages in parts of at most this many bytes, 1 to 2^31 - 1, instead of 2^30. Ranks need not agree.
    pub fn set_part_bytes(&mut self, bytes: usize) {
        self.part_bytes = bytes;
    }

    /// What happens if this rank waits for long. At the end of a job of [`run`](crate::run), where ranks wait until all are done, it
    /// counts from when rank 0 is done, which may write for long what was drawn.
    pub fn set_patience(&mut self, patience: Patience) {
        self.patience = patience;
    }

    /// Name and version of the MPI library.
    pub fn library(&self) -> String {
        let text = mpi::environment::library_version().unwrap_or_else(|_| "unknown".into());
        // The text after the first comma, or line, describes how it was built.
        text.split([',', '\n']).next().unwrap_or_default().trim().to_owned()
    }

    /// Ends all processes of the job with an exit code.
    pub(crate) fn abort(&self, code: i32) -> ! {
        self.link.abort(code)
    }

    fn check(&self, rank: usize) -> Result<(), CommError> {
        let size = self.size();
        if rank < size && rank != self.rank() { Ok(()) } else { Err(CommError::NoPartner { rank, size }) }
    }

    fn begin(&mut self, to: usize, tag: i32, bytes: Vec<u8>) -> Result<(), CommError> {
        self.check(to)?;
        if self.arrived[to].has_left {
            return Err(CommError::Gone { rank: to });
        }
        if self.outgoing.len() >= self.look_at {
            self.forget_sent()?;
        }
        let outgoing = self.link.send(to, (PART, tag), bytes, self.part_bytes);
        self.outgoing.push(outgoing.map_err(transport(to))?);
        Ok(())
    }

    /// Puts the memory of messages that MPI has transferred aside for reuse.
    fn forget_sent(&mut self) -> Result<(), CommError> {
        let mut at = 0;
        while at < self.outgoing.len() {
            let to = self.outgoing[at].to;
            if self.outgoing[at].is_done().map_err(transport(to))? {
                self.spare.put(self.outgoing.swap_remove(at).into_bytes());
            } else {
                at += 1;
            }
        }
        self.look_at = (2 * self.outgoing.len()).max(FEW_OUTGOING);
        Ok(())
    }

    /// Receives one message from a rank, or from any, if one has arrived, and queues it.
    fn take(&mut self, from: Option<usize>) -> Result<Option<Envelope>, CommError> {
        // An error with a message of any rank is reported as one of this rank.
        let rank = from.unwrap_or(self.rank());
        let (arrived, spare) = (&mut self.arrived, &mut self.spare);
        let taken = self.link.take(from, |e: Envelope, bytes| {
            let place = &mut arrived[e.from].unfinished;
            if bytes > 0 && place.capacity() == 0 {
                *place = spare.take(bytes);
            }
            place
        });
        let taken = taken.map_err(transport(rank))?;
        if let Some(Envelope { from, tag }) = taken {
            let arrived = &mut self.arrived[from];
            match tag {
                MESSAGE => {
                    arrived.messages.push_back(std::mem::take(&mut arrived.unfinished));
                    self.ready.arrived(from);
                }
                SIGNAL => arrived.signals += 1,
                FAREWELL => {
                    arrived.has_left = true;
                    self.left.push(from);
                }
                _ => {}
            }
        }
        Ok(taken)
    }

    /// Waits until `is_it` returns something from the messages of a rank.
    fn wait<T>(
        &mut self,
        from: usize,
        mut is_it: impl FnMut(&mut Arrived) -> Option<T>,
    ) -> Result<T, CommError> {
        self.check(from)?;
        self.wait_until(|| from.into(), |comm| comm.poll(from, &mut is_it))
    }

    /// What `is_it` returns from the messages of a rank, if it returns something from those that have arrived.
    fn poll<T>(
        &mut self,
        from: usize,
        mut is_it: impl FnMut(&mut Arrived) -> Option<T>,
    ) -> Result<Option<T>, CommError> {
        loop {
            if let Some(it) = is_it(&mut self.arrived[from]) {
                return Ok(Some(it));
            }
            if self.arrived[from].has_left {
                return Err(CommError::Gone { rank: from });
            }
            if self.take(Some(from))?.is_none() {
                return Ok(None);
            }
        }
    }

    /// Polls until there is an answer, with a notice and an end if it takes too long; `names` are the ranks that are waited
    /// for.
    fn wait_until<T>(
        &mut self,
        names: impl Fn() -> RankNames,
        mut poll: impl FnMut(&mut Self) -> Result<Option<T>, CommError>,
    ) -> Result<T, CommError> {
        let mut noticed = false;
        until(|waited| {
            self.patience.check(waited, &mut noticed, &names)?;
            poll(self)
        })
    }

    /// The next message of an awaited rank, if one has arrived.
    fn poll_any(&mut self, awaited: &mut Awaited) -> Result<Option<(usize, Vec<u8>)>, CommError> {
        loop {
            let Self { arrived, ready, .. } = self;
            let has_message = |sender: usize| !arrived[sender].messages.is_empty();
            if let Some(from) = ready.next(awaited, has_message) {
                return Ok(arrived[from].messages.pop_front().map(|message| (from, message)));
            }
            if let Some(&rank) = self.left.iter().find(|rank| awaited.contains(**rank)) {
                return Err(CommError::Gone { rank });
            }
            // Messages of others are queued.
            if self.take(None)?.is_none() {
                return Ok(None);
            }
        }
    }

    /// Tells the others that no more messages follow, and waits until all others have done the same and all messages
    /// are transferred; messages that were not requested are dropped. So no rank waits for one that has ended.
    ///
    /// With an `end_with`, patience counts when that rank has left, the last one to have work of its own, and begins again with each
    /// message.
    pub(crate) fn leave(&mut self, end_with: Option<usize>) -> Result<(), CommError> {
        let (rank, size) = (self.rank(), self.size());
        if self.arrived[rank].has_left {
            return Ok(());
        }
        // First, so that nothing is sent twice if this fails and the communicator is dropped then.
        self.arrived[rank].has_left = true;
        for step in 1..size {
            let to = (rank + step) % size;
            let outgoing = self.link.send(to, (PART, FAREWELL), Vec::new(), PART_BYTES);
            self.outgoing.push(outgoing.map_err(transport(to))?);
        }
        let (mut noticed, mut since) = (false, None);
        until(|_| {
            while let Some(Envelope { from, .. }) = self.take(None)? {
                self.arrived[from].messages.clear();
                since = None;
            }
            self.forget_sent()?;
            let Self { arrived, outgoing, patience, .. } = self;
            if outgoing.is_empty() && arrived.iter().all(|a| a.has_left) {
                return Ok(Some(()));
            }
            if end_with.is_some_and(|last| arrived[last].has_left) {
                let waited = since.get_or_insert_with(Instant::now).elapsed();
                let stay = || (0..size).filter(|&rank| !arrived[rank].has_left);
                let unsent = || outgoing.iter().map(|outgoing| outgoing.to);
                patience.check(waited, &mut noticed, || Awaited::new(stay().chain(unsent())).names())?;
            }
            Ok(None)
        })
    }
}

fn transport(rank: usize) -> impl Fn(Failed) -> CommError {
    move |Failed(reason)| CommError::Transport { rank, reason }
}

impl Communicator for MpiComm {
    fn rank(&self) -> usize {
        self.link.rank()
    }

    fn size(&self) -> usize {
        self.arrived.len()
    }

    /// As reported by MPI.
    fn machine(&self) -> String {
        mpi::environment::processor_name().unwrap_or_else(|_| "unknown".into())
    }

    fn send(&mut self, to: usize, message: Vec<u8>) -> Result<(), CommError> {
        let bytes = message.len() as u64;
        self.begin(to, MESSAGE, message)?;
        self.traffic.sent_messages += 1;
        self.traffic.sent_bytes += bytes;
        Ok(())
    }

    fn receive(&mut self, from: usize) -> Result<Vec<u8>, CommError> {
        let message = self.wait(from, |arrived| arrived.messages.pop_front())?;
        self.traffic.taken_messages += 1;
        self.traffic.taken_bytes += message.len() as u64;
        Ok(message)
    }

    fn receive_within(&mut self, from: usize, time: Duration) -> Result<Option<Vec<u8>>, CommError> {
        self.check(from)?;
        let message = until(|waited| {
            let message = self.poll(from, |arrived| arrived.messages.pop_front())?;
            Ok((message.is_some() || waited >= time).then_some(message))
        })?;
        if let Some(message) = &message {
            self.traffic.taken_messages += 1;
            self.traffic.taken_bytes += message.len() as u64;
        }
        Ok(message)
    }

    fn receive_any(&mut self, awaited: &mut Awaited) -> Result<(usize, Vec<u8>), CommError> {
        assert!(!awaited.is_empty(), "no rank is awaited");
        awaited.check(self.rank(), self.size())?;
        let names = awaited.names();
        let (from, message) = self.wait_until(|| names.clone(), |comm| comm.poll_any(awaited))?;
        self.traffic.taken_messages += 1;
        self.traffic.taken_bytes += message.len() as u64;
        Ok((from, message))
    }

    fn buffer(&mut self, _: usize) -> Vec<u8> {
        // Messages of the previous frame have arrived by now.
        if self.spare.is_empty() && self.outgoing.len() >= self.look_at {
            // An error is reported again when messages are looked through the next time.
            self.forget_sent().ok();
        }
        self.spare.take(0)
    }

    fn give_back(&mut self, _: usize, message: Vec<u8>) {
        self.spare.put(message);
    }

    fn traffic(&self) -> Traffic {
        self.traffic
    }

    fn flush(&mut self) -> Result<(), CommError> {
        self.forget_sent()?;
        let Some(first) = self.outgoing.first().map(|outgoing| outgoing.to) else { return Ok(()) };
        self.wait_until(
            || first.into(),
            |comm| {
                while comm.take(None)?.is_some() {}
                comm.forget_sent()?;
                Ok(comm.outgoing.is_empty().then_some(()))
            },
        )
    }

    fn signal(&mut self, to: usize) -> Result<(), CommError> {
        self.begin(to, SIGNAL, Vec::new())
    }

    fn await_signal(&mut self, from: usize) -> Result<(), CommError> {
        self.wait(from, |arrived| {
            arrived.signals = arrived.signals.checked_sub(1)?;
            Some(())
        })
    }
}

impl Drop for MpiComm {
    /// So that the others get an error if they wait for this rank.
    fn drop(&mut self) {
        // An error is one of the end only: there is nobody to tell it.
        self.leave(None).ok();
    }
}

impl fmt::Debug for MpiComm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (rank, size, outgoing) = (self.rank(), self.size(), self.outgoing.len());
        f.debug_struct("MpiComm")
            .field("rank", &rank)
            .field("size", &size)
            .field("outgoing", &outgoing)
            .finish_non_exhaustive()
    }
}
