//! `tercio lab validate --ranks`: what ranks count, send and take, predicted against measured.

use std::fmt::Write;
use std::path::PathBuf;

use anyhow::Result;
use serde_json::{Value, json};
use tercio::parallel::Organisation;
use tercio_lab::machines::Machine;
use tercio_lab::predict::validate::TOLERANCE;
use tercio_lab::predict::validate_ranks::{Options, RankCosts, Row, StageSeconds, compare};

use super::plan::load_scene;
use crate::args::{ModelArgs, RunningArgs};
use crate::progress::Display;

/// What is compared.
pub struct RanksPlan<'a> {
    pub machine: &'a Machine,
    pub models: &'a [PathBuf],
    pub sizes: &'a [(u32, u32)],
    pub ranks: &'a [usize],
    pub organisations: &'a [Organisation],
    pub options: Options,
}

/// Compares all of it. Costs are fitted first.
///
/// # Errors
/// What went wrong.
pub fn rows(plan: &RanksPlan, running: &RunningArgs, display: &Display) -> Result<Vec<Row>> {
    display.stage("measuring this machine");
    let costs = RankCosts::measure(plan.options.frames)?;
    let all = plan.models.len() * plan.sizes.len() * plan.ranks.len() * plan.organisations.len();
    display.progress.begin("frames", all as u64);
    let mut rows = Vec::new();
    for model in plan.models {
        let model = ModelArgs { model: model.clone() };
        let (scene, bounds) = load_scene(&model, running)?;
        for &size in plan.sizes {
            for &ranks in plan.ranks {
                for &organisation in plan.organisations {
                    let how = (ranks, organisation);
                    let name = model.name();
                    rows.push(compare(
                        plan.machine,
                        &costs,
                        (&name, &scene, &bounds),
                        size,
                        how,
                        plan.options,
                    )?);
                    display.progress.advance(1);
                }
            }
        }
    }
    Ok(rows)
}

/// With stable keys.
pub fn json(row: &Row) -> Value {
    json!({ "row": row, "error": row.error(), "tolerance": TOLERANCE, "holds": row.holds() })
}

/// A table in Markdown.
pub fn text(rows: &[Row]) -> String {
    let mut text = String::from(
        "| model | size | ranks | organisation | messages | bytes | counters equal | draw ms | compose ms | \
         collect ms | frame ms | error | |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    for row in rows {
        let organisation = match row.organisation {
            Organisation::SortFirst => "sort-first",
            Organisation::SortLast => "sort-last",
        };
        let stage = |of: fn(&StageSeconds) -> f64| {
            format!("{:.2} / {:.2}", of(&row.predicted) * 1e3, of(&row.measured) * 1e3)
        };
        // Writing into a string cannot fail.
        let _ = writeln!(
            text,
            "| {} | {}x{} | {} | {organisation} | {} | {} | {} of {} | {} | {} | {} | {} | {:+.1} % | {} |",
            row.model,
            row.size.0,
            row.size.1,
            row.ranks,
            row.messages,
            row.bytes,
            row.compared - row.differing.len(),
            row.compared,
            stage(|s| s.draw),
            stage(|s| s.compose),
            stage(|s| s.collect),
            stage(|s| s.frame),
            row.error() * 100.0,
            if row.holds() { "holds" } else { "misses" },
        );
    }
    text.push_str("\nTimes: predicted / measured; a stage's is that of its busiest rank.\n");
    for row in rows {
        for (rank, name, ours, theirs) in &row.differing {
            let _ = writeln!(
                text,
                "\n{} {:?}, {} ranks, rank {rank}: {name} predicted {ours}, counted {theirs}",
                row.model, row.size, row.ranks
            );
        }
    }
    text
}
