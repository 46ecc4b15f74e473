//! Why a predicted time is not the measured one: the terms of the difference, stage by stage, the largest first.
//!
//! The renderer can end a frame after each of its stages ([`LastStage`]). The time of a stage is that of frames that
//! end with it, less that of frames that end with the one before, of measured frames as of predicted ones. So the
//! differences of the stages add up to that of the frame.

use std::fmt::Write;

use serde::{Deserialize, Serialize};
use tercio_raster::LastStage;

/// The stages of a frame of threads, each with the last one of a frame that has it. [`LastStage::Sieve`] is none of
/// them: its frames also have the clusters that are hidden in whole ones.
pub const STAGES: [(LastStage, &str); 4] = [
    (LastStage::Cull, "culling"),
    (LastStage::Bin, "sorting"),
    (LastStage::Visibility, "visibility"),
    (LastStage::Output, "shading"),
];

/// The terms of the time of ranks, on rank 0. "queueing" is everything else, most of it waiting for a processor.
pub const RANK_TERMS: [&str; 6] = ["dividing", "drawing", "composing", "collecting", "waiting", "queueing"];

/// The share of all differences, taken without their signs, that an explanation names.
const NAMED: f64 = 0.9;

/// A part of a frame's time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Term {
    /// What happens in it.
    pub name: String,
    /// Predicted seconds; milliseconds in tables.
    pub predicted: f64,
    /// Measured ones.
    pub measured: f64,
}

impl Term {
    /// Predicted less measured.
    pub fn difference(&self) -> f64 {
        self.predicted - self.measured
    }

    /// With times in another unit, each rounded by `f`.
    #[must_use]
    pub fn map(&self, f: impl Fn(f64) -> f64) -> Self {
        Self { name: self.name.clone(), predicted: f(self.predicted), measured: f(self.measured) }
    }
}

/// Terms with these names, the one with the largest difference first.
pub fn terms<const N: usize>(names: [&str; N], predicted: [f64; N], measured: [f64; N]) -> Vec<Term> {
    let of = |k: usize| Term { name: names[k].into(), predicted: predicted[k], measured: measured[k] };
    let mut terms: Vec<Term> = (0..N).map(of).collect();
    terms.sort_by(|a, b| b.difference().abs().total_cmp(&a.difference().abs()));
    terms
}

/// The stages' own times, from those of frames that end with them.
pub fn of_stages<const N: usize>(until: [f64; N]) -> [f64; N] {
    std::array::from_fn(|k| until[k] - if k == 0 { 0.0 } else { until[k - 1] })
}

/// The terms that make up [nine tenths](NAMED) of the differences, given the largest first, in the unit that they are
/// given in, with their signs: "visibility -1.20, shading +0.31".
pub fn explanation(terms: &[Term]) -> String {
    let all: f64 = terms.iter().map(|t| t.difference().abs()).sum();
    let (mut text, mut named) = (String::new(), 0.0);
    for term in terms {
        if named >= NAMED * all {
            break;
        }
        let separator = if text.is_empty() { "" } else { ", " };
        // Writing into a string cannot fail.
        let _ = write!(text, "{separator}{} {:+.2}", term.name, term.difference());
        named += term.difference().abs();
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Made-up times of frames that end after each stage: the terms are what was put in, in order of size.
    #[test]
    fn terms_add_up_to_the_difference_and_the_largest_comes_first() {
        let names = STAGES.map(|s| s.1);
        let (predicted, measured) = ([1.0, 3.0, 11.0, 14.0], [1.5, 3.25, 16.25, 18.0]);
        let terms = terms(names, of_stages(predicted), of_stages(measured));
        let seen: Vec<(&str, f64)> = terms.iter().map(|t| (t.name.as_str(), t.difference())).collect();
        // Predicted are 1, 2, 8 and 3, measured 1.5, 1.75, 13 and 1.75.
        assert_eq!(seen, [("visibility", -5.0), ("shading", 1.25), ("culling", -0.5), ("sorting", 0.25)]);
        assert_eq!(terms.iter().map(Term::difference).sum::<f64>(), 14.0 - 18.0);
        assert_eq!(explanation(&terms), "visibility -5.00, shading +1.25, culling -0.50");
        assert_eq!(terms[0].map(|s| s * 1e3).difference(), -5000.0);
    }

    #[test]
    fn one_term_may_be_the_whole_explanation() {
        let one = |difference: f64| explanation(&terms(["a", "b"], [2.0, 1.0 + difference], [2.0, 1.0]));
        assert_eq!(one(0.5), "b +0.50");
        assert_eq!(one(0.0), "", "nothing differs");
    }
}
