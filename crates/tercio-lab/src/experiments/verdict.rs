//! The result of a comparison with what was published.

use serde::Serialize;

/// How an experiment agrees with what was published. Which class it is follows from a
/// [`Comparison`](super::Comparison).
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "verdict", rename_all = "kebab-case")]
pub enum Verdict {
    /// Something other than the document's own formula gives the printed numbers: a simulation, a count, brute force.
    Reproduced {
        /// What agrees, and how closely.
        found: String,
    },
    /// The printed numbers follow after a mistake in the document or the scan is corrected, and not before.
    ReproducedAfterCorrection {
        /// What agrees, and how closely.
        found: String,
        /// What was corrected, and why.
        correction: String,
    },
    /// The document's own formula, evaluated with the document's own inputs, gives the printed numbers. That shows
    /// that the formula is read as it was meant, and nothing more.
    Restated {
        /// What agrees, and how closely.
        found: String,
    },
    /// An input was chosen so that the printed numbers come out.
    ByConstruction {
        /// What agrees, and how closely.
        found: String,
    },
    /// Only the shape can be compared, or a number with an input that the document does not state.
    Qualitative {
        /// Why: the scene is lost, an input is not stated.
        why: String,
        /// The properties of the shape that agree, measured, and which inputs give the printed numbers; what does not agree
        /// only of a model that is ours and not the document's.
        found: String,
    },
    /// Some printed numbers agree, and something else that is printed does not.
    ContradictedInPart {
        /// What does not agree, where and by how much; then what does.
        found: String,
    },
    /// What is printed does not agree, and no printed number does.
    Contradicted {
        /// Where and by how much.
        found: String,
    },
    /// No verdict: what is published does not determine whether our values are right, so that ours stand beside it.
    None {
        /// What is not published.
        why: String,
        /// Ours.
        beside: String,
    },
}

/// The names of all verdicts, in the order of a summary.
const NAMES: [&str; 8] = [
    "reproduced",
    "reproduced after correction",
    "restated",
    "by construction",
    "qualitative",
    "contradicted in part",
    "contradicted",
    "no verdict",
];

/// How many experiments have which verdict, in words; those without a verdict, and those that failed, are counted apart.
pub fn summary<'a>(verdicts: impl Iterator<Item = Option<&'a Verdict>>) -> String {
    let names: Vec<_> = verdicts.map(|verdict| verdict.map_or("failed", Verdict::name)).collect();
    let count = |name: &str| names.iter().filter(|found| **found == name).count();
    let all = NAMES.into_iter().chain(["failed"]).map(|name| (name, count(name)));
    let words: Vec<_> = all.filter(|of| of.1 > 0).map(|(name, count)| format!("{count} {name}")).collect();
    format!("Of {} experiments: {}.", names.len(), words.join(", "))
}

impl Verdict {
    /// The verdict in a word or two.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Reproduced { .. } => "reproduced",
            Self::ReproducedAfterCorrection { .. } => "reproduced after correction",
            Self::Restated { .. } => "restated",
            Self::ByConstruction { .. } => "by construction",
            Self::Qualitative { .. } => "qualitative",
            Self::ContradictedInPart { .. } => "contradicted in part",
            Self::Contradicted { .. } => "contradicted",
            Self::None { .. } => "no verdict",
        }
    }

    /// The verdict in sentences.
    pub fn text(&self) -> String {
        match self {
            Self::Reproduced { found }
            | Self::Contradicted { found }
            | Self::ContradictedInPart { found } => found.clone(),
            Self::ReproducedAfterCorrection { found, correction } => {
                format!("{found} Corrected: {correction}")
            }
            Self::Restated { found } => format!("The same formulas, evaluated. {found}"),
            Self::ByConstruction { found } => format!("An input was chosen so that this comes out. {found}"),
            Self::Qualitative { why, found } => format!("{why} {found}"),
            Self::None { why, beside } => format!("{why} Ours: {beside}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_summary_counts_every_experiment_once() {
        let words = String::new;
        let all = [
            Verdict::Reproduced { found: words() },
            Verdict::ReproducedAfterCorrection { found: words(), correction: words() },
            Verdict::Restated { found: words() },
            Verdict::ByConstruction { found: words() },
            Verdict::Qualitative { why: words(), found: words() },
            Verdict::ContradictedInPart { found: words() },
            Verdict::Contradicted { found: words() },
            Verdict::None { why: words(), beside: words() },
        ];
        assert_eq!(NAMES, std::array::from_fn::<_, 8, _>(|k| all[k].name()));
        let some = [Some(&all[0]), Some(&all[7]), None, Some(&all[0])];
        assert_eq!(summary(some.into_iter()), "Of 4 experiments: 2 reproduced, 1 no verdict, 1 failed.");
    }
}
