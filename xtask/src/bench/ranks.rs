//! What ranks gain, and what they cost, against the program without ranks.
//!
//! Other programs only ever make a frame slower. Of each command the least of several turns is taken, and commands that are
//! compared take turns.

use std::path::Path;
use std::process::Command;

use anyhow::{Context as _, Result};

use super::Arguments;
use super::parallel::{bench, mpirun};
use super::report::{Bar, Report, digits};

/// The organisations that are measured against the program without ranks.
const ORGANISATIONS: [&str; 3] = ["sort-first", "sort-middle", "sort-last"];

/// A command that takes turns with others.
struct Turn {
    name: String,
    /// 0 for the program without MPI.
    processes: usize,
    options: String,
    /// Of the medians of all turns so far, in milliseconds.
    least: f64,
}

impl Turn {
    fn new(name: impl Into<String>, processes: usize, options: String) -> Self {
        Self { name: name.into(), processes, options, least: f64::INFINITY }
    }
}

/// Measures in turns.
fn take_turns(program: &Path, model: &str, arguments: &Arguments, turns: &mut [Turn]) -> Result<()> {
    for round in 0..arguments.rounds {
        for turn in &mut *turns {
            eprintln!("{model}, turn {} of {}: {} {}", round + 1, arguments.rounds, turn.name, turn.options);
            let command = match turn.processes {
                0 => Command::new(program),
                processes => mpirun(program, processes),
            };
            let measured = bench(command, model, &turn.options, arguments.frames)?;
            let median = measured["median_ms"].as_f64().context("tercio bench reports no median")?;
            turn.least = turn.least.min(median);
        }
    }
    Ok(())
}

/// How times are measured, for an introduction.
fn method(arguments: &Arguments) -> String {
    format!("Of the median of {} views, the least of {} turns", arguments.frames, arguments.rounds)
}

/// Two processes against one thread.
pub fn two_processes(program: &Path, arguments: &Arguments, report: &mut Report) -> Result<()> {
    // Where the real model is, it is the one that the aims are for.
    let dragon = tercio_testkit::shared_data().map(|data| data.join("meshes/ply/dragon_vrip.ply.gz"));
    let dragon = dragon.filter(|path| path.is_file()).map(|path| path.display().to_string());
    let (title, model, split) = match &dragon {
        Some(path) => ("dragon split twice", path.as_str(), "--subdivide 2"),
        None => ("builtin:teapot@13.9M", "builtin:teapot@13.9M", ""),
    };
    let introduction = format!(
        "{title}, 1024x1024: two processes of mpirun, one thread each, bound to processors of their own, and one process with two \
         threads, against one thread without ranks. {}.",
        method(arguments)
    );
    report.table("Two processes", &introduction, &["samples", "organisation", "times as fast", "bar", ""]);
    for samples in [1, 4] {
        let options = format!("{split} --aa {samples}");
        let one_thread = format!("{options} --threads 1");
        let mut turns = vec![
            Turn::new("one thread", 0, one_thread.clone()),
            Turn::new("two threads, no ranks", 0, format!("{options} --threads 2")),
        ];
        let with = |name: &&str| Turn::new(*name, 2, format!("{one_thread} --organisation {name}"));
        turns.extend(ORGANISATIONS.iter().map(with));
        take_turns(program, model, arguments, &mut turns)?;
        for turn in &turns[1..] {
            let ratio = turns[0].least / turn.least;
            report.judge(&samples.to_string(), &turn.name, ratio, Bar::Least(1.7));
        }
    }
    Ok(())
}

/// What ranks cost where they can gain nothing: a rank alone, and a picture of almost nothing.
pub fn overhead(program: &Path, arguments: &Arguments, report: &mut Report) -> Result<()> {
    let introduction = format!("Times the time without ranks, with as many threads. {}.", method(arguments));
    report.table("Cost of ranks", &introduction, &["what", "organisation", "times as long", "bar", ""]);
    let cases = [
        ("one rank, 1024x1024, 1 sample", "builtin:teapot@1M", "--aa 1 --threads 1", 1, 1.05),
        ("one rank, 1024x1024, 4 samples", "builtin:teapot@1M", "--aa 4 --threads 1", 1, 1.05),
        // The sphere is 24 pixels wide.
        (
            "two ranks, 4096x4096, almost empty, 1 sample",
            "builtin:sphere@100k",
            "--aa 1 --size 4096x4096 --fov 20 --eye 0,0,1000",
            2,
            1.2,
        ),
        (
            "two ranks, 4096x4096, almost empty, 4 samples",
            "builtin:sphere@100k",
            "--aa 4 --size 4096x4096 --fov 20 --eye 0,0,1000",
            2,
            1.2,
        ),
    ];
    for (title, model, options, ranks, bar) in cases {
        let mut turns = vec![Turn::new("without ranks", 0, options.to_owned())];
        let with =
            |name: &&str| Turn::new(*name, 0, format!("{options} --ranks {ranks} --organisation {name}"));
        turns.extend(ORGANISATIONS.iter().map(with));
        take_turns(program, model, arguments, &mut turns)?;
        for turn in &turns[1..] {
            report.judge(title, &turn.name, turn.least / turns[0].least, Bar::Most(bar));
        }
    }
    Ok(())
}

/// What sort-last costs as the model covers more of the picture.
pub fn active_pixels(program: &Path, arguments: &Arguments, report: &mut Report) -> Result<()> {
    let introduction = format!(
        "`builtin:sphere@100k`, 2048x2048, 1 sample, 4 ranks of one process, sort-last, from nearer and nearer: of all ranks together, \
         pixels that they drew and bytes that they sent, of the last frame. {}.",
        method(arguments)
    );
    let columns = ["eye", "pixels", "kilobytes", "bytes per pixel", "without ranks, ms", "sort-last, ms"];
    report.table("Active pixels", &introduction, &columns);
    let model = "builtin:sphere@100k";
    for distance in [256, 64, 32, 16, 8, 4] {
        let options = format!("--aa 1 --size 2048x2048 --fov 30 --eye 0,0,{distance}");
        let with_ranks = format!("{options} --ranks 4 --organisation sort-last");
        let mut turns =
            [Turn::new("without ranks", 0, options.clone()), Turn::new("sort-last", 0, with_ranks.clone())];
        take_turns(program, model, arguments, &mut turns)?;
        let measured = bench(Command::new(program), model, &with_ranks, 1)?;
        let last = &measured["last_frame_of_ranks"];
        let bytes = last["bytes"].as_f64().context("tercio bench reports no bytes")?;
        let ranks = last["ranks"].as_array().context("tercio bench reports no ranks")?;
        let pixels: f64 =
            ranks.iter().filter_map(|rank| rank["frame"]["backend"]["pixels_visible"].as_f64()).sum();
        report.row(&[
            distance.to_string(),
            digits(pixels),
            digits(bytes / 1e3),
            digits(bytes / pixels),
            digits(turns[0].least),
            digits(turns[1].least),
        ]);
    }
    Ok(())
}
