//! Measures latency and bandwidth of messages by sending them back and forth, between threads or processes.

use std::time::Instant;

use tercio_parallel::ParallelError;
use tercio_parallel::comm::{CommError, Communicator, threads};

use crate::machines::{Delivery, Network, Packing, Sourced, Topology};

/// Bytes of a small message, whose time is the latency.
pub const SMALL: usize = 8;
/// Bytes of a large message.
pub const LARGE: usize = 16 << 20;
/// Round trips of small messages.
const SMALL_TRIPS: usize = 2000;
/// Round trips of large messages.
const LARGE_TRIPS: usize = 15;
/// The first round trips are not counted: they set up connections and allocate memory.
const FIRST: usize = 3;

/// What happens to the bytes of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// The communicator copies them into memory of the receiving rank.
    Copied,
    /// The memory is handed over, as between threads; the receiver then copies it, so that the bytes are moved.
    HandedOver,
}

/// The cost of messages.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// Seconds of a message of [`SMALL`] bytes: half the median round trip.
    pub latency: f64,
    /// Bytes a second of messages of [`LARGE`] bytes: from half the median round trip minus the latency.
    pub bandwidth: f64,
}

/// Measures messages between ranks 0 and 1. All ranks may call it; rank 0 gets the result, the others `None`, those
/// from 2 on at once.
///
/// # Errors
/// [`CommError`]; [`CommError::NoPartner`] for rank 0 if it is alone.
pub fn measure(comm: &mut impl Communicator, way: Way) -> Result<Option<Measured>, CommError> {
    let begin = Instant::now();
    measure_by(comm, way, &|| begin.elapsed().as_secs_f64())
}

/// [`measure`] by a clock in seconds.
fn measure_by(
    comm: &mut impl Communicator,
    way: Way,
    clock: &dyn Fn() -> f64,
) -> Result<Option<Measured>, CommError> {
    let partner = match comm.rank() {
        0 => 1,
        1 => 0,
        _ => return Ok(None),
    };
    let small = half_trip(comm, partner, way, clock, [SMALL, SMALL_TRIPS])?;
    let large = half_trip(comm, partner, way, clock, [LARGE, LARGE_TRIPS])?;
    Ok((partner == 1).then(|| Measured { latency: small, bandwidth: bandwidth(small, large) }))
}

/// Bytes a second, from the seconds of small and of large messages. On a busy machine a small one may take as long as a
/// large one; then at least half of the large one's time counts.
fn bandwidth(small: f64, large: f64) -> f64 {
    LARGE as f64 / (large - small).max(large / 2.0)
}

/// Half the median round trip in seconds; only rank 0 has one to return.
fn half_trip<C: Communicator>(
    comm: &mut C,
    partner: usize,
    way: Way,
    clock: &dyn Fn() -> f64,
    [bytes, trips]: [usize; 2],
) -> Result<f64, CommError> {
    let take = |comm: &mut C| {
        let message = comm.receive(partner)?;
        Ok::<_, CommError>(if way == Way::HandedOver { message.clone() } else { message })
    };
    if partner == 0 {
        for _ in 0..FIRST + trips {
            let message = take(comm)?;
            comm.send(partner, message)?;
        }
        return Ok(0.0);
    }
    let mut message = vec![1u8; bytes];
    let mut seconds = Vec::with_capacity(FIRST + trips);
    for _ in 0..FIRST + trips {
        let begin = clock();
        comm.send(partner, message)?;
        message = take(comm)?;
        seconds.push(clock() - begin);
    }
    let counted = &mut seconds[FIRST..];
    counted.sort_by(f64::total_cmp);
    Ok(counted[counted.len() / 2] / 2.0)
}

/// Messages between two threads of this process.
///
/// # Errors
/// [`ParallelError`].
pub fn between_threads() -> Result<Network, ParallelError> {
    let measured = threads::run(2, |comm| Ok(measure(comm, Way::HandedOver)?))?;
    let Some(measured) = measured.into_iter().flatten().next() else { unreachable!("rank 0 has measured") };
    let hop = "threads of one process: no switch between them";
    Ok(network(measured, "between two threads of one process", hop))
}

