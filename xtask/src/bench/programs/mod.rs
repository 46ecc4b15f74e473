//! The programs that are compared: how they are built and run, and what they report.

mod build;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context as _, Result, bail, ensure};
use serde_json::{Value, json};
use tercio_scene::{Camera, Projection};

use super::Table;
use super::run::{Run, Task};
use crate::process;

/// A program in a column of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Program {
    /// `tercio bench` with the default look, that of `tercio render`.
    Tercio { threads: u32, cull_back: bool },
    /// `tercio bench --look plain`: one light, no highlights.
    TercioPlain,
    /// `tercio bench --simd avx2`, beside processors with AVX-512.
    TercioAvx2,
    /// The speed floor: one core, visibility only, back faces culled.
    Floor,
    /// Mesa's llvmpipe.
    Llvmpipe { cull_back: bool },
    /// Embree.
    Embree,
    /// VTK, over Mesa's llvmpipe.
    Vtk,
}

/// Threads of the rivals, and of tercio beside them.
pub const THREADS: u32 = 2;

impl Program {
    /// Its name in tables and raw runs.
    pub fn name(self) -> String {
        match self {
            Self::Tercio { threads: 1, cull_back } => format!("tercio, 1 thread{}", culled(cull_back)),
            Self::Tercio { threads, cull_back } => format!("tercio, {threads} threads{}", culled(cull_back)),
            Self::TercioPlain => format!("tercio, plain look, {THREADS} threads"),
            Self::TercioAvx2 => format!("tercio, AVX2, {THREADS} threads"),
            Self::Floor => "floor, 1 thread".into(),
            Self::Llvmpipe { cull_back } => format!("llvmpipe, {THREADS} threads{}", culled(cull_back)),
            Self::Embree => format!("Embree, {THREADS} threads"),
            Self::Vtk => format!("VTK, {THREADS} threads"),
        }
    }

    /// Whether it culls back faces, which shows where a model has holes.
    fn culls(self) -> bool {
        match self {
            Self::Tercio { cull_back, .. } | Self::Llvmpipe { cull_back } => cull_back,
            Self::Floor => true,
            Self::TercioPlain | Self::TercioAvx2 | Self::Embree | Self::Vtk => false,
        }
    }

    fn is_tercio(self) -> bool {
        matches!(self, Self::Tercio { .. } | Self::TercioPlain | Self::TercioAvx2)
    }
}

fn culled(cull_back: bool) -> &'static str {
    if cull_back { ", back faces culled" } else { "" }
}

/// The programs of this machine. For a rival that is not available, the reason, which the report prints.
pub struct Programs {
    pub tercio: PathBuf,
    floor: Result<PathBuf>,
    llvmpipe: Result<PathBuf>,
    embree: Result<PathBuf>,
    /// The Python that has VTK.
    vtk: Result<PathBuf>,
}

impl Programs {
    /// Builds those that the tables need; the rivals into `folder`. `tercio` is built unless it is given.
    ///
    /// # Errors
    /// tercio does not build.
    pub fn build(folder: &Path, tables: &[Table], tercio: Option<PathBuf>) -> Result<Self> {
        let needed = |by: &[Table]| {
            let needed = tables.iter().any(|table| by.contains(table));
            ensure!(needed, "none of the requested tables has it");
            Ok(())
        };
        let turning = &[Table::Turning];
        Ok(Self {
            tercio: tercio.map_or_else(process::tercio, Ok)?,
            floor: needed(turning).and_then(|()| build::floor(folder)),
            llvmpipe: needed(&[Table::Turning, Table::Cliffs, Table::Samples])
                .and_then(|()| build::rival(folder, "llvmpipe", &["OSMesa"])),
            vtk: needed(&[Table::Samples]).and_then(|()| build::vtk()),
            embree: needed(turning).and_then(|()| build::rival(folder, "embree", &["embree3", "pthread"])),
        })
    }

