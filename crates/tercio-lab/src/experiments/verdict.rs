//! The result of a comparison with what was published.

use serde::Serialize;

/// How an experiment agrees with what was published. Which class it is follows from a
/// [`Comparison`](super::Comparison).
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "verdict", rename_all = "kebab-case")]
pub enum Verdict {
    /// Something other than the document's own formula gives the printed numbers: a simulation, a count, brute force.
    Reproduced {
        /// How closely.
        within: String,
    },
    /// The printed numbers follow after a mistake in the document or the scan is corrected.
    ReproducedAfterCorrection {
        /// How closely.
        within: String,
        /// What was corrected, and why.
        correction: String,
    },
    /// The document's own formula, evaluated with the document's own inputs, gives the printed numbers. That shows
    /// that the formula is read as it was meant, and nothing more.
    Restated {
        /// How closely.
        within: String,
    },
    /// An input was chosen so that the printed numbers come out.
    ByConstruction {
        /// How closely.
        within: String,
    },
    /// Only the shape can be compared, or a number with an input that the document does not state.
    Qualitative {
        /// Why: the scene is lost, an input is not stated.
        why: String,
        /// The properties of the shape that agree, measured, and which inputs give the printed numbers.
        agrees: String,
        /// What does not agree, of a model that is ours and not the document's; otherwise empty.
        #[serde(skip_serializing_if = "String::is_empty")]
        fails: String,
    },
    /// Our values do not agree.
    Contradicted {
        /// Where and by how much.
        why: String,
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
const NAMES: [&str; 7] = [
    "reproduced",
    "reproduced after correction",
    "restated",
    "by construction",
    "qualitative",
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
            Self::Contradicted { .. } => "contradicted",
            Self::None { .. } => "no verdict",
        }
    }

    /// The verdict in sentences.
    pub fn text(&self) -> String {
        match self {
            Self::Reproduced { within } => capitalized(within),
            Self::ReproducedAfterCorrection { within, correction } => {
                format!("{} Corrected: {correction}", capitalized(within))
            }
            Self::Restated { within } => format!("The same formulas, evaluated. {}", capitalized(within)),
            Self::ByConstruction { within } => {
                format!("An input was chosen so that this comes out. {}", capitalized(within))
            }
            Self::Qualitative { why, agrees, fails } => {
                let parts = [("Not so: ", fails), ("What agrees: ", agrees)];
                let said = parts.iter().filter(|part| !part.1.is_empty());
                said.fold(why.clone(), |text, (head, part)| format!("{text} {head}{part}"))
            }
            Self::Contradicted { why } => capitalized(why),
            Self::None { why, beside } => format!("{why} Ours: {beside}"),
        }
    }
}

fn capitalized(sentence: &str) -> String {
    let mut letters = sentence.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_fails_is_not_among_what_agrees() {
        let text = |agrees: &str, fails: &str| {
            let (agrees, fails) = (agrees.to_owned(), fails.to_owned());
            Verdict::Qualitative { why: "It is ours.".into(), agrees, fails }.text()
        };
        assert_eq!(text("a; b.", ""), "It is ours. What agrees: a; b.");
        assert_eq!(text("b.", "a."), "It is ours. Not so: a. What agrees: b.");
        assert_eq!(text("", "a."), "It is ours. Not so: a.");
    }

    #[test]
    fn a_summary_counts_every_experiment_once() {
        let words = String::new;
        let all = [
            Verdict::Reproduced { within: words() },
            Verdict::ReproducedAfterCorrection { within: words(), correction: words() },
            Verdict::Restated { within: words() },
            Verdict::ByConstruction { within: words() },
            Verdict::Qualitative { why: words(), agrees: words(), fails: words() },
            Verdict::Contradicted { why: words() },
            Verdict::None { why: words(), beside: words() },
        ];
        assert_eq!(NAMES, std::array::from_fn::<_, 7, _>(|k| all[k].name()));
        let some = [Some(&all[0]), Some(&all[6]), None, Some(&all[0])];
        assert_eq!(summary(some.into_iter()), "Of 4 experiments: 2 reproduced, 1 no verdict, 1 failed.");
    }
}
