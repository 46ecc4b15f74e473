//! `tercio lab check`: recomputes every published number.

use std::fmt::Write;
use std::process::ExitCode;

use anyhow::Result;
use clap::Args;
use serde_json::{Value as Json, json};
use tercio::image::Destination;
use tercio_lab::published::{self, Agreement, Check as Checked};

use crate::output::write_text;

/// Recomputes every published number of the five documents.
#[derive(Debug, Args)]
#[command(after_help = "\
Each number is of one of four classes: it agrees with print; nothing is printed, and it agrees with an independent
computation; it contradicts print, or gives it only by a wrong equation, with our reading of why; or it is read from the
scan and not computed. A number that is none of these is unexplained. Tolerances say where they come from.

Examples:
  tercio lab check
  tercio lab check E5 H2.15
  tercio lab check --json

Exit code: 0 every number has its class, 1 some are unexplained or an error, 2 wrong usage.")]
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
        Ok(ExitCode::from(u8::from(checks.iter().any(|c| c.agreement() == Agreement::Unexplained))))
    }
}

fn json(checks: &[Checked]) -> Json {
    let one = |check: &Checked| {
        let number = &check.number;
        json!({
            "id": number.id,
            "document": number.document,
            "place": number.place,
            "unit": number.unit,
            "class": check.agreement(),
            "printed": number.printed,
            "as_printed": number.as_printed,
            "ours": check.ours.as_ref().ok().filter(|_| check.reading_error().is_none()),
            "error": check.ours.as_ref().err().map(ToString::to_string),
            "expected": number.expected,
            "tolerance": check.reading_error().is_none().then_some(number.tolerance),
            "reading_error": check.reading_error(),
            "tolerance_from": check.tolerance_source(),
            "side": number.side,
            "wrong_equation": number.wrong_equation,
            "why": number.why,
            "standing": number.standing,
            "by": number.model,
            "given": number.given,
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
        let printed = check.print().map_or_else(
            || "nothing printed".to_owned(),
            |_| format!("printed {}{unit}", check.print_text()),
        );
        // Writing into a string cannot fail.
        let _ = writeln!(
            text,
            "{:32}  {:width$}  {printed}, ours {}, tolerance {}; {}",
            check.agreement().text(),
            number.id,
            check.ours_text(&unit),
            check.tolerance_text(),
            number.model,
        );
        if let Some(why) = &number.why {
            let _ = writeln!(text, "    {why}");
        }
    }
    let numbers = if checks.len() == 1 { "number" } else { "numbers" };
    let _ = writeln!(text, "{} {numbers}:", checks.len());
    for (class, count) in published::summary(checks) {
        let _ = writeln!(text, "{count:5}  {}", class.text());
    }
    text
}
