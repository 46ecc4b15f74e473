//! The result of a comparison with published numbers.

use serde::Serialize;

use crate::published::{self, Standing, TableError};

/// How an experiment agrees with what was published.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "verdict", rename_all = "kebab-case")]
pub enum Verdict {
    /// Our values agree with the published numbers.
    Reproduced {
        /// How closely.
        within: String,
    },
    /// Our values agree after a mistake in the document or the scan is corrected.
    ReproducedAfterCorrection {
        /// How closely.
        within: String,
        /// What was corrected, and why.
        correction: String,
    },
    /// Only the shape can be compared.
    QualitativeOnly {
        /// Why: the scene is lost, an input is not stated.
        why: String,
        /// The properties of the shape that agree, measured.
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
            Self::QualitativeOnly { .. } => "qualitative only",
            Self::Contradicted { .. } => "contradicted",
        }
    }

    /// The verdict in sentences.
    pub fn text(&self) -> String {
        match self {
            Self::Reproduced { within } => format!("Within {within}."),
            Self::ReproducedAfterCorrection { within, correction } => {
                format!("Within {within}, after a correction: {correction}")
            }
            Self::QualitativeOnly { why, agrees } => format!("{why} What agrees: {agrees}"),
            Self::Contradicted { why } => why.clone(),
        }
    }
}

/// Pairs of computed and published numbers, and claims about shapes, from which a verdict is derived.
#[derive(Clone, Debug, Default)]
pub struct Comparison {
    pairs: Vec<Pair>,
    claims: Vec<(String, bool)>,
}

#[derive(Clone, Debug)]
struct Pair {
    name: String,
    ours: f64,
    published: f64,
    tolerance: f64,
}

impl Comparison {
    /// An empty comparison.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a computed number and a published one; `tolerance` is absolute.
    pub fn add(&mut self, name: impl Into<String>, ours: f64, published: f64, tolerance: f64) {
        self.pairs.push(Pair { name: name.into(), ours, published, tolerance });
    }

    /// Adds a property of the shape that the document states or draws, and whether our result has it.
    pub fn claim(&mut self, what: impl Into<String>, holds: bool) {
        self.claims.push((what.into(), holds));
    }

    /// Whether all numbers are within their tolerances and all claims hold; false if there is nothing to compare.
    pub fn agrees(&self) -> bool {
        let some = !(self.pairs.is_empty() && self.claims.is_empty());
        some && self.pairs.iter().all(Pair::agrees) && self.claims.iter().all(|c| c.1)
    }

    /// A sentence about what holds and what does not.
    fn words(&self) -> String {
        let of = |holding: bool| {
            let names: Vec<_> = self.claims.iter().filter(|c| c.1 == holding).map(|c| c.0.as_str()).collect();
            names.join("; ")
        };
        let (held, failed) = (of(true), of(false));
        let mut parts = Vec::new();
        if !failed.is_empty() {
            parts.push(format!("not so: {failed}"));
        }
        if !self.pairs.is_empty() {
            parts.push(self.words_of_numbers());
        }
        if !held.is_empty() {
            parts.push(held);
        }
        parts.join("; ")
    }

    /// The pairs, their largest deviation, and the places that fail.
    fn words_of_numbers(&self) -> String {
        let failed: Vec<_> = self.pairs.iter().filter(|p| !p.agrees()).collect();
        let relative = |p: &&Pair| if p.published == 0.0 { 0.0 } else { (p.ours / p.published - 1.0).abs() };
        let worst = self.pairs.iter().max_by(|a, b| relative(a).total_cmp(&relative(b)));
        let worst = worst.map_or(String::new(), |p| {
            format!("; largest deviation {:.2} % at {}", 100.0 * relative(&p), p.name)
        });
        if failed.is_empty() {
            return format!("the stated tolerance of each of {} numbers{worst}", self.pairs.len());
        }
        let said =
            |p: &&Pair| format!("{}: ours {}, published {} ± {}", p.name, p.ours, p.published, p.tolerance);
        format!(
            "{} of {} numbers miss: {}",
            failed.len(),
            self.pairs.len(),
            failed.iter().map(said).collect::<Vec<_>>().join("; ")
        )
    }

