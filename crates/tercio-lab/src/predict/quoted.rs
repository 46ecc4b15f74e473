//! The table of predicted and measured frames that stands in the repository.
//!
//! It was measured once, on the machine and day that it names; the report quotes it and measures nothing.

use serde::Deserialize;

use super::validate::TOLERANCE;

/// The table.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Quoted {
    /// Machine on which it was measured.
    pub machine: String,
    /// Day, year first.
    pub date: String,
    /// The commands that measured it.
    pub commands: Vec<String>,
    /// Its rows.
    pub rows: Vec<QuotedRow>,
}

/// A model at one size on some threads.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct QuotedRow {
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
}

impl QuotedRow {
    /// Predicted over measured, less 1.
    pub fn error(&self) -> f64 {
        self.predicted / self.measured - 1.0
    }

    /// All counters equal, and the time within [`TOLERANCE`].
    pub fn holds(&self) -> bool {
        self.counters[0] == self.counters[1] && self.error().abs() <= TOLERANCE
    }

    /// The cells of a table: model, size, threads, counters, times, error, verdict.
    pub fn cells(&self) -> [String; 8] {
        [
            self.model.clone(),
            format!("{}x{}", self.size[0], self.size[1]),
            self.threads.to_string(),
            format!("{} of {}", self.counters[0], self.counters[1]),
            format!("{:.3}", self.predicted),
            format!("{:.3}", self.measured),
            format!("{:+.1} %", self.error() * 100.0),
            if self.holds() { "holds" } else { "misses" }.into(),
        ]
    }
}

/// Titles of [`QuotedRow::cells`].
pub const HEADER: [&str; 8] =
    ["model", "size", "threads", "counters equal", "predicted ms", "measured ms", "error", "verdict"];

/// The table of this version.
///
/// # Errors
/// The file has a mistake.
pub fn table() -> Result<Quoted, toml::de::Error> {
    toml::from_str(include_str!("../../data/measured/prediction.toml"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_in_docs_shows_the_same_table() {
        let table = table().unwrap();
        let page = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/laboratory/prediction.md");
        let page = std::fs::read_to_string(page).unwrap();
        assert!(page.contains(&table.date), "the day of the measurement");
        for row in &table.rows {
            let line = format!("| {} |", row.cells().join(" | "));
            assert!(page.contains(&line), "{line}");
        }
        let lines = page.lines().filter(|l| l.ends_with("| holds |") || l.ends_with("| misses |"));
        assert_eq!(lines.count(), table.rows.len());
    }

    #[test]
    fn a_row_says_itself_whether_it_holds() {
        let row = QuotedRow {
            model: "m".into(),
            size: [4, 3],
            threads: 1,
            counters: [2, 2],
            predicted: 1.3,
            measured: 1.0,
        };
        assert_eq!(row.cells()[6..], ["+30.0 %".to_string(), "misses".into()]);
        assert!(QuotedRow { predicted: 0.8, ..row.clone() }.holds());
        assert!(!QuotedRow { predicted: 0.8, counters: [1, 2], ..row }.holds());
    }
}
