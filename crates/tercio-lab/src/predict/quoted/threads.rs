//! Frames of threads.

use serde::{Deserialize, Serialize};

use super::{QuotedRow, milliseconds, verdict};
use crate::predict::difference::{Term, explanation};
use crate::predict::validate::{Row, tolerance};

/// A model at one size on some threads.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct ThreadsRow {
    /// Model.
    pub model: String,
    /// Width and height of the picture in pixels.
    pub size: [u32; 2],
    /// Threads.
    pub threads: usize,
    /// Counters that are equal, and counters that were compared.
    pub counters: [usize; 2],
    /// Predicted milliseconds.
    pub predicted: f64,
    /// Measured milliseconds.
    pub measured: f64,
    /// Whether no two triangles of the model share a vertex.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub loose: bool,
    /// The stages of both, the largest difference first.
    pub terms: Vec<Term>,
}

impl ThreadsRow {
    /// Predicted over measured, minus 1.
    pub fn error(&self) -> f64 {
        self.predicted / self.measured - 1.0
    }
}

impl From<&Row> for ThreadsRow {
    fn from(row: &Row) -> Self {
        Self {
            model: row.model.clone(),
            size: row.size.into(),
            threads: row.threads,
            counters: [row.compared - row.differing.len(), row.compared],
            predicted: milliseconds(row.predicted),
            measured: milliseconds(row.measured),
            loose: row.is_loose,
            terms: row.terms.iter().map(|t| t.map(milliseconds)).collect(),
        }
    }
}

impl QuotedRow for ThreadsRow {
    const HEADER: &'static [&'static str] = &[
        "model",
        "size",
        "threads",
        "counters equal",
        "predicted ms",
        "measured ms",
        "difference by stage, ms",
        "error",
        "verdict",
    ];

    fn cells(&self) -> Vec<String> {
        vec![
            self.model.clone(),
            format!("{}x{}", self.size[0], self.size[1]),
            self.threads.to_string(),
            format!("{} of {}", self.counters[0], self.counters[1]),
            format!("{:.3}", self.predicted),
            format!("{:.3}", self.measured),
            explanation(&self.terms),
            format!("{:+.1} %", self.error() * 100.0),
            verdict(self.holds(), tolerance(self.loose)),
        ]
    }

    fn holds(&self) -> bool {
        self.counters[0] == self.counters[1] && self.error().abs() <= tolerance(self.loose)
    }

    fn is_of_the_same(&self, other: &Self) -> bool {
        (&self.model, self.size, self.threads) == (&other.model, other.size, other.threads)
    }
}
