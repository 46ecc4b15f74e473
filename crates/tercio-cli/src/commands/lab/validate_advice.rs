//! `tercio lab validate --advice`: the advised way to draw against all others, measured.

use std::fmt::Write;

use anyhow::Result;
use serde_json::{Value, json};
use tercio_lab::machines::Machine;
use tercio_lab::predict::quoted::{self, AdviceRow, QuotedRow as _};
use tercio_lab::predict::validate::Model;
use tercio_lab::predict::validate_advice::{Drawn, Options, Row, TOLERANCE, compare};

use super::measured::Measured;
use crate::progress::Display;

/// Draws all models in all ways.
///
/// # Errors
/// What went wrong.
pub fn rows(
    machine: &Machine,
    models: &[Model],
    sizes: &[(u32, u32)],
    options: Options,
    display: &Display,
) -> Result<Vec<Row>> {
    display.progress.begin("pictures", (models.len() * sizes.len() * options.rounds as usize) as u64);
    Ok(compare(machine, models, sizes, options, || display.progress.advance(1))?)
}

/// Writes the rows; returns whether all hold.
///
/// # Errors
/// What cannot be written.
pub fn write(rows: &[Row], as_json: bool, output: &Measured) -> Result<bool> {
    let quoted: Vec<AdviceRow> = rows.iter().map(AdviceRow::from).collect();
    let json = || quoted.iter().zip(rows).map(|(quoted, row)| json_of(quoted, row)).collect();
    output.write(as_json, json, || text(&quoted), &quoted)?;
    Ok(quoted.iter().all(AdviceRow::holds))
}

fn json_of(quoted: &AdviceRow, row: &Row) -> Value {
    let of_drawn = |d: &Drawn| {
        json!({
            "plan": d.candidate.describe(), "ranks": d.candidate.split.ranks, "threads": d.candidate.split.threads,
            "model": d.candidate.frame.model(), "predicted_seconds": d.candidate.frame.total(),
            "measured_seconds": d.seconds,
        })
    };
    json!({
        "row": quoted, "loss": quoted.loss(), "tolerance": TOLERANCE, "holds": quoted.holds(),
        "drawn": row.drawn.iter().map(of_drawn).collect::<Value>(),
    })
}

/// A table in Markdown, and how many rows hold.
fn text(quoted: &[AdviceRow]) -> String {
    let mut text = quoted::markdown(quoted);
    let holding = quoted.iter().filter(|row| row.holds()).count();
    // Writing into a string cannot fail.
    let _ = writeln!(
        text,
        "\nThe advised way takes at most {:.0} % longer than the fastest for {holding} of {}.",
        TOLERANCE * 100.0,
        quoted.len()
    );
    let coverages: Vec<_> = quoted.iter().filter_map(|row| row.coverage).collect();
    let _ = match &coverages[..] {
        [] => writeln!(text, "No intervals are stated: the machine's costs are not calibrated."),
        all => {
            let sum =
                |k: usize| all.iter().fold((0, 0), |(inside, of), c| (inside + c[k].inside, of + c[k].of));
            let ((counted, of_counted), (formulas, of_formulas)) = (sum(0), sum(1));
            writeln!(
                text,
                "Inside the interval stated with its prediction is the measured time of {counted} of {of_counted} ways that are \
                 counted, and of {formulas} of {of_formulas} that formulas predict."
            )
        }
    };
    text
}
