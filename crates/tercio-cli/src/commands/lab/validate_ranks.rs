//! `tercio lab validate --ranks`: what ranks count, send and take, predicted against measured.

use std::fmt::Write;

use anyhow::Result;
use serde_json::{Value, json};
use tercio::parallel::Organisation;
use tercio_lab::machines::Machine;
use tercio_lab::predict::ranks::calibrate::measure;
use tercio_lab::predict::ranks::exchange::ExchangeCosts;
use tercio_lab::predict::validate::{Model, TOLERANCE};
use tercio_lab::predict::validate_ranks::{Options, Row, StageSeconds, compare};

use crate::progress::Display;

/// What is compared.
pub struct RanksPlan<'a> {
    pub machine: &'a Machine,
    pub models: &'a [Model],
    pub sizes: &'a [(u32, u32)],
    pub ranks: &'a [usize],
    pub organisations: &'a [Organisation],
    pub options: Options,
}

/// Compares all of it. What the description does not know about ranks is measured first.
///
/// # Errors
/// What went wrong.
pub fn rows(plan: &RanksPlan, display: &Display) -> Result<Vec<Row>> {
    let costs = match ExchangeCosts::are_known(plan.machine) {
        true => ExchangeCosts::of(plan.machine)?,
        false => {
            display.stage("measuring this machine");
            measure(plan.options.frames, plan.options.rounds)?
        }
    };
    let how = plan.ranks.iter().flat_map(|&ranks| plan.organisations.iter().map(move |&o| (ranks, o)));
    let how: Vec<(usize, Organisation)> = how.collect();
    let pictures = plan.models.len() * plan.sizes.len() * how.len() * plan.options.rounds as usize;
    display.progress.begin("pictures", pictures as u64);
    let tell = || display.progress.advance(1);
    Ok(compare(plan.machine, &costs, plan.models, plan.sizes, &how, plan.options, tell)?)
}

/// With stable keys.
pub fn json(row: &Row) -> Value {
    json!({ "row": row, "error": row.error(), "tolerance": TOLERANCE, "holds": row.holds() })
}

/// A table in Markdown.
pub fn text(rows: &[Row]) -> String {
    let mut text = String::from(
        "| model | size | ranks | organisation | messages | bytes | counters equal | draw ms | compose ms | \
         collect ms | wait ms | frame ms | faults | switches | error | |\n\
         |---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n",
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
            "| {} | {}x{} | {} | {organisation} | {} | {} | {} of {} | {} | {} | {} | {} | {} | {:.0} | {:.0} | {:+.1} % | {} |",
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
            stage(|s| s.wait),
            stage(|s| s.frame),
            row.page_faults,
            row.switches,
            row.error() * 100.0,
            if row.holds() { "holds" } else { "misses" },
        );
    }
    text.push_str(
        "\nTimes: predicted / measured; a stage's is that of its busiest rank, waiting that of rank 0. Faults of pages and \
         switches of threads: of the frame in the middle, all ranks.\n",
    );
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
