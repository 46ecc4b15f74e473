//! Tables as Markdown, and the raw runs behind them as JSON lines.

use std::fmt::{Display, Write as _};
use std::path::Path;

use anyhow::Result;
use serde_json::{Value, json};

/// What is written.
#[derive(Default)]
pub struct Report {
    text: String,
    raw: String,
}

/// A limit on a measured value.
#[derive(Clone, Copy)]
pub enum Bar {
    /// An upper limit.
    Most(f64),
    /// A lower limit.
    Least(f64),
}

impl Bar {
    fn holds(self, measured: f64) -> bool {
        match self {
            Self::Most(bar) => measured <= bar,
            Self::Least(bar) => measured >= bar,
        }
    }

    /// The text of the table.
    pub fn verdict(self, measured: f64) -> &'static str {
        if self.holds(measured) { "held" } else { "**not held**" }
    }
}

impl Display for Bar {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Most(bar) => write!(f, "at most {bar}"),
            Self::Least(bar) => write!(f, "at least {bar}"),
        }
    }
}

impl Report {
    /// A report that begins with a paragraph on the machine.
    pub fn new(machine: String) -> Self {
        Self { text: format!("# Measured\n\n{machine}\n"), raw: String::new() }
    }

    /// Begins a table. The first column is text, the others are numbers.
    pub fn table(&mut self, title: &str, introduction: &str, columns: &[&str]) {
        let _ = write!(self.text, "\n## {title}\n\n{introduction}\n\n");
        self.row(columns);
        let rule: Vec<_> = (0..columns.len()).map(|i| if i == 0 { "---" } else { "---:" }).collect();
        let _ = writeln!(self.text, "|{}|", rule.join("|"));
    }

    /// Adds a row to the table, and prints it as progress.
    pub fn row<T: AsRef<str>>(&mut self, cells: &[T]) {
        let cells: Vec<_> = cells.iter().map(AsRef::as_ref).collect();
        let line = format!("| {} |", cells.join(" | "));
        eprintln!("{line}");
        let _ = writeln!(self.text, "{line}");
    }

    /// Adds a row that says whether `measured` is within the limit: `what` was measured of `subject`.
    pub fn judge(&mut self, subject: &str, what: &str, measured: f64, bar: Bar) {
        let verdict = bar.verdict(measured);
        self.row(&[subject, what, &digits(measured), &bar.to_string(), verdict]);
    }

    /// Keeps a raw run.
    pub fn keep(&mut self, table: &str, subject: &str, program: &str, round: u32, run: &Value) {
        let line =
            json!({ "table": table, "subject": subject, "program": program, "round": round, "run": run });
        let _ = writeln!(self.raw, "{line}");
    }

    /// Adds a paragraph.
    pub fn note(&mut self, text: &str) {
        let _ = write!(self.text, "\n{text}\n");
    }

    /// Notes the load of the machine at the end: other programs make all times longer.
    pub fn note_load(&mut self) {
        let load = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
        let minute = load.split(' ').next().filter(|l| !l.is_empty()).unwrap_or("unknown");
        self.note(&format!("Load of the machine at the end (mean of the last minute): {minute}."));
    }

    /// The tables.
    pub fn markdown(&self) -> &str {
        &self.text
    }

    /// Writes `measured.md` and `runs.jsonl` into a folder.
    pub fn write(&self, folder: &Path) -> Result<()> {
        self.write_text(folder, "measured.md")?;
        std::fs::write(folder.join("runs.jsonl"), &self.raw)?;
        println!("written: {}/runs.jsonl", folder.display());
        Ok(())
    }

    /// Writes the tables into a file of a folder.
    pub fn write_text(&self, folder: &Path, name: &str) -> Result<()> {
        std::fs::create_dir_all(folder)?;
        std::fs::write(folder.join(name), &self.text)?;
        println!("written: {}/{name}", folder.display());
        Ok(())
    }
}

/// A number rounded to the digits that a measurement has.
pub fn digits(value: f64) -> String {
    match value.abs() {
        v if v >= 1000.0 => format!("{value:.0}"),
        v if v >= 10.0 => format!("{value:.1}"),
        v if v >= 0.1 => format!("{value:.2}"),
        _ => format!("{value:.3}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bar_divides_held_from_not_held() {
        assert_eq!(Bar::Most(0.4).verdict(0.4), "held");
        assert_eq!(Bar::Most(0.4).verdict(0.41), "**not held**");
        assert_eq!(Bar::Least(30.0).verdict(29.0), "**not held**");
        assert_eq!(Bar::Least(30.0).verdict(f64::NAN), "**not held**");
        assert_eq!(Bar::Most(30.0).verdict(f64::NAN), "**not held**");
    }
}
