//! What messages between ranks cost.

use std::time::{Duration, Instant};

use serde::Serialize;
use tercio_parallel::Communicator;
use tercio_parallel::comm::CommError;

use crate::machines::{Machine, MachineError};

/// Where the cost of messages is from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Source {
    /// Messages were sent there and back between rank 0 and so many others; the slowest counts.
    Measured {
        /// Ranks that answered.
        partners: usize,
    },
    /// Constants of the laboratory's machine.
    Constants,
}

/// Messages between ranks.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Network {
    /// Seconds of a small message.
    pub latency: f64,
    /// Bytes a second of large messages, through the port of one rank; infinite if memory is handed over (JSON: null).
    pub bandwidth: f64,
    /// Where they are from.
    pub source: Source,
}

impl Network {
    /// Between threads of one process: memory is handed over, the latency is that of the machine's description.
    ///
    /// # Errors
    /// [`MachineError::Missing`] without a network.
    pub fn in_process(machine: &Machine) -> Result<Self, MachineError> {
        let network = machine.need(machine.network.as_ref(), "network")?;
        let latency = network.message.value;
        Ok(Self { latency, bandwidth: f64::INFINITY, source: Source::Constants })
    }
}

/// Bytes of the large messages, and how many go there and back at most.
const LARGE: usize = 256 << 10;
const LARGE_TRIPS: usize = 3;
const SMALL: usize = 8;
const SMALL_TRIPS: usize = 12;
/// After this time with a partner no further message is sent to it.
const ENOUGH: Duration = Duration::from_micros(500);

/// Sends messages there and back between rank 0 and the next, the middle and the last rank, for about a millisecond each (where
/// messages take longer, until three small and three large ones have come back). All ranks have to call this; rank 0 gets the
/// cost, the others `None`, and so does rank 0 if it is alone.
///
/// # Errors
/// [`CommError`].
pub fn measure(comm: &mut impl Communicator) -> Result<Option<Network>, CommError> {
    let size = comm.size();
    let mut partners = vec![1, size / 2, size - 1];
    partners.retain(|&partner| partner > 0 && partner < size);
    partners.sort_unstable();
    partners.dedup();
    if comm.rank() > 0 {
        if partners.contains(&comm.rank()) {
            echo(comm)?;
        }
        return Ok(None);
    }
    let (mut latency, mut seconds_of_large) = (0.0f64, 0.0f64);
    for &partner in &partners {
        latency = latency.max(fastest(comm, partner, SMALL, SMALL_TRIPS)?);
        seconds_of_large = seconds_of_large.max(fastest(comm, partner, LARGE, LARGE_TRIPS)?);
        // An empty message ends it.
        comm.send(partner, Vec::new())?;
    }
    let source = Source::Measured { partners: partners.len() };
    // On a busy machine a small message may take as long as a large one; then at least half of the large one's time counts.
    let of_bytes = (seconds_of_large - latency).max(seconds_of_large / 2.0);
    Ok((!partners.is_empty()).then(|| Network {
        latency,
        bandwidth: LARGE as f64 / of_bytes.max(1e-9),
        source,
    }))
}

/// Returns the messages of rank 0 until an empty one comes.
fn echo(comm: &mut impl Communicator) -> Result<(), CommError> {
    loop {
        let message = comm.receive(0)?;
        if message.is_empty() {
            return Ok(());
        }
        comm.send(0, message)?;
    }
}

/// Half the fastest round trip in seconds: delays by other work on the machine are not the network's.
fn fastest(
    comm: &mut impl Communicator,
    partner: usize,
    bytes: usize,
    trips: usize,
) -> Result<f64, CommError> {
    let begin = Instant::now();
    let mut message = vec![1; bytes];
    let mut least = f64::INFINITY;
    // The first trip sets up connections, and finds the partner asleep.
    for trip in 0..=trips {
        let sent = Instant::now();
        comm.send(partner, message)?;
        message = comm.receive(partner)?;
        if message.len() != bytes {
            let reason = format!("{} bytes came back of a message of {bytes}", message.len());
            return Err(CommError::Transport { rank: partner, reason });
        }
        if trip > 0 {
            least = least.min(sent.elapsed().as_secs_f64() / 2.0);
        }
        if trip > 1 && begin.elapsed() > ENOUGH {
            break;
        }
    }
    Ok(least)
}

#[cfg(test)]
mod tests {
    use tercio_parallel::comm::threads;

    use super::*;

    #[test]
    fn rank_0_measures_and_nothing_is_left_on_the_way() {
        for ranks in [1, 2, 3, 7] {
            let all = threads::run(ranks, |comm| {
                let measured = measure(comm)?;
                // A message that was left over would come first.
                let said = comm.all_gather(vec![comm.rank() as u8])?;
                Ok((measured, said))
            });
            for (rank, (measured, said)) in all.expect("all ranks end").into_iter().enumerate() {
                assert_eq!(said, (0..ranks as u8).map(|rank| vec![rank]).collect::<Vec<_>>());
                assert_eq!(measured.is_some(), rank == 0 && ranks > 1);
                if let Some(Network { latency, bandwidth, source }) = measured {
                    assert!(latency > 0.0 && latency < 1.0 && bandwidth > 1e5, "{latency} {bandwidth}");
                    assert_eq!(source, Source::Measured { partners: (ranks - 1).min(3) });
                }
            }
        }
    }
}
