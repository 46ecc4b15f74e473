//! Whole processes from a file in the page cache to a PNG of 1920x1080.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

use anyhow::{Context as _, Result, ensure};
use serde_json::{Map, Value, json};
use wait4::Wait4 as _;

use super::Effort;
use super::programs::{Programs, THREADS};
use super::report::{Bar, Report, digits};
use super::run::median;
use crate::models::Index;
use crate::process;

/// A file and its limits.
pub struct Subject {
    title: &'static str,
    pub file: &'static str,
    /// Upper limit of the time in seconds.
    seconds: f64,
    /// Upper limit of the peak memory, in multiples of the file's size.
    file_sizes: Option<f64>,
    /// Whether it is drawn from a file that `tercio prepare` wrote from it, which is then what is measured.
    prepared: bool,
}

pub const SUBJECTS: [Subject; 6] = [
    Subject {
        title: "dragon split twice, binary PLY",
        file: "first/dragon-split-twice.ply",
        seconds: 0.6,
        file_sizes: Some(1.3),
        prepared: false,
    },
    Subject {
        title: "dragon split twice, prepared",
        file: "first/dragon-split-twice.ply",
        seconds: 0.12,
        file_sizes: Some(1.3),
        prepared: true,
    },
    Subject {
        title: "dragon, binary PLY",
        file: "first/dragon.ply",
        seconds: 0.15,
        file_sizes: None,
        prepared: false,
    },
    Subject {
        title: "dragon, ASCII PLY",
        file: "first/dragon-ascii.ply",
        seconds: 0.25,
        file_sizes: None,
        prepared: false,
    },
    Subject {
        title: "dragon, OBJ",
        file: "first/dragon.obj",
        seconds: 0.5,
        file_sizes: None,
        prepared: false,
    },
    Subject {
        title: "dragon, binary STL",
        file: "first/dragon.stl",
        seconds: 0.3,
        file_sizes: None,
        prepared: false,
    },
];

/// Upper limit of the share of time that writing the PNG takes.
const PNG: f64 = 0.5;
/// Runs of each file in a round, more than in the other tables: one run takes little time.
const RUNS_A_ROUND: u32 = 3;

/// Stages of `--stats`: one column each, and the JSON pointers whose milliseconds it adds up.
const STAGES: [(&str, &[&str]); 6] = [
    ("read", &["/load/milliseconds/read"]),
    ("repair", &["/load/milliseconds/clean", "/load/milliseconds/weld"]),
    ("normals", &["/load/milliseconds/normals"]),
    ("clusters", &["/load/milliseconds/partition"]),
    ("draw", &["/frame/milliseconds/total"]),
    ("PNG", &["/output_milliseconds"]),
];

/// One process.
struct Run {
    seconds: f64,
    peak_bytes: f64,
    /// Milliseconds of the [`STAGES`].
    stages: [f64; STAGES.len()],
}

