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
    },
    /// Our values do not agree.
    Contradicted {
        /// Where and by how much.
        why: String,
    },
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
            // Of a model of ours, what fails comes first, and then says itself what agrees.
            Self::Qualitative { why, agrees } if agrees.starts_with("not so: ") => {
                format!("{why} {}", capitalized(agrees))
            }
            Self::Qualitative { why, agrees } => format!("{why} What agrees: {agrees}"),
            Self::Contradicted { why } => capitalized(why),
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
        let text =
            |agrees: &str| Verdict::Qualitative { why: "It is ours.".into(), agrees: agrees.into() }.text();
        assert_eq!(text("a; b."), "It is ours. What agrees: a; b.");
        assert_eq!(text("not so: a; what agrees: b."), "It is ours. Not so: a; what agrees: b.");
    }
}
