//! Clocks: that of the machine, and how far those of other ranks are ahead.

use std::time::Instant;

use crate::comm::{CommError, Communicator};

/// Nanoseconds of a clock that all processes of a machine share, if there is one.
pub fn machine_clock() -> Option<u64> {
    #[cfg(unix)]
    {
        let t = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
        Some(u64::try_from(t.tv_sec).ok()? * 1_000_000_000 + u64::try_from(t.tv_nsec).ok()?)
    }
    #[cfg(not(unix))]
    None
}

/// Nanoseconds of a steady clock, which all processes of a machine share where the system has one.
pub fn now() -> u64 {
    static START: std::sync::OnceLock<Instant> = std::sync::OnceLock::new();
    machine_clock().unwrap_or_else(|| START.get_or_init(Instant::now).elapsed().as_nanos() as u64)
}

/// Round trips to find out how far the clock of a rank is ahead.
const ROUND_TRIPS: usize = 8;

/// How many nanoseconds the clock of each rank is ahead of that of rank 0, which returns it; the others return nothing. All
/// ranks call this. A rank's answer is taken in the middle of the shortest of a few round trips; if it may be of the same
/// moment, the clock is the same.
///
/// # Errors
/// [`CommError`], also if an answer is no time.
pub fn clocks_ahead(comm: &mut impl Communicator, clock: impl Fn() -> u64) -> Result<Vec<i64>, CommError> {
    if comm.rank() > 0 {
        for _ in 0..ROUND_TRIPS {
            comm.receive(0)?;
            comm.send(0, clock().to_le_bytes().to_vec())?;
        }
        return Ok(Vec::new());
    }
    let mut all = vec![0];
    for from in 1..comm.size() {
        let mut best = (u64::MAX, 0);
        for _ in 0..ROUND_TRIPS {
            let begin = clock();
            comm.send(from, Vec::new())?;
            let answer = comm.receive(from)?;
            let trip = clock().saturating_sub(begin);
            let Ok(theirs) = <[u8; 8]>::try_from(&answer[..]) else {
                let reason = format!("{} bytes instead of a time", answer.len());
                return Err(CommError::Transport { rank: from, reason });
            };
            if trip < best.0 {
                let ahead = i128::from(u64::from_le_bytes(theirs)) - i128::from(begin + trip / 2);
                best = (trip, i64::try_from(ahead).unwrap_or(0));
            }
        }
        let (trip, ahead) = best;
        all.push(if ahead.unsigned_abs() <= trip { 0 } else { ahead });
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::comm::threads::run;

    #[test]
    fn clocks_are_aligned() {
        const AHEAD: [i64; 4] = [0, 3_600_000_000_000, -50_000_000_000, 0];
        let found = run(4, |comm| {
            let ahead = AHEAD[comm.rank()];
            let clock = || now().saturating_add(100_000_000_000).saturating_add_signed(ahead);
            Ok(clocks_ahead(comm, clock)?)
        });
        let found = found.expect("clocks").remove(0);
        assert_eq!((found[0], found[3]), (0, 0), "the same clock");
        for (found, ahead) in found.iter().zip(AHEAD) {
            // Threads may be interrupted, but not for a second in all of the trips.
            assert!((found - ahead).abs() < 1_000_000_000, "{found} {ahead}");
        }
    }

    #[test]
    #[cfg(unix)]
    fn the_clock_of_the_machine_runs_at_the_same_rate_as_others() {
        let (begin, began) = (Instant::now(), machine_clock().unwrap());
        std::thread::sleep(std::time::Duration::from_millis(20));
        let passed = machine_clock().unwrap() - began;
        assert!((20_000_000..=begin.elapsed().as_nanos() as u64).contains(&passed), "{passed}");
    }
}
