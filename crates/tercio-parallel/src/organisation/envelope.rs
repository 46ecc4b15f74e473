//! Messages of a frame say what they are.
//!
//! The last [`TRAILER`] bytes of each message are the [kind](Kind) of its content and the number of the frame (4 bytes
//! each), and a digest of the task (8 bytes); numbers are little-endian. They are at the end so that they are appended and
//! removed without moving the content. A message that is not the expected one is an error: it would be merged into a
//! wrong picture otherwise.

use std::fmt;
use std::time::Duration;

use crate::comm::{Awaited, CommError, Communicator, Kind, Observed, PartnerTraffic, Traffic};

/// Bytes behind the content of a message of a frame.
pub const TRAILER: usize = 16;

/// A rank's access to the other ranks for the messages of one frame. Collectives are messages, too; signals are not.
#[derive(Debug)]
pub struct FrameComm<'a, C> {
    inner: Observed<'a, C>,
    label: Label,
}

/// What a message is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Label {
    kind: Kind,
    /// The number of the frame, modulo 2^32.
    frame: u32,
    /// A digest of the task.
    task: u64,
}

impl Label {
    fn to_bytes(self) -> [u8; TRAILER] {
        let number = (u64::from(self.frame) << 32) | u64::from(self.kind.number());
        let mut bytes = [0; TRAILER];
        bytes[..8].copy_from_slice(&number.to_le_bytes());
        bytes[8..].copy_from_slice(&self.task.to_le_bytes());
        bytes
    }

    /// `None` if there is no such kind of message.
    fn from_bytes(bytes: [u8; TRAILER]) -> Option<Self> {
        let numbers = u128::from_le_bytes(bytes);
        let kind = Kind::from_number(numbers as u32)?;
        Some(Self { kind, frame: (numbers >> 32) as u32, task: (numbers >> 64) as u64 })
    }
}

impl fmt::Display for Label {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} of frame {}", self.kind, self.frame)
    }
}

impl<'a, C: Communicator> FrameComm<'a, C> {
    /// For the messages of a frame with this number, modulo 2^32, and a task with this digest: the same on all ranks.
    pub fn new(inner: &'a mut C, frame: u32, task: u64) -> Self {
        let kind = Kind::Touched;
        Self { inner: Observed::new(inner, kind), label: Label { kind, frame, task } }
    }

    /// From now on messages of this kind are sent, and expected.
    pub fn begin(&mut self, kind: Kind) {
        self.label.kind = kind;
        self.inner.begin(kind);
    }

    /// The counts of the messages, trailers included.
    pub fn finish(self) -> Vec<PartnerTraffic> {
        self.inner.finish()
    }

    /// The content of a message.
    fn open(&self, from: usize, mut message: Vec<u8>) -> Result<Vec<u8>, CommError> {
        let expected = self.label;
        let found = match message.split_last_chunk::<TRAILER>() {
            None => format!("{} bytes without a trailer", message.len()),
            Some((content, trailer)) => match Label::from_bytes(*trailer) {
                Some(label) if label == expected => {
                    let length = content.len();
                    message.truncate(length);
                    return Ok(message);
                }
                Some(Label { task, .. }) if task != expected.task => "a message of another task".into(),
                Some(label) => label.to_string(),
                None => format!("{} bytes of an unknown kind", message.len()),
            },
        };
        Err(CommError::Unexpected { rank: from, expected: expected.to_string(), found })
    }
}

