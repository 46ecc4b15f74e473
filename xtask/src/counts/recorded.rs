//! The counts that are recorded in the repository.

use std::collections::BTreeMap;
use std::path::PathBuf;

use anyhow::{Context as _, Result};
use serde::{Deserialize, Serialize};
use tercio_testkit::workspace_root;

/// Relative difference that is allowed. Runs differ by less than a hundredth of this; the rest is for other versions of
/// the C library.
const TOLERANCE: f64 = 0.02;

const HEADING: &str = "\
# Instructions that one thread executes at the AVX2 level. Compared by `cargo xtask counts`, which is part of
# `cargo xtask test`; written by `cargo xtask counts --accept`.

";

/// `tests/counts.toml`.
#[derive(Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Recorded {
    /// Compiler and target: the counts depend on both.
    pub made_by: String,
    /// By name.
    pub instructions: BTreeMap<String, u64>,
}

/// Result of comparing a count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// As recorded, within the tolerance.
    Same,
    /// More instructions: it became slower.
    More,
    /// Fewer instructions. The record has to be updated; otherwise the gain could be lost again unnoticed.
    Fewer,
    /// Not recorded.
    New,
}

impl Recorded {
    /// Reads the record from the repository.
    ///
    /// # Errors
    /// The file is missing or malformed.
    pub fn read() -> Result<Self> {
        let path = file();
        let text = std::fs::read_to_string(&path).with_context(|| format!("reading {}", path.display()))?;
        toml::from_str(&text).with_context(|| format!("reading {}", path.display()))
    }

    /// Writes the record into the repository.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&self) -> Result<()> {
        let path = file();
        std::fs::write(&path, format!("{HEADING}{}", toml::to_string(self)?))
            .with_context(|| format!("writing {}", path.display()))
    }

    /// Compares a count with its record.
    pub fn verdict(&self, name: &str, count: u64) -> Verdict {
        match self.change(name, count) {
            None => Verdict::New,
            Some(change) if change > TOLERANCE => Verdict::More,
            Some(change) if change < -TOLERANCE => Verdict::Fewer,
            Some(_) => Verdict::Same,
        }
    }

    /// One line about a count.
    pub fn line(&self, name: &str, count: u64) -> String {
        let said = match self.verdict(name, count) {
            Verdict::Same => "as recorded",
            Verdict::More => "MORE than recorded",
            Verdict::Fewer => "FEWER than recorded",
            Verdict::New => return format!("{name}: {count} instructions, NOT recorded"),
        };
        let percent = self.change(name, count).unwrap_or(0.0) * 100.0;
        format!("{name}: {count} instructions, {percent:+.2} %, {said}")
    }

    fn change(&self, name: &str, count: u64) -> Option<f64> {
        let recorded = *self.instructions.get(name)?;
        Some(count as f64 / recorded as f64 - 1.0)
    }
}

fn file() -> PathBuf {
    workspace_root().join("tests/counts.toml")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_count_is_compared_inside_the_tolerance() {
        let recorded = Recorded { made_by: "a compiler".into(), instructions: [("a".into(), 1000)].into() };
        let verdicts = [981, 1000, 1019, 979, 1021, 0].map(|count| recorded.verdict("a", count));
        use Verdict::{Fewer, More, New, Same};
        assert_eq!(verdicts, [Same, Same, Same, Fewer, More, Fewer]);
        assert_eq!(recorded.verdict("b", 1000), New);
        let back: Recorded = toml::from_str(&toml::to_string(&recorded).unwrap()).unwrap();
        assert_eq!(back.instructions, recorded.instructions);
    }
}