/// Measures and reports.
///
/// # Errors
/// tercio fails.
pub fn measure(programs: &Programs, models: &Index, effort: Effort, report: &mut Report) -> Result<()> {
    let folder = tempfile::tempdir()?;
    let mut found: Vec<(&Subject, PathBuf, u64)> = Vec::new();
    for subject in &SUBJECTS {
        let Some(model) = models.get(subject.file) else { continue };
        if subject.prepared {
            let file = folder.path().join("model.tercio");
            let mut command = Command::new(&programs.tercio);
            process::output(command.arg("prepare").arg(&model.path).arg("-o").arg(&file))?;
            let bytes = std::fs::metadata(&file)?.len();
            found.push((subject, file, bytes));
        } else {
            found.push((subject, model.path.clone(), model.bytes));
        }
    }
    if found.is_empty() {
        return Ok(());
    }
    let mut runs: Vec<Vec<Run>> = found.iter().map(|_| Vec::new()).collect();
    for round in 0..effort.rounds * RUNS_A_ROUND {
        for ((subject, file, _), runs) in found.iter().zip(&mut runs) {
            let run = draw(&programs.tercio, file).with_context(|| subject.title)?;
            report.keep("first picture", subject.title, "tercio", round, &run.kept());
            runs.push(run);
        }
    }
    let introduction = format!(
        "Wall time of the process and its peak memory (`ru_maxrss`), medians of {} runs, {THREADS} threads; the \
         files have no normals, but that from `tercio prepare` has. The stages are those that `--stats` reports, in milliseconds.",
        effort.rounds * RUNS_A_ROUND
    );
    let columns = ["file", "MB", "seconds", "peak MB"].into_iter().chain(STAGES.map(|(name, _)| name));
    report.table("First picture", &introduction, &columns.collect::<Vec<_>>());
    for ((subject, _, bytes), runs) in found.iter().zip(&runs) {
        report.row(&row(subject, *bytes, runs));
    }
    let introduction = "OBJ may take twice as long as ASCII PLY, binary STL twice as long as binary PLY.";
    report.table("Bars of the first picture", introduction, &["file", "what", "measured", "bar", ""]);
    for ((subject, _, bytes), runs) in found.iter().zip(&runs) {
        report.judge(subject.title, "seconds", median_of(runs, |r| r.seconds), Bar::Most(subject.seconds));
        let png = |run: &Run| run.stages[STAGES.len() - 1] / run.seconds / 1e3;
        report.judge(subject.title, "part of the time that PNG takes", median_of(runs, png), Bar::Most(PNG));
        if let Some(sizes) = subject.file_sizes {
            let measured = median_of(runs, |r| r.peak_bytes) / *bytes as f64;
            report.judge(subject.title, "peak memory / size of the file", measured, Bar::Most(sizes));
        }
    }
    Ok(())
}

fn row(subject: &Subject, bytes: u64, runs: &[Run]) -> Vec<String> {
    let mut row = vec![
        subject.title.into(),
        digits(bytes as f64 / 1e6),
        format!("{:.3}", median_of(runs, |r| r.seconds)),
        digits(median_of(runs, |r| r.peak_bytes) / 1e6),
    ];
    row.extend((0..STAGES.len()).map(|stage| digits(median_of(runs, |r| r.stages[stage]))));
    row
}

impl Run {
    fn kept(&self) -> Value {
        let stages = STAGES.iter().zip(self.stages).map(|((name, _), ms)| (name.to_string(), ms.into()));
        let stages: Map<_, Value> = stages.collect();
        json!({ "seconds": self.seconds, "peak_bytes": self.peak_bytes, "stages_ms": stages })
    }
}

fn median_of(runs: &[Run], number: impl Fn(&Run) -> f64) -> f64 {
    median(runs.iter().map(number).collect())
}

/// Draws a file; the time is that of the whole process, from before its start to its end.
fn draw(tercio: &Path, file: &Path) -> Result<Run> {
    let folder = tempfile::tempdir()?;
    let (picture, stats) = (folder.path().join("picture.png"), folder.path().join("stats.json"));
    let mut command = Command::new(tercio);
    command.arg("render").arg(file).arg("-o").arg(&picture).arg("--stats").arg(&stats);
    command.args(["--size", "1920x1080", "--quiet", "--threads", &THREADS.to_string()]).stdin(Stdio::null());
    let begin = Instant::now();
    let end = command.spawn().context("starting tercio")?.wait4()?;
    let seconds = begin.elapsed().as_secs_f64();
    ensure!(end.status.success(), "tercio ended with {}", end.status);
    ensure!(std::fs::metadata(&picture)?.len() > 0, "tercio wrote no picture");
    let stats: Value = serde_json::from_str(&std::fs::read_to_string(&stats)?)?;
    let mut stages = [0.0; STAGES.len()];
    for ((name, places), milliseconds) in STAGES.iter().zip(&mut stages) {
        for place in *places {
            let time = stats.pointer(place).and_then(Value::as_f64);
            *milliseconds += time.with_context(|| format!("--stats has no {place}, for \"{name}\""))?;
        }
    }
    Ok(Run { seconds, peak_bytes: end.rusage.maxrss as f64, stages })
}