    /// Those of `programs` that this machine has.
    pub fn available(&self, programs: &[Program]) -> Vec<Program> {
        let is_there = |program: &Program| match program {
            Program::Tercio { .. } | Program::TercioPlain => true,
            Program::TercioAvx2 => self.simd().is_ok_and(|level| level == "avx512"),
            Program::Floor => self.floor.is_ok(),
            Program::Llvmpipe { .. } => self.llvmpipe.is_ok(),
            Program::Embree => self.embree.is_ok(),
            Program::Vtk => self.vtk.is_ok(),
        };
        programs.iter().copied().filter(is_there).collect()
    }

    /// The SIMD level that tercio chooses.
    pub fn simd(&self) -> Result<String> {
        let run = ["bench", "builtin:sphere@1k", "--frames", "1", "--size", "8x8", "--json", "-q"];
        let output: Value = serde_json::from_str(&process::output(Command::new(&self.tercio).args(run))?)?;
        Ok(output["simd"].as_str().context("tercio bench names no SIMD level")?.to_owned())
    }

    /// Which rivals are measured, and why others are not.
    pub fn describe_rivals(&self) -> String {
        let mut text = String::new();
        let rivals = [
            ("floor", &self.floor),
            ("llvmpipe", &self.llvmpipe),
            ("Embree", &self.embree),
            ("VTK", &self.vtk),
        ];
        for (name, rival) in rivals {
            let _ = match rival {
                Ok(_) => continue,
                Err(reason) => write!(text, "{name} was not measured: {reason:#}. "),
            };
        }
        text
    }

    /// Runs each program once on a task, and checks that all draw the same.
    ///
    /// # Errors
    /// A program fails, or draws something other than tercio does.
    pub fn take_turns(&self, programs: &[Program], task: &Task) -> Result<Vec<Run>> {
        let views = tempfile::NamedTempFile::new()?;
        let mut runs: Vec<Run> = Vec::new();
        for &program in programs {
            let run = self.run(program, task, views.path());
            let run = run.with_context(|| format!("{}: {}", task.title, program.name()))?;
            let ours =
                programs.iter().zip(&runs).find(|(p, _)| p.is_tercio() && p.culls() == program.culls());
            match ours {
                Some((_, ours)) => run
                    .check_same_picture(ours)
                    .with_context(|| format!("{}: {} draws another picture", task.title, program.name()))?,
                None if !program.is_tercio() => bail!("tercio has to draw first"),
                None => std::fs::write(views.path(), views_file(&run.output)?)?,
            }
            runs.push(run);
        }
        Ok(runs)
    }

    fn tercio_bench(&self, task: &Task, threads: u32) -> Command {
        let mut command = Command::new(&self.tercio);
        command.arg("bench").arg(&task.model).args(["--json", "--quiet"]).args(&task.arguments);
        command.args(["--aa", &task.samples.to_string()]);
        if task.opacity < 1.0 {
            command.args(["--opacity", &task.opacity.to_string()]);
        }
        command.args(["--frames", &task.frames.to_string(), "--threads", &threads.to_string()]);
        command
    }

    fn run(&self, program: Program, task: &Task, views: &Path) -> Result<Run> {
        let path = |rival: &Result<PathBuf>| rival.as_ref().ok().cloned().context("it was not built");
        let size = format!("{}x{}", task.size.0, task.size.1);
        let threads = THREADS.to_string();
        let mut command = match program {
            Program::Tercio { threads, cull_back } => {
                let mut command = self.tercio_bench(task, threads);
                command.args(["--cull", if cull_back { "back" } else { "auto" }]);
                command
            }
            Program::TercioPlain => {
                let mut command = self.tercio_bench(task, THREADS);
                command.args(["--cull", "auto", "--look", "plain"]);
                command
            }
            Program::TercioAvx2 => {
                let mut command = self.tercio_bench(task, THREADS);
                command.args(["--cull", "auto", "--simd", "avx2"]);
                command
            }
            Program::Floor => return floor(&path(&self.floor)?, task),
            Program::Llvmpipe { cull_back } => {
                let mut command = Command::new(path(&self.llvmpipe)?);
                command.arg(&task.model).arg(views).args(["--threads", &threads]);
                command.args([
                    "--samples",
                    &task.samples.to_string(),
                    "--opacity",
                    &task.opacity.to_string(),
                ]);
                command.args(cull_back.then_some("--cull"));
                command
            }
            Program::Vtk => {
                let mut command = Command::new(path(&self.vtk)?);
                command.arg(build::vtk_script()).arg(&task.model).arg(views).args(["--threads", &threads]);
                command.args([
                    "--samples",
                    &task.samples.to_string(),
                    "--opacity",
                    &task.opacity.to_string(),
                ]);
                command
            }
            Program::Embree => {
                let mut command = Command::new(path(&self.embree)?);
                command.arg(&task.model).arg(views).args(["--threads", &threads]);
                command
            }
        };
        let text = process::output(command.args(["--size", &size]))?;
        Run::of_views(serde_json::from_str(&text).context("reading its output")?)
    }
}

