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

/// The terms that an explanation leaves unnamed are together, without their signs, at most this share of the net difference.
const UNNAMED: f64 = 0.1;

/// Or at most so many milliseconds, where the net difference is small: what a table with two digits cannot show.
const UNNAMED_MILLISECONDS: f64 = 0.01;

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

/// How many of some differences, given the largest first, an explanation names: as many as leave a tenth of their sum at most, or
/// `small`. What is left counts without signs, so that nothing large is left out because something else compensates it; then what is
/// named makes up nine tenths of the sum, too. At least one is named if there is any.
pub fn named(differences: &[f64], small: f64) -> usize {
    let limit = (UNNAMED * differences.iter().sum::<f64>().abs()).max(small);
    let left = |named: usize| differences[named..].iter().map(|d| d.abs()).sum::<f64>();
    let fewest = usize::from(differences.iter().any(|&d| d != 0.0));
    (fewest..differences.len()).find(|&count| left(count) <= limit).unwrap_or(differences.len())
}

/// The terms that make up the difference, given the largest first and in milliseconds, with their signs:
/// "visibility -1.20, shading +0.31".
pub fn explanation(terms: &[Term]) -> String {
    let differences: Vec<f64> = terms.iter().map(Term::difference).collect();
    let count = named(&differences, UNNAMED_MILLISECONDS);
    let mut text = String::new();
    for term in &terms[..count] {
        let separator = if text.is_empty() { "" } else { ", " };
        // Writing into a string cannot fail.
        let _ = write!(text, "{separator}{} {:+.2}", term.name, term.difference());
    }
    text
}

#[cfg(test)]
mod tests {
    use proptest::collection::vec;
    use proptest::prelude::*;

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
        // The others are 0.25 of 4.
        assert_eq!(explanation(&terms), "visibility -5.00, shading +1.25, culling -0.50");
        assert_eq!(terms[0].map(|s| s * 1e3).difference(), -5000.0);
    }

    #[test]
    fn one_term_may_be_the_whole_explanation() {
        let one = |difference: f64| explanation(&terms(["a", "b"], [2.0, 1.0 + difference], [2.0, 1.0]));
        assert_eq!(one(0.5), "b +0.50");
        assert_eq!(one(0.0), "", "nothing differs");
    }

    /// What compensates is named: two large terms that nearly cancel are no explanation of what is left of them.
    #[test]
    fn terms_that_compensate_each_other_are_named() {
        let of = |differences: [f64; 4]| explanation(&terms(["a", "b", "c", "d"], differences, [0.0; 4]));
        assert_eq!(of([-18.02, 15.67, -2.0, -0.15]), "a -18.02, b +15.67, c -2.00");
        // After the first two, -2.35 of -2.5 are named, but not that c and d are large.
        assert_eq!(of([-18.02, 15.67, 1.9, -2.05]), "a -18.02, b +15.67, d -2.05, c +1.90");
        // The others are less than is shown.
        assert_eq!(of([0.05, -0.049, 0.004, 0.004]), "a +0.05, b -0.05");
        assert_eq!(of([0.003, 0.0, 0.0, 0.0]), "a +0.00");
    }

    proptest! {
        /// By its definition: what is named makes up nine tenths of the sum, no large one is left, and one fewer would not do.
        #[test]
        fn no_more_and_no_fewer_are_named_than_the_sum_needs(differences in vec(-9.0f64..9.0, 0..8)) {
            let mut differences = differences;
            differences.sort_by(|a, b| b.abs().total_cmp(&a.abs()));
            let net: f64 = differences.iter().sum();
            let limit = (net.abs() / 10.0).max(0.01);
            let count = named(&differences, 0.01);
            prop_assert!((net - differences[..count].iter().sum::<f64>()).abs() <= limit + 1e-12);
            prop_assert!(differences[count..].iter().all(|d| d.abs() <= limit));
            if count > 1 {
                prop_assert!(differences[count - 1..].iter().map(|d| d.abs()).sum::<f64>() > limit);
            }
        }
    }
}
