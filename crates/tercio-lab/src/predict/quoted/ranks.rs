//! Frames of ranks, of one process or processes.

use serde::{Deserialize, Serialize};

use super::{QuotedRow, milliseconds, verdict};
use crate::predict::difference::{Term, explanation};
use crate::predict::validate_ranks::{Row, StageSeconds, tolerance};

/// A model at one size, shared in one way. Times are predicted and measured milliseconds; that of a stage is its
/// busiest rank's, waiting is rank 0's.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct RanksRow {
    /// Model.
    pub model: String,
    /// Width and height of the picture in pixels.
    pub size: [u32; 2],
    /// Ranks.
    pub ranks: usize,
    /// sort-first or sort-last.
    pub organisation: String,
    /// Messages of a frame, summed over the views.
    pub messages: u64,
    /// Their bytes.
    pub bytes: u64,
    /// Counters that are equal, and counters that were compared.
    pub counters: [usize; 2],
    /// Drawing.
    pub draw: [f64; 2],
    /// Packing for other owners and compositing.
    pub compose: [f64; 2],
    /// Packing for rank 0, unpacking there.
    pub collect: [f64; 2],
    /// Rank 0 waiting for messages and receiving them.
    pub wait: [f64; 2],
    /// The whole frame.
    pub frame: [f64; 2],
    /// Page faults of the median frame, all ranks.
    pub faults: u64,
    /// Context switches in it.
    pub switches: u64,
    /// Whether ranks are processes.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub mpi: bool,
    /// The terms of the frame on rank 0, the largest difference first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub terms: Vec<Term>,
}

impl RanksRow {
    /// Predicted over measured, minus 1, of the whole frame.
    pub fn error(&self) -> f64 {
        self.frame[0] / self.frame[1] - 1.0
    }
}

impl From<&Row> for RanksRow {
    fn from(row: &Row) -> Self {
        let both =
            |of: fn(&StageSeconds) -> f64| [&row.predicted, &row.measured].map(|s| milliseconds(of(s)));
        Self {
            model: row.model.clone(),
            size: row.size.into(),
            ranks: row.ranks,
            organisation: row.organisation.name().into(),
            messages: row.messages,
            bytes: row.bytes,
            counters: [row.compared - row.differing.len(), row.compared],
            draw: both(|s| s.draw),
            compose: both(|s| s.compose),
            collect: both(|s| s.collect),
            wait: both(|s| s.wait),
            frame: both(|s| s.frame),
            faults: row.page_faults.round() as u64,
            switches: row.switches.round() as u64,
            mpi: row.is_over_mpi,
            terms: row.terms.iter().map(|t| t.map(milliseconds)).collect(),
        }
    }
}

impl QuotedRow for RanksRow {
    const HEADER: &'static [&'static str] = &[
        "model",
        "size",
        "ranks",
        "organisation",
        "messages",
        "bytes",
        "counters equal",
        "draw ms",
        "compose ms",
        "collect ms",
        "wait ms",
        "frame ms",
        "faults",
        "switches",
        "difference on rank 0, ms",
        "error",
        "verdict",
    ];

    fn cells(&self) -> Vec<String> {
        let both = |times: [f64; 2]| format!("{:.2} / {:.2}", times[0], times[1]);
        vec![
            self.model.clone(),
            format!("{}x{}", self.size[0], self.size[1]),
            self.ranks.to_string(),
            self.organisation.clone(),
            self.messages.to_string(),
            self.bytes.to_string(),
            format!("{} of {}", self.counters[0], self.counters[1]),
            both(self.draw),
            both(self.compose),
            both(self.collect),
            both(self.wait),
            both(self.frame),
            self.faults.to_string(),
            self.switches.to_string(),
            explanation(&self.terms),
            format!("{:+.1} %", self.error() * 100.0),
            verdict(self.holds(), tolerance(self.mpi)),
        ]
    }

    fn holds(&self) -> bool {
        self.counters[0] == self.counters[1] && self.error().abs() <= tolerance(self.mpi)
    }

    fn is_of_the_same(&self, other: &Self) -> bool {
        (&self.model, self.size, self.ranks, &self.organisation)
            == (&other.model, other.size, other.ranks, &other.organisation)
    }
}