/// Runs the floor, which has 36 views of 1024x1024 built in: those of `tercio bench`.
fn floor(program: &Path, task: &Task) -> Result<Run> {
    const VIEWS: usize = 36;
    let output = Command::new(program).arg(&task.model).output()?;
    let text = String::from_utf8_lossy(&output.stderr);
    let after =
        |word: &str| -> Option<f64> { text.split_once(word)?.1.split_whitespace().next()?.parse().ok() };
    let times = [after("median "), after(" min "), after(" max ")];
    let ([Some(median_ms), Some(min_ms), Some(max_ms)], Some(covered)) = (times, after("} covered ")) else {
        bail!("it ended with {} and printed {}", output.status, text.trim());
    };
    let reported = json!({ "median_ms": median_ms, "min_ms": min_ms, "max_ms": max_ms, "pixels": covered });
    let pixels = if task.frames as usize == VIEWS { vec![(VIEWS - 1, covered as u64)] } else { Vec::new() };
    Ok(Run { median_ms, pixels, output: reported })
}

/// The cameras and copies in the output of `tercio bench`, in the format that the rivals read.
fn views_file(output: &Value) -> Result<String> {
    let mut text = String::new();
    let vector = |value: &Value| -> Result<glam::DVec3> {
        let numbers: [f64; 3] = serde_json::from_value(value.clone()).context("a vector of three numbers")?;
        Ok(numbers.into())
    };
    for copy in output["copies"].as_array().context("no \"copies\"")? {
        let offset = vector(copy)?;
        let _ = writeln!(text, "copy {} {} {}", offset.x, offset.y, offset.z);
    }
    for view in output["views"].as_array().context("no \"views\"")? {
        let camera = &view["camera"];
        let degrees = camera["projection"]["fov_degrees"].as_f64().context("no field of view")?;
        let projection = Projection::Perspective { fov_y: degrees.to_radians() };
        let (eye, target, up) = (vector(&camera["eye"])?, vector(&camera["target"])?, vector(&camera["up"])?);
        let basis = Camera { eye, target, up, projection, near: None, shift: [0.0; 2] }.basis()?;
        text += "view";
        for v in [eye, basis.right, basis.up, basis.forward] {
            let _ = write!(text, " {} {} {}", v.x, v.y, v.z);
        }
        let _ = writeln!(text, " {}", (degrees.to_radians() * 0.5).tan());
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cameras_become_axes() {
        let camera = json!({ "eye": [0, 0, 5], "target": [0, 0, 0], "up": [0, 1, 0],
            "projection": { "fov_degrees": 90 } });
        let output = json!({ "copies": [[1, 2, 3]], "views": [{ "camera": camera }] });
        let text = views_file(&output).unwrap();
        let numbers: Vec<f64> = text.split_whitespace().filter_map(|word| word.parse().ok()).collect();
        assert_eq!(numbers[..15], [1., 2., 3., 0., 0., 5., 1., 0., 0., 0., 1., 0., 0., 0., -1.]);
        assert!((numbers[15] - 1.0).abs() < 1e-12);
        assert!(views_file(&json!({ "copies": [], "views": [{}] })).is_err());
    }
}
