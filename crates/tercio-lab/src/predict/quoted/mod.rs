//! Tables of predicted and measured frames in the repository.
//!
//! They were measured once, on the machine and day that they name; the report quotes them and measures nothing. `tercio
//! lab validate -o` writes them.
//!
//! | module | what |
//! |---|---|
//! | [`advice`] | rows of advised ways to draw |
//! | [`threads`] | rows of threads |
//! | [`ranks`] | rows of ranks |
//! | [`date`] | the day |

pub mod advice;
pub mod date;
pub mod ranks;
pub mod threads;

use std::fmt::Write;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

pub use advice::AdviceRow;
pub use ranks::RanksRow;
pub use threads::ThreadsRow;

/// A table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Quoted<R> {
    /// Machine on which it was measured.
    pub machine: String,
    /// Day, year first.
    pub date: String,
    /// The commands that measured it.
    pub commands: Vec<String>,
    /// Why rows miss, if that is known.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub why: Vec<String>,
    /// Its rows.
    pub rows: Vec<R>,
}

/// A row of a table.
pub trait QuotedRow: Clone + Serialize + DeserializeOwned {
    /// Titles of [`QuotedRow::cells`].
    const HEADER: &'static [&'static str];

    /// The cells, error and verdict last.
    fn cells(&self) -> Vec<String>;

    /// All counters equal, and the time within the tolerance.
    fn holds(&self) -> bool;

    /// Whether both rows are of the same picture, shared in the same way.
    fn is_of_the_same(&self, other: &Self) -> bool;
}

impl<R: QuotedRow> Quoted<R> {
    /// A table without rows.
    pub fn new(machine: String) -> Self {
        Self { machine, date: String::new(), commands: Vec::new(), why: Vec::new(), rows: Vec::new() }
    }

    /// Reads a table.
    ///
    /// # Errors
    /// The text has a mistake.
    pub fn parse(text: &str) -> Result<Self, toml::de::Error> {
        toml::from_str(text)
    }

    /// The table as TOML.
    ///
    /// # Errors
    /// An error of the serializer.
    pub fn to_toml(&self) -> Result<String, toml::ser::Error> {
        toml::to_string(self)
    }

    /// Adds rows that a command measured on a day, replacing those of the same pictures. If all rows are replaced, the
    /// other commands are removed, too.
    pub fn add(&mut self, rows: Vec<R>, command: String, date: String) {
        if self.rows.iter().all(|old| rows.iter().any(|new| new.is_of_the_same(old))) {
            self.commands.clear();
        }
        for new in rows {
            match self.rows.iter_mut().find(|old| old.is_of_the_same(&new)) {
                Some(old) => *old = new,
                None => self.rows.push(new),
            }
        }
        if !self.commands.contains(&command) {
            self.commands.push(command);
        }
        self.date = date;
    }

    /// Number of rows that hold.
    pub fn holding(&self) -> usize {
        self.rows.iter().filter(|r| r.holds()).count()
    }
}

/// Rows as a table in Markdown.
pub fn markdown<R: QuotedRow>(rows: &[R]) -> String {
    let mut text = format!("| {} |\n|{}\n", R::HEADER.join(" | "), "---|".repeat(R::HEADER.len()));
    for row in rows {
        // Writing into a string cannot fail.
        let _ = writeln!(text, "| {} |", row.cells().join(" | "));
    }
    text
}

/// The table of threads in the repository.
///
/// # Errors
/// The file has a mistake.
pub fn of_threads() -> Result<Quoted<ThreadsRow>, toml::de::Error> {
    Quoted::parse(include_str!("../../../data/measured/prediction.toml"))
}

/// The table of ranks of one process in the repository.
///
/// # Errors
/// The file has a mistake.
pub fn of_ranks() -> Result<Quoted<RanksRow>, toml::de::Error> {
    Quoted::parse(include_str!("../../../data/measured/ranks.toml"))
}

/// The table of processes in the repository.
///
/// # Errors
/// The file has a mistake.
pub fn of_mpi() -> Result<Quoted<RanksRow>, toml::de::Error> {
    Quoted::parse(include_str!("../../../data/measured/mpi.toml"))
}

/// The cell of a verdict: whether a row holds, and with which tolerance.
fn verdict(holds: bool, tolerance: f64) -> String {
    format!("{} ({:.0} %)", if holds { "holds" } else { "misses" }, tolerance * 100.0)
}

/// The table of advised ways to draw in the repository.
///
/// # Errors
/// The file has a mistake.
pub fn of_advice() -> Result<Quoted<AdviceRow>, toml::de::Error> {
    Quoted::parse(include_str!("../../../data/measured/advice.toml"))
}

/// Seconds as milliseconds, rounded to a thousandth.
fn milliseconds(seconds: f64) -> f64 {
    (seconds * 1e6).round() / 1e3
}

#[cfg(test)]
mod tests;
