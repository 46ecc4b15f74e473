//! Progress of long work, reported without slowing it down.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// Shared between the work, which writes it, and the code that displays it, which reads it now and then.
#[derive(Debug, Default)]
pub struct Progress {
    stage: Mutex<&'static str>,
    done: AtomicU64,
    total: AtomicU64,
}

impl Progress {
    /// Begins a stage of `total` units; 0 if the total is unknown.
    pub fn begin(&self, stage: &'static str, total: u64) {
        if let Ok(mut s) = self.stage.lock() {
            *s = stage;
        }
        self.done.store(0, Relaxed);
        self.total.store(total, Relaxed);
    }

    /// Adds finished units of the current stage.
    pub fn advance(&self, units: u64) {
        self.done.fetch_add(units, Relaxed);
    }

    /// Stage name, units done, units in total.
    pub fn state(&self) -> (&'static str, u64, u64) {
        let stage = self.stage.lock().map_or("", |s| *s);
        (stage, self.done.load(Relaxed), self.total.load(Relaxed))
    }
}
