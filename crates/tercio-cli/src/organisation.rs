//! `--organisation auto`: chooses how ranks share a frame, and says why.

use std::fmt::Write as _;

use anyhow::Result;
use serde_json::{Value, json};
use tercio::parallel::{Communicator, Ranks, Sharing};
use tercio::raster::Settings;
use tercio::scene::{Camera, Scene};
use tercio_lab::predict::choose::network::{Network, Source};
use tercio_lab::predict::choose::together::{Resources, choose_together};
use tercio_lab::predict::choose::{Choice, Job, MACHINE, Predicted, choose, machine, parts_of};
use tercio_lab::predict::ranks::Picture;

use crate::args::ranks::{Drawers, How};
use crate::{messages, threads};

/// Candidates that `-v` lists.
const LISTED: usize = 12;

/// The ranks of this process, if there are any, with their share of so many threads; and why they share the frame so, if that was
/// chosen.
///
/// # Errors
/// The picture cannot be drawn.
pub fn in_process(
    drawers: Drawers,
    threads: usize,
    (scene, camera, settings): (&Scene, &Camera, &Settings),
) -> Result<Option<(Ranks, Option<Choice>)>> {
    let Drawers::InProcess(count, how) = drawers else { return Ok(None) };
    let threads = (threads / count).max(1);
    let (sharing, choice) = match how {
        How::As(sharing) => (sharing, None),
        How::Auto(limits) => {
            let processors = threads::of_process();
            let network = Network::in_process(&machine()?)?;
            let job = Job { ranks: count, threads, processors, network };
            let choice = choose(&Picture { scene, camera, settings }, job, &limits)?;
            (choice.sharing(), Some(choice))
        }
    };
    Ok(Some((Ranks { count, threads, sharing }, choice)))
}

/// How the processes of a job share a frame; rank 0 also gets the reasons, if that was chosen. All of them have to call this.
///
/// # Errors
/// The processes would draw different pictures, or one is gone.
pub fn between(
    comm: &mut impl Communicator,
    how: How,
    threads: usize,
    (scene, camera, settings): (&Scene, &Camera, &Settings),
) -> Result<(Sharing, Option<Choice>)> {
    match how {
        How::As(sharing) => Ok((sharing, None)),
        How::Auto(limits) => {
            let resources = Resources { threads, processors: threads::of_job(comm.size()) };
            let picture = Picture { scene, camera, settings };
            Ok(choose_together(comm, &picture, resources, &limits)?)
        }
    }
}

/// A candidate as options.
pub fn options(sharing: &Sharing, ranks: usize) -> String {
    let (group, division, composition) = parts_of(sharing, ranks);
    let mut text = format!("--organisation {}", sharing.organisation.name());
    if let Some(group) = group {
        let _ = write!(text, " --group {group}");
    }
    if let Some(division) = division {
        let _ = write!(text, " --division {division}");
    }
    match composition {
        Some(tercio::parallel::Composition::RadixK(radix)) => {
            let _ = write!(text, " --composition radix-k --radix {radix}");
        }
        Some(composition) => {
            let _ = write!(text, " --composition {composition}");
        }
        None => {}
    }
    text
}

/// The choice, for `--stats`: times in milliseconds.
pub fn json(choice: &Choice) -> Value {
    let Choice { job, candidates, seconds, measuring, .. } = choice;
    let of_candidate = |candidate: &Predicted| {
        let terms = candidate.terms;
        let (group, division, composition) = parts_of(&candidate.sharing, job.ranks);
        json!({
            "options": options(&candidate.sharing, job.ranks),
            "organisation": candidate.sharing.organisation,
            "group": group,
            "division": division,
            "composition": composition,
            "milliseconds": terms.total() * 1e3,
            "front_end": terms.front_end * 1e3,
            "exchange": terms.exchange * 1e3,
            "draw": terms.draw * 1e3,
            "composite": terms.composite * 1e3,
            "collect": terms.collect * 1e3,
            "messages": candidate.sent.messages.round(),
            "bytes": candidate.sent.bytes.round(),
        })
    };
    json!({
        "ranks": job.ranks,
        "threads": job.threads,
        "processors": job.processors,
        "costs": { "of": MACHINE, "measured_here": false },
        "network": {
            "measured_here": job.network.source != Source::Constants,
            "latency_us": job.network.latency * 1e6,
            "bandwidth": job.network.bandwidth.is_finite().then_some(job.network.bandwidth),
        },
        "choosing_milliseconds": seconds * 1e3,
        "measuring_milliseconds": measuring * 1e3,
        "candidates": candidates.iter().map(of_candidate).collect::<Vec<_>>(),
    })
}

/// The lines of `-v`: what was chosen and why.
pub fn lines(choice: &Choice) -> Vec<String> {
    let Choice { job, candidates, seconds, measuring, .. } = choice;
    let Some(best) = candidates.first() else { return Vec::new() };
    let chosen = options(&best.sharing, job.ranks);
    let mut lines = vec![format!(
        "chose {chosen} of {} ways to share a frame, in {:.2} ms",
        candidates.len(),
        seconds * 1e3
    )];
    let network = match job.network.source {
        Source::Measured { partners } => format!(
            "messages were measured between rank 0 and {partners} other{} in {:.1} ms: {:.1} us, {:.2} GB/s",
            if partners == 1 { "" } else { "s" },
            measuring * 1e3,
            job.network.latency * 1e6,
            job.network.bandwidth * 1e-9
        ),
        Source::Constants => format!(
            "messages between threads were not measured: {:.1} us, memory is handed over",
            job.network.latency * 1e6
        ),
    };
    lines
        .push(format!("costs of work are those of the laboratory's {MACHINE}, not measured here; {network}"));
    let titles = ["predicted ms", "front end", "exchange", "draw", "composite", "collect", "MB"];
    let titles: Vec<String> = titles.map(String::from).into_iter().chain(["options".into()]).collect();
    let row = |candidate: &Predicted| {
        let terms = candidate.terms;
        let times =
            [terms.total(), terms.front_end, terms.exchange, terms.draw, terms.composite, terms.collect];
        let cells = times.map(|seconds| format!("{:.2}", seconds * 1e3)).into_iter();
        let rest = [format!("{:.2}", candidate.sent.bytes * 1e-6), options(&candidate.sharing, job.ranks)];
        cells.chain(rest).collect::<Vec<String>>()
    };
    let mut rows = vec![titles];
    rows.extend(listed(candidates).into_iter().map(row));
    let width = |column: usize| rows.iter().map(|row| row[column].len()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..rows[0].len()).map(width).collect();
    let last = widths.len() - 1;
    for row in &rows {
        let cells = row.iter().zip(&widths).take(last).map(|(cell, &width)| format!("{cell:>width$}"));
        lines.push(format!("{}  {}", cells.collect::<Vec<_>>().join("  "), row[last]));
    }
    lines
}

/// The fastest candidates, and the fastest of each other organisation.
fn listed(candidates: &[Predicted]) -> Vec<&Predicted> {
    let name = |candidate: &Predicted| candidate.sharing.organisation.name();
    let is_first = |number: usize| {
        let own = name(&candidates[number]);
        candidates[..number].iter().all(|before| name(before) != own)
    };
    let is_listed = |&number: &usize| number < LISTED || is_first(number);
    (0..candidates.len()).filter(is_listed).map(|number| &candidates[number]).collect()
}

/// Prints the lines.
pub fn print(choice: &Choice) {
    lines(choice).iter().for_each(|line| messages::note(line));
}
