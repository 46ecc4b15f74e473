//! Elapsed time, and time of the processor that this thread had.

use std::time::{Duration, Instant};

use rustix::time::{ClockId, clock_gettime};

/// Adds up the times between starts and stops.
#[derive(Clone, Copy)]
pub struct Stopwatch {
    pub elapsed: Duration,
    pub processor: Duration,
    began: (Instant, Duration),
}

impl Stopwatch {
    pub fn new() -> Self {
        Self { elapsed: Duration::ZERO, processor: Duration::ZERO, began: (Instant::now(), Duration::ZERO) }
    }

    pub fn start(&mut self) {
        self.began = (Instant::now(), processor());
    }

    pub fn stop(&mut self) {
        self.elapsed += self.began.0.elapsed();
        self.processor += processor() - self.began.1;
    }
}

/// Time of the processor that this thread had.
fn processor() -> Duration {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    Duration::new(time.tv_sec as u64, time.tv_nsec as u32)
}