    /// Reproduced if everything agrees, otherwise contradicted.
    pub fn verdict(&self) -> Verdict {
        if self.agrees() {
            Verdict::Reproduced { within: self.words() }
        } else {
            Verdict::Contradicted { why: self.words() }
        }
    }

    /// Reproduced after `correction` if everything agrees, otherwise contradicted.
    pub fn verdict_after(&self, correction: impl Into<String>) -> Verdict {
        if self.agrees() {
            Verdict::ReproducedAfterCorrection { within: self.words(), correction: correction.into() }
        } else {
            Verdict::Contradicted { why: self.words() }
        }
    }

    /// Qualitative only, for the reason `why`, if everything agrees; otherwise contradicted.
    pub fn qualitative(&self, why: impl Into<String>) -> Verdict {
        if self.agrees() {
            Verdict::QualitativeOnly { why: why.into(), agrees: format!("{}.", self.words()) }
        } else {
            Verdict::Contradicted { why: self.words() }
        }
    }

    /// Compares the published numbers whose names begin with one of `prefixes` with the results of their formulas.
    /// Numbers that the document itself contradicts are compared with their corrected values.
    ///
    /// # Errors
    /// The table has a mistake.
    pub fn of_published(prefixes: &[&str]) -> Result<Self, TableError> {
        let mut comparison = Self::new();
        let begins = |id: &str| prefixes.iter().any(|p| id.starts_with(p));
        for number in published::numbers()?.into_iter().filter(|n| begins(&n.id)) {
            let check = published::check(number);
            let name = check.number.id.clone();
            let Some(expected) = check.number.expected.as_number() else {
                // Lists agree as a whole or not at all.
                comparison.claim(name, check.holds);
                continue;
            };
            let ours = check.ours.as_ref().ok().and_then(|v| v.as_number()).unwrap_or(f64::NAN);
            comparison.add(name, ours, expected, check.number.tolerance);
        }
        Ok(comparison)
    }

    /// The verdict for [`Comparison::of_published`]: after `correction` if one of the numbers had to be restored or
    /// is contradicted by its own document.
    ///
    /// # Errors
    /// The table has a mistake.
    pub fn verdict_of_published(prefixes: &[&str], correction: &str) -> Result<Verdict, TableError> {
        let comparison = Self::of_published(prefixes)?;
        let corrected = published::numbers()?.into_iter().any(|n| {
            prefixes.iter().any(|p| n.id.starts_with(p))
                && matches!(n.standing, Standing::Restored | Standing::Contradicted)
        });
        Ok(if corrected { comparison.verdict_after(correction) } else { comparison.verdict() })
    }
}

impl Pair {
    fn agrees(&self) -> bool {
        // As in the published table: rounding in binary must not decide at the edge of the tolerance.
        let rounding = if self.tolerance > 0.0 { 4.0 * f64::EPSILON * self.published.abs() } else { 0.0 };
        (self.ours - self.published).abs() <= self.tolerance + rounding
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verdicts_follow_from_the_pairs() {
        let mut comparison = Comparison::new();
        assert!(
            matches!(comparison.verdict(), Verdict::Contradicted { .. }),
            "nothing compared is nothing shown"
        );
        comparison.add("a", 1.0, 1.01, 0.02);
        assert!(matches!(comparison.verdict(), Verdict::Reproduced { .. }));
        comparison.claim("the curve falls", true);
        let text = comparison.qualitative("No scene.").text();
        assert!(text.starts_with("No scene.") && text.ends_with("; the curve falls."), "{text}");
        let mut false_claim = comparison.clone();
        false_claim.claim("the curve ends", false);
        assert!(matches!(false_claim.qualitative(""), Verdict::Contradicted { .. }));
        assert!(false_claim.verdict().text().contains("not so: the curve ends"));
        comparison.add("b", 1.0, 1.1, 0.02);
        assert!(comparison.verdict_after("sign").text().contains("b: ours 1, published 1.1"));
    }
}
