//! `cargo xtask bench`: the speed of tercio on this machine, beside that of other programs.
//!
//! Four tables: frames of a model that turns ([`turning`]), the same with several samples per pixel and with an opacity
//! ([`samples`]), whole runs from a file to a picture ([`first_picture`]), and scenes on which renderers are known to be
//! slow ([`cliffs`]). `cargo xtask bench parallel` measures ranks instead ([`parallel`]), `cargo xtask bench organisations` what
//! `--organisation auto` chooses ([`organisations`]), `cargo xtask bench primitives` what lines, points, data and annotation cost
//! ([`primitives`]), `cargo xtask bench batch` whole commands that draw many pictures, and VTK files ([`batch`]). Otherwise all programs draw the same files from the same cameras, in turns, so that
//! other load of the machine affects all of them alike, and every ratio is taken within one turn.

mod batch;
mod cliffs;
mod first_picture;
mod machine;
mod organisations;
mod parallel;
mod primitives;
mod programs;
mod ranks;
mod report;
mod run;
mod samples;
mod turning;

use std::collections::BTreeSet;
use std::path::PathBuf;

use anyhow::Result;
use clap::ValueEnum;
use tercio_testkit::workspace_root;

use crate::{models, packages};
use programs::Programs;
use report::Report;

/// Arguments of `cargo xtask bench`.
#[derive(clap::Args)]
pub struct Arguments {
    /// What to measure instead of the tables of measured.md
    #[arg(value_enum)]
    instead: Option<Instead>,
    /// Measure these tables only, and write nothing unless --output is given
    #[arg(long, value_enum, value_delimiter = ',', conflicts_with = "instead")]
    only: Vec<Table>,
    /// Turns of every program
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    rounds: u32,
    /// Views in a turn
    #[arg(long, default_value_t = 36, value_parser = clap::value_parser!(u32).range(1..=36))]
    frames: u32,
    /// The program to measure, instead of one built from this checkout
    #[arg(long, value_name = "PROGRAM")]
    tercio: Option<PathBuf>,
    /// Folder of measured.md and runs.jsonl [default: docs/performance]
    #[arg(long, value_name = "FOLDER")]
    output: Option<PathBuf>,
}

/// What is measured by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Instead {
    /// Ranks: every organisation, division and composition, written to parallel.md
    Parallel,
    /// What --organisation auto chooses, against the fastest, written to organisations.md
    Organisations,
    /// Instructions of lines, points, glyphs, data and annotation, written to primitives.md
    Primitives,
    /// Commands that draw many pictures, and VTK files, written to batch.md
    Batch,
}

/// A part of what is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Table {
    /// Frames of a model that turns
    Turning,
    /// The same with 4 samples per pixel, and with an opacity of 0.3
    Samples,
    /// Whole runs from a file to a picture
    FirstPicture,
    /// Scenes on which renderers are known to be slow
    Cliffs,
}

impl Table {
    /// The files that the table needs.
    fn files(self) -> Vec<&'static str> {
        match self {
            Self::Turning => turning::SUBJECTS.iter().map(|s| s.file).collect(),
            Self::Samples => samples::SUBJECTS.iter().map(|s| s.file).collect(),
            Self::FirstPicture => first_picture::SUBJECTS.iter().map(|s| s.file).collect(),
            Self::Cliffs => cliffs::SCENES.iter().map(|s| s.file).collect(),
        }
    }
}

/// How much is measured.
#[derive(Clone, Copy)]
struct Effort {
    rounds: u32,
    frames: u32,
}

/// Measures the tables and writes them.
///
/// # Errors
/// Something does not build or does not run, or two programs draw different pictures.
pub fn run(arguments: &Arguments) -> Result<()> {
    match arguments.instead {
        Some(Instead::Parallel) => return parallel::run(arguments),
        Some(Instead::Organisations) => return organisations::run(arguments),
        Some(Instead::Primitives) => return primitives::run(arguments),
        Some(Instead::Batch) => return batch::run(arguments),
        None => {}
    }
    packages::provide(packages::RIVALS);
    let wanted = |table: &Table| arguments.only.is_empty() || arguments.only.contains(table);
    let tables: Vec<_> = Table::value_variants().iter().copied().filter(wanted).collect();
    let folder = tempfile::tempdir()?;
    let programs = Programs::build(folder.path(), &tables, arguments.tercio.clone())?;
    // Each once, in the order of their names: tables share files.
    let files: BTreeSet<_> = tables.iter().flat_map(|table| table.files()).collect();
    let models = models::prepare(folder.path(), &Vec::from_iter(files))?;

    let mut report = Report::new(machine::describe(&programs)?);
    let effort = Effort { rounds: arguments.rounds, frames: arguments.frames };
    for table in &tables {
        match table {
            Table::Turning => turning::measure(&programs, &models, effort, &mut report)?,
            Table::Samples => samples::measure(&programs, &models, effort, &mut report)?,
            Table::FirstPicture => first_picture::measure(&programs, &models, effort, &mut report)?,
            Table::Cliffs => cliffs::measure(&programs, &models, effort, &mut report)?,
        }
    }
    report.note_load();
    println!("{}", report.markdown());
    let whole = arguments.only.is_empty().then(|| workspace_root().join("docs/performance"));
    if let Some(output) = arguments.output.clone().or(whole) {
        report.write(&output)?;
    }
    Ok(())
}
