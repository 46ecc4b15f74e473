//! Frames of a model that turns, with several samples per pixel and with surfaces that are not opaque.

use anyhow::Result;

use super::Effort;
use super::programs::{Program, Programs, THREADS};
use super::report::{Report, digits};
use super::run::{Run, Task, median_ms, ratio, versions};
use crate::models::{Index, Model};

/// A model.
pub struct Subject {
    title: &'static str,
    pub file: &'static str,
}

pub const SUBJECTS: [Subject; 2] =
    [Subject { title: "bunny", file: "bunny.ply" }, Subject { title: "dragon", file: "dragon.ply" }];

/// Samples per pixel and opacity: the rows of a model. The first one is what the others are compared with.
const LOOKS: [(u32, f64); 4] = [(1, 1.0), (4, 1.0), (1, 0.3), (4, 0.3)];

const PROGRAMS: [Program; 3] = [
    Program::Tercio { threads: THREADS, cull_back: false },
    Program::Llvmpipe { cull_back: false },
    Program::Vtk,
];

/// Upper limit of the views in a turn: depth peeling takes seconds.
const MOST_FRAMES: u32 = 6;

/// The turns of all programs with one look, by program, then by turn.
struct Row {
    samples: u32,
    opacity: f64,
    programs: Vec<Program>,
    runs: Vec<Vec<Run>>,
}

/// Measures and reports.
///
/// # Errors
/// A program fails.
pub fn measure(programs: &Programs, models: &Index, effort: Effort, report: &mut Report) -> Result<()> {
    let introduction = format!(
        "Milliseconds a frame, 1024x1024, {THREADS} threads: medians of {} views and {} turns. Of surfaces with an \
         opacity of 0.3, tercio sorts all layers at every sample, VTK peels them one by one (which it cannot with \
         several samples per pixel), and llvmpipe blends them in the order of the file, which is not the right \
         picture. In brackets: times the frame of one opaque sample of the same program, in the same turn.",
        effort.frames.min(MOST_FRAMES),
        effort.rounds
    );
    let columns =
        ["model", "samples", "opacity", "tercio", "llvmpipe", "VTK", "llvmpipe / tercio", "VTK / tercio"];
    report.table("Samples and opacity", &introduction, &columns);
    let mut rival_versions = String::new();
    for subject in &SUBJECTS {
        let Some(model) = models.get(subject.file) else { continue };
        let rows = take_turns(subject, model, programs, effort, report)?;
        for row in &rows {
            report.row(&row.cells(subject, &rows[0]));
        }
        rival_versions = versions(&rows[0].programs, rows[0].runs.iter().filter_map(|runs| runs.first()));
    }
    report.note(&rival_versions);
    Ok(())
}

/// All looks in each turn, so that they can be compared.
fn take_turns(
    subject: &Subject,
    model: &Model,
    programs: &Programs,
    effort: Effort,
    report: &mut Report,
) -> Result<Vec<Row>> {
    let mut rows = LOOKS.map(|(samples, opacity)| {
        // Depth peeling draws nothing into pixels of several samples.
        let can = |program: &Program| *program != Program::Vtk || samples == 1 || opacity == 1.0;
        let programs: Vec<_> = programs.available(&PROGRAMS).into_iter().filter(can).collect();
        let runs = vec![Vec::new(); programs.len()];
        Row { samples, opacity, programs, runs }
    });
    for round in 0..effort.rounds {
        eprintln!("{}, turn {} of {}", subject.title, round + 1, effort.rounds);
        for row in &mut rows {
            let task = Task {
                title: format!("{}, {} samples, opacity {}", subject.title, row.samples, row.opacity),
                model: model.path.clone(),
                size: (1024, 1024),
                frames: effort.frames.min(MOST_FRAMES),
                samples: row.samples,
                opacity: row.opacity,
                arguments: Vec::new(),
            };
            for (i, run) in programs.take_turns(&row.programs, &task)?.into_iter().enumerate() {
                report.keep("samples", &task.title, &row.programs[i].name(), round, &run.kept());
                row.runs[i].push(run);
            }
        }
    }
    Ok(rows.into())
}

impl Row {
    fn of(&self, program: Program) -> Option<&[Run]> {
        let i = self.programs.iter().position(|p| *p == program)?;
        Some(&self.runs[i])
    }

    fn cells(&self, subject: &Subject, plain: &Self) -> Vec<String> {
        let mut cells = vec![subject.title.into(), self.samples.to_string(), self.opacity.to_string()];
        let none = || "–".to_owned();
        cells.extend(PROGRAMS.map(|program| match (self.of(program), plain.of(program)) {
            (Some(turns), Some(plain)) => {
                format!("{} ({})", digits(median_ms(turns)), digits(ratio(turns, plain)))
            }
            _ => none(),
        }));
        let ours = self.of(PROGRAMS[0]);
        cells.extend(PROGRAMS[1..].iter().map(|rival| match (self.of(*rival), ours) {
            (Some(theirs), Some(ours)) => digits(ratio(theirs, ours)),
            _ => none(),
        }));
        cells
    }
}
