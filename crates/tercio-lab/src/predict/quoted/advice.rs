//! The advised way to draw, and the fastest.

use serde::{Deserialize, Serialize};

use super::{QuotedRow, milliseconds};
use crate::predict::validate_advice::{Coverage, Row, TOLERANCE};

/// A model at one size.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct AdviceRow {
    /// Model.
    pub model: String,
    /// Width and height of the picture in pixels.
    pub size: [u32; 2],
    /// Ways to draw that were measured.
    pub ways: usize,
    /// The advised one.
    pub advised: String,
    /// The fastest one.
    pub best: String,
    /// Milliseconds of the advised one, predicted.
    pub predicted: f64,
    /// Measured ones.
    pub measured: f64,
    /// Those of the fastest.
    pub best_measured: f64,
    /// Root mean square of predicted over measured, minus 1: of what was counted, and of the formulas.
    pub errors: [f64; 2],
    /// Measured times inside their stated intervals, of the same two; `None` if no intervals are stated, or
    /// nobody counted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coverage: Option<[Coverage; 2]>,
}

impl AdviceRow {
    /// Measured milliseconds of the advised way over those of the fastest, minus 1.
    pub fn loss(&self) -> f64 {
        self.measured / self.best_measured - 1.0
    }
}

impl From<&Row> for AdviceRow {
    fn from(row: &Row) -> Self {
        let (advised, best) = (row.advised(), row.best());
        let share = |of_formulas| (row.errors(of_formulas).rms * 1e3).round() / 1e3;
        Self {
            model: row.model.clone(),
            size: row.size.into(),
            ways: row.drawn.len(),
            advised: advised.candidate.describe(),
            best: best.candidate.describe(),
            predicted: milliseconds(advised.candidate.frame.total()),
            measured: milliseconds(advised.seconds),
            best_measured: milliseconds(best.seconds),
            errors: [share(false), share(true)],
            coverage: row.coverage(false).zip(row.coverage(true)).map(Into::into),
        }
    }
}

impl QuotedRow for AdviceRow {
    const HEADER: &'static [&'static str] = &[
        "model",
        "size",
        "ways",
        "advised",
        "predicted / measured ms",
        "fastest",
        "its ms",
        "errors: counted, formulas",
        "inside their interval: counted, formulas",
        "loss",
        "verdict",
    ];

    fn cells(&self) -> Vec<String> {
        vec![
            self.model.clone(),
            format!("{}x{}", self.size[0], self.size[1]),
            self.ways.to_string(),
            self.advised.clone(),
            format!("{:.2} / {:.2}", self.predicted, self.measured),
            self.best.clone(),
            format!("{:.2}", self.best_measured),
            format!("{:.0} %, {:.0} %", self.errors[0] * 100.0, self.errors[1] * 100.0),
            self.coverage.map_or("not counted".into(), |both| {
                both.map(|c| format!("{} of {}", c.inside, c.of)).join(", ")
            }),
            format!("{:+.1} %", self.loss() * 100.0),
            if self.holds() { "holds" } else { "misses" }.into(),
        ]
    }

    fn holds(&self) -> bool {
        self.loss() <= TOLERANCE
    }

    fn is_of_the_same(&self, other: &Self) -> bool {
        (&self.model, self.size) == (&other.model, other.size)
    }
}