/// The measured values as a section of a description. `between` says who exchanged the messages, `hop` why a hop costs
/// nothing.
pub fn network(measured: Measured, between: &str, hop: &str) -> Network {
    let measured_by = format!("measured by tercio lab calibrate {between}: half the median round trip of");
    let latency = (measured.latency, format!("{:.3} us", measured.latency * 1e6));
    let bandwidth = (measured.bandwidth, format!("{:.4} GB/s", measured.bandwidth / 1e9));
    let of_latency = format!("{measured_by} {SMALL} B, {SMALL_TRIPS} of them");
    let of_bandwidth = format!("{measured_by} {LARGE} B, {LARGE_TRIPS} of them, less that of {SMALL} B");
    Network {
        topology: Topology::Crossbar,
        bandwidth: Sourced::new(bandwidth.0, bandwidth.1, of_bandwidth),
        hop: Sourced::new(0.0, "0 s".into(), hop.into()),
        message: Sourced::new(latency.0, latency.1, of_latency),
        packing: Packing::default(),
        delivery: Delivery::default(),
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;
    use std::rc::Rc;
    use std::time::Duration;

    use tercio_parallel::comm::Traffic;

    use super::*;

    /// A rank 0 whose messages take a known time.
    #[derive(Default)]
    struct Slow {
        message: Vec<u8>,
        traffic: Traffic,
        /// What a clock shows.
        now: Rc<Cell<Duration>>,
    }

    /// Microseconds of a message.
    const SLOW: u64 = 50;
    /// Bytes a microsecond.
    const RATE: u64 = 2000;

    impl Communicator for Slow {
        fn rank(&self) -> usize {
            0
        }

        fn size(&self) -> usize {
            2
        }

        fn send(&mut self, _: usize, message: Vec<u8>) -> Result<(), CommError> {
            self.traffic.sent_messages += 1;
            self.message = message;
            Ok(())
        }

        fn receive(&mut self, _: usize) -> Result<Vec<u8>, CommError> {
            let there_and_back = 2 * Duration::from_micros(SLOW + self.message.len() as u64 / RATE);
            self.now.set(self.now.get() + there_and_back);
            Ok(std::mem::take(&mut self.message))
        }

        fn receive_within(&mut self, from: usize, _: Duration) -> Result<Option<Vec<u8>>, CommError> {
            self.receive(from).map(Some)
        }

        fn traffic(&self) -> Traffic {
            self.traffic
        }

        fn signal(&mut self, _: usize) -> Result<(), CommError> {
            Ok(())
        }

        fn await_signal(&mut self, _: usize) -> Result<(), CommError> {
            Ok(())
        }
    }

    #[test]
    fn bandwidth_is_finite_even_if_small_messages_take_long() {
        let bytes = LARGE as f64;
        assert_eq!(bandwidth(0.25, 1.25), bytes);
        assert_eq!([0.5, 1.0, 7.0].map(|small| bandwidth(small, 1.0)), [2.0 * bytes; 3]);
    }

    #[test]
    fn a_known_latency_and_bandwidth_are_found() {
        let mut comm = Slow::default();
        let now = Rc::clone(&comm.now);
        let clock = || now.get().as_secs_f64();
        let measured = measure_by(&mut comm, Way::Copied, &clock).unwrap().expect("rank 0 measures");
        assert_eq!(comm.traffic().sent_messages as usize, 2 * FIRST + SMALL_TRIPS + LARGE_TRIPS);
        assert!((measured.latency - 50e-6).abs() < 1e-9, "{measured:?}");
        assert!((measured.bandwidth / 2e9 - 1.0).abs() < 1e-3, "{measured:?}");
    }

    #[test]
    fn threads_are_measured_by_ranks_0_and_1() {
        let all = threads::run(3, |comm| {
            let measured = measure(comm, Way::HandedOver)?;
            Ok((measured, comm.traffic()))
        });
        let all = all.unwrap();
        let measured = all[0].0.expect("rank 0 measures");
        assert!(measured.latency > 1e-9 && measured.bandwidth > 1e6, "{measured:?}");
        let trips = (2 * FIRST + SMALL_TRIPS + LARGE_TRIPS) as u64;
        let bytes = ((FIRST + SMALL_TRIPS) * SMALL + (FIRST + LARGE_TRIPS) * LARGE) as u64;
        let both =
            Traffic { sent_messages: trips, sent_bytes: bytes, taken_messages: trips, taken_bytes: bytes };
        assert_eq!([all[0].1, all[1].1, all[2].1], [both, both, Traffic::default()]);
        assert_eq!([all[1].0, all[2].0], [None, None]);
    }

    #[test]
    fn a_single_rank_has_no_partner() {
        let error = threads::run(1, |comm| Ok(measure(comm, Way::Copied)?)).unwrap_err();
        assert!(matches!(error, ParallelError::Comm(CommError::NoPartner { rank: 1, size: 1 })), "{error}");
    }
}