impl<C: Communicator> Communicator for FrameComm<'_, C> {
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

    fn send(&mut self, to: usize, mut message: Vec<u8>) -> Result<(), CommError> {
        // Large messages fill their memory: its size is not to be doubled for the trailer.
        message.reserve_exact(TRAILER);
        message.extend_from_slice(&self.label.to_bytes());
        self.inner.send(to, message)
    }

    fn receive(&mut self, from: usize) -> Result<Vec<u8>, CommError> {
        let message = self.inner.receive(from)?;
        self.open(from, message)
    }

    fn receive_within(&mut self, from: usize, time: Duration) -> Result<Option<Vec<u8>>, CommError> {
        self.inner.receive_within(from, time)?.map(|message| self.open(from, message)).transpose()
    }

    fn receive_any(&mut self, awaited: &mut Awaited) -> Result<(usize, Vec<u8>), CommError> {
        let (from, message) = self.inner.receive_any(awaited)?;
        Ok((from, self.open(from, message)?))
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
        self.inner.signal(to)
    }

    fn await_signal(&mut self, from: usize) -> Result<(), CommError> {
        self.inner.await_signal(from)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::comm::threads::{ThreadComm, run};

    /// What rank 1 of a frame with number 7 and task 9 gets, if rank 0 sends by `send`.
    fn got(send: impl Fn(&mut ThreadComm) -> Result<(), CommError> + Sync) -> Result<Vec<u8>, CommError> {
        let results = run(2, |comm| {
            if comm.rank() == 0 {
                send(comm)?;
                return Ok(None);
            }
            let mut framed = FrameComm::new(comm, 7, 9);
            framed.begin(Kind::Bins);
            Ok(Some(framed.receive(0)))
        });
        results.expect("no rank fails").remove(1).expect("rank 1 receives")
    }

    fn sent(kind: Kind, frame: u32, task: u64) -> Result<Vec<u8>, CommError> {
        got(|comm| {
            let mut framed = FrameComm::new(comm, frame, task);
            framed.begin(kind);
            framed.send(1, vec![1, 2, 3])
        })
    }

    #[test]
    fn only_the_expected_message_is_received() {
        assert_eq!(sent(Kind::Bins, 7, 9), Ok(vec![1, 2, 3]));
        let unexpected = |result: Result<Vec<u8>, CommError>| match result {
            Err(CommError::Unexpected { rank: 0, expected, found }) => {
                assert_eq!(expected, "bins of frame 7");
                found
            }
            other => panic!("{other:?}"),
        };
        for kind in Kind::ALL.into_iter().filter(|&kind| kind != Kind::Bins) {
            assert_eq!(unexpected(sent(kind, 7, 9)), format!("{kind} of frame 7"));
        }
        assert_eq!(unexpected(sent(Kind::Bins, 8, 9)), "bins of frame 8");
        assert_eq!(unexpected(sent(Kind::Bins, 7, 1 << 63)), "a message of another task");
        assert_eq!(unexpected(got(|comm| comm.send(1, vec![0; 15]))), "15 bytes without a trailer");
        assert_eq!(unexpected(got(|comm| comm.send(1, vec![255; 20]))), "20 bytes of an unknown kind");
        let error = sent(Kind::Pixels, 7, 9).expect_err("another kind").to_string();
        assert!(error.contains("rank 0 sent pixels of frame 7, expected bins of frame 7"), "{error}");
    }

    #[test]
    fn labels_are_read_as_they_were_written() {
        for kind in Kind::ALL {
            let label = Label { kind, frame: 0x8123_4567, task: 0xfedc_ba98_7654_3210 };
            assert_eq!(Label::from_bytes(label.to_bytes()), Some(label));
        }
    }

    #[test]
    fn a_trailer_does_not_double_the_memory_of_a_message() {
        const BYTES: usize = 1 << 20;
        let capacity = run(2, |comm| {
            let mut framed = FrameComm::new(comm, 0, 0);
            if framed.rank() == 0 {
                framed.send(1, vec![7; BYTES])?;
                return Ok(0);
            }
            let message = framed.receive(0)?;
            assert_eq!(message, vec![7; BYTES]);
            Ok(message.capacity())
        });
        let capacity = capacity.expect("received")[1];
        assert!((BYTES..BYTES + BYTES / 8).contains(&capacity), "{capacity}");
    }

    #[test]
    fn collectives_have_trailers_which_are_counted() {
        let traffic = run(5, |comm| {
            let mut framed = FrameComm::new(comm, 3, 4);
            let all = framed.all_gather(vec![framed.rank() as u8])?;
            assert_eq!(all, (0..5).map(|rank| vec![rank]).collect::<Vec<_>>());
            Ok(framed.traffic())
        });
        for traffic in traffic.expect("gathered") {
            assert_eq!((traffic.sent_messages, traffic.sent_bytes), (3, 4 + 3 * TRAILER as u64));
        }
    }
}
