//! Frames of a model that turns: loaded once, 36 views, 1024x1024, the default look, the picture in memory each time.

use anyhow::Result;

use super::Effort;
use super::programs::{Program, Programs, THREADS};
use super::report::{Bar, Report, digits};
use super::run::{Run, Task, median, median_ms, ratio, versions};
use crate::models::Index;

/// A model and its limits.
pub struct Subject {
    title: &'static str,
    pub file: &'static str,
    /// Upper limit of the frame time of two threads, divided by that of the floor on one core.
    of_floor: f64,
    /// Lower limit of the frame time of llvmpipe, divided by tercio's.
    of_llvmpipe: f64,
    /// Large enough for two threads to share the work well.
    scales: bool,
}

pub const SUBJECTS: [Subject; 4] = [
    Subject { title: "bunny", file: "bunny.ply", of_floor: 0.8, of_llvmpipe: 8.0, scales: false },
    Subject { title: "dragon", file: "dragon.ply", of_floor: 0.2, of_llvmpipe: 30.0, scales: true },
    Subject {
        title: "dragon split twice",
        file: "dragon-split-twice.ply",
        of_floor: 0.17,
        of_llvmpipe: 50.0,
        scales: true,
    },
    Subject { title: "gyroid", file: "gyroid.ply", of_floor: 0.1, of_llvmpipe: 35.0, scales: true },
];

/// Lower limit of the speed-up of two threads over one.
const SCALING: f64 = 1.85;
/// Lower limit of the speed of the partition with two threads, million triangles a second.
const PARTITION: f64 = 30.0;
/// Upper limit of the frame time at AVX2, divided by that at AVX-512.
const AVX2: f64 = 1.7;
/// Upper limit of the bytes of positions and connectivity per triangle.
const BYTES_A_TRIANGLE: f64 = 16.0;

const TERCIO: Program = Program::Tercio { threads: THREADS, cull_back: false };
const TERCIO_CULLED: Program = Program::Tercio { threads: THREADS, cull_back: true };
const ALONE: Program = Program::Tercio { threads: 1, cull_back: false };
const ALONE_CULLED: Program = Program::Tercio { threads: 1, cull_back: true };
const LLVMPIPE: Program = Program::Llvmpipe { cull_back: false };
const LLVMPIPE_CULLED: Program = Program::Llvmpipe { cull_back: true };

/// The columns of the table, in the order of a turn.
const PROGRAMS: [Program; 10] = [
    TERCIO,
    ALONE,
    Program::TercioPlain,
    Program::TercioAvx2,
    TERCIO_CULLED,
    ALONE_CULLED,
    Program::Floor,
    LLVMPIPE,
    LLVMPIPE_CULLED,
    Program::Embree,
];

/// The turns of all programs with one model.
struct Turns<'a> {
    subject: &'a Subject,
    triangles: u64,
    programs: Vec<Program>,
    /// By program, then by turn.
    runs: Vec<Vec<Run>>,
}

/// Measures and reports.
///
/// # Errors
/// A program fails.
pub fn measure(programs: &Programs, models: &Index, effort: Effort, report: &mut Report) -> Result<()> {
    let mut all = Vec::new();
    for subject in &SUBJECTS {
        let Some(model) = models.get(subject.file) else { continue };
        let task = Task {
            title: subject.title.into(),
            model: model.path.clone(),
            size: (1024, 1024),
            frames: effort.frames,
            samples: 1,
            opacity: 1.0,
            arguments: Vec::new(),
        };
        let programs_here = programs.available(&PROGRAMS);
        let mut runs = vec![Vec::new(); programs_here.len()];
        for round in 0..effort.rounds {
            eprintln!("{}, turn {} of {}", subject.title, round + 1, effort.rounds);
            for (i, run) in programs.take_turns(&programs_here, &task)?.into_iter().enumerate() {
                report.keep("turning", subject.title, &programs_here[i].name(), round, &run.kept());
                runs[i].push(run);
            }
        }
        all.push(Turns { subject, triangles: model.triangles, programs: programs_here, runs });
    }
    if all.is_empty() {
        return Ok(());
    }
    times(&all, effort, report);
    million_triangles(&all, report);
    bars(&all, report)
}

impl Turns<'_> {
    fn of(&self, program: Program) -> Option<&[Run]> {
        let i = self.programs.iter().position(|p| *p == program)?;
        Some(&self.runs[i])
    }

    fn cells(&self, cell: impl Fn(f64) -> f64) -> Vec<String> {
        let number = |program: &Program| {
            self.of(*program).map_or_else(|| "–".into(), |turns| digits(cell(median_ms(turns))))
        };
        PROGRAMS.iter().map(number).collect()
    }
}

