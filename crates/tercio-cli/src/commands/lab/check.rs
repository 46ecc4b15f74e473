//! `tercio lab check`: recomputes every published number.

use std::fmt::Write;
use std::process::ExitCode;

use anyhow::Result;
use clap::Args;
use serde_json::{Value as Json, json};
use tercio::image::Destination;
use tercio_lab::published::{self, Check as Checked};

use crate::output::write_text;

/// Recomputes every published number of the five documents.
#[derive(Debug, Args)]
#[command(after_help = "\
A number holds if the formula or simulator it belongs to gives the expected value within the tolerance.

Examples:
  tercio lab check
  tercio lab check E5 H2.15
  tercio lab check --json

Exit code: 0 all hold, 1 some do not or an error, 2 wrong usage.")]
pub struct Check {
    /// Only numbers whose ID begins with this.
    #[arg(value_name = "ID")]
    ids: Vec<String>,
    /// Writes JSON with stable keys.
    #[arg(long)]
    json: bool,
}

impl Check {
    /// Runs the command.
    ///
    /// # Errors
    /// An ID that no number has, or an error while writing.
    pub fn run(&self) -> Result<ExitCode> {
        let all = published::check_all()?;
        if let Some(id) = self.ids.iter().find(|id| !all.iter().any(|c| c.number.id.starts_with(id.as_str())))
        {
            anyhow::bail!("no published number's name begins with '{id}'");
        }
        let is_requested = |c: &Checked| {
            self.ids.is_empty() || self.ids.iter().any(|id| c.number.id.starts_with(id.as_str()))
        };
        let checks: Vec<_> = all.into_iter().filter(is_requested).collect();
        let text = if self.json { format!("{:#}\n", json(&checks)) } else { text(&checks) };
        write_text(&Destination::Stdout, &text)?;
        Ok(ExitCode::from(u8::from(checks.iter().any(|c| !c.holds))))
    }
}

fn status(check: &Checked) -> &'static str {
    if check.holds { "holds" } else { "does not hold" }
}

fn json(checks: &[Checked]) -> Json {
    let one = |check: &Checked| {
        let number = &check.number;
        json!({
            "id": number.id,
            "document": number.document,
            "place": number.place,
            "unit": number.unit,
            "expected": number.expected,
            "ours": check.ours.as_ref().ok(),
            "error": check.ours.as_ref().err().map(ToString::to_string),
            "tolerance": number.tolerance,
            "printed": number.printed,
            "standing": number.standing,
            "basis": number.basis,
            "by": number.model,
            "given": number.given,
            "status": status(check),
        })
    };
    checks.iter().map(one).collect()
}

fn text(checks: &[Checked]) -> String {
    let width = checks.iter().map(|c| c.number.id.len()).max().unwrap_or(0);
    let mut text = String::new();
    for check in checks {
        let number = &check.number;
        let unit = number.unit.as_deref().map_or(String::new(), |u| format!(" {u}"));
        let ours = check.ours.as_ref().map_or_else(ToString::to_string, ToString::to_string);
        // Writing into a string cannot fail.
        let _ = writeln!(
            text,
            "{:13}  {:width$}  expected {}{unit}, ours {ours}{unit}, tolerance {}  ({})",
            status(check),
            number.id,
            number.expected,
            number.tolerance,
            number.model,
        );
    }
    let hold = checks.iter().filter(|c| c.holds).count();
    let read = checks.iter().filter(|c| !c.is_computed()).count();
    let _ = write!(text, "{hold} of {} hold", checks.len());
    let _ = match read {
        0 => writeln!(text),
        _ => {
            writeln!(text, "; {read} of them are tables of lost scenes, read from the scan by the cost model")
        }
    };
    text
}