fn headings(first: &'static str) -> Vec<String> {
    [first, "triangles"].map(String::from).into_iter().chain(PROGRAMS.iter().map(|p| p.name())).collect()
}

fn times(all: &[Turns], effort: Effort, report: &mut Report) {
    let introduction = format!(
        "Milliseconds a frame, 1024x1024: the median of {} views, and of {} turns in which each program draws all of \
         them. All draw the same files from the same cameras; llvmpipe lights vertices, Embree and tercio pixels; the \
         floor finds the visible triangle of each pixel and shades nothing.",
        effort.frames, effort.rounds
    );
    let columns = headings("model");
    let columns: Vec<_> = columns.iter().map(String::as_str).collect();
    report.table("A model that turns", &introduction, &columns);
    for turns in all {
        let mut row = vec![turns.subject.title.to_owned(), turns.triangles.to_string()];
        row.extend(turns.cells(|ms| ms));
        report.row(&row);
    }
    if let Some(turns) = all.first() {
        report.note(&versions(&turns.programs, turns.runs.iter().filter_map(|runs| runs.first())));
    }
}

fn million_triangles(all: &[Turns], report: &mut Report) {
    let columns = headings("model");
    let columns: Vec<_> = columns.iter().map(String::as_str).collect();
    report.table("The same in million triangles a second", "Triangles of the model, seen or not.", &columns);
    for turns in all {
        let mut row = vec![turns.subject.title.to_owned(), turns.triangles.to_string()];
        row.extend(turns.cells(|ms| turns.triangles as f64 / ms / 1e3));
        report.row(&row);
    }
}

fn bars(all: &[Turns], report: &mut Report) -> Result<()> {
    let introduction = "Ratios are medians over the turns of ratios within one turn. Building Embree's tree is not \
        counted; the last rows have its time.";
    report.table("Bars", introduction, &["model", "what", "measured", "bar", ""]);
    for turns in all {
        let (title, subject) = (turns.subject.title, turns.subject);
        let (Some(ours), Some(alone)) = (turns.of(TERCIO), turns.of(ALONE)) else { continue };
        if let Some(floor) = turns.of(Program::Floor) {
            report.judge(title, "tercio / floor", ratio(ours, floor), Bar::Most(subject.of_floor));
        }
        if let Some(llvmpipe) = turns.of(LLVMPIPE) {
            report.judge(title, "llvmpipe / tercio", ratio(llvmpipe, ours), Bar::Least(subject.of_llvmpipe));
        }
        if let (Some(llvmpipe), Some(culled)) = (turns.of(LLVMPIPE_CULLED), turns.of(TERCIO_CULLED)) {
            let measured = digits(ratio(llvmpipe, culled));
            report.row(&[title, "llvmpipe / tercio, both with back faces culled", &measured, "–", ""]);
        }
        if let Some(embree) = turns.of(Program::Embree) {
            report.judge(title, "Embree / tercio", ratio(embree, ours), Bar::Least(1.0));
        }
        if let Some(avx2) = turns.of(Program::TercioAvx2) {
            report.judge(title, "AVX2 / AVX-512", ratio(avx2, ours), Bar::Most(AVX2));
        }
        if subject.scales {
            report.judge(title, "one thread / two threads", ratio(alone, ours), Bar::Least(SCALING));
            // Each run partitions the model once, whatever it then draws.
            let with_all_threads = [Some(ours), turns.of(TERCIO_CULLED)].into_iter().flatten().flatten();
            let seconds = median_of(with_all_threads, "partition_ms")? / 1e3;
            let rate = turns.triangles as f64 / seconds / 1e6;
            report.judge(title, "million triangles partitioned a second", rate, Bar::Least(PARTITION));
        }
        let bytes = median_of(ours, "core_bytes_per_triangle")?;
        report.judge(
            title,
            "bytes a triangle in memory, without attributes",
            bytes,
            Bar::Most(BYTES_A_TRIANGLE),
        );
    }
    for turns in all {
        if let Some(embree) = turns.of(Program::Embree) {
            let seconds = digits(median_of(embree, "build_ms")? / 1e3);
            report.row(&[turns.subject.title, "seconds for Embree's tree", &seconds, "–", ""]);
        }
    }
    Ok(())
}

fn median_of<'a>(turns: impl IntoIterator<Item = &'a Run>, name: &str) -> Result<f64> {
    Ok(median(turns.into_iter().map(|run| run.number(name)).collect::<Result<_>>()?))
}
