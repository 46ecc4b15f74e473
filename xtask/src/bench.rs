//! `cargo xtask bench`: how fast tercio is on this machine, as a table.
//!
//! Steady-state frames (`tercio bench`), whole runs from a file to a picture, and reading. Where `../shared` is
//! absent, what needs its models is left out and said so.

use std::fmt::Write as _;
use std::io::{BufWriter, Write as _};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use anyhow::{Context as _, Result};
use serde_json::Value;

use crate::process;

#[derive(clap::Args)]
pub struct Arguments {
    /// Writes the table there, below a heading that names machine and compiler.
    #[arg(long, value_name = "FILE")]
    output: Option<PathBuf>,
}

/// Runs of a whole process, of which the median is told.
const RUNS: usize = 5;

/// Measures everything and prints the table.
///
/// # Errors
/// Something does not build or does not run.
pub fn run(arguments: &Arguments) -> Result<()> {
    process::run(process::cargo().args(["build", "--release", "--package", "tercio-cli"]))?;
    process::run(process::cargo().args([
        "build",
        "--release",
        "--package",
        "tercio-mesh",
        "--example",
        "time_read",
    ]))?;
    let release = process::target_folder()?.join("release");
    let tercio = release.join("tercio");
    let folder = tempfile::tempdir()?;

    let mut models = vec![("builtin:teapot@1M".to_owned(), 0), ("builtin:gyroid@5.4M".to_owned(), 0)];
    let binary_ply = folder.path().join("grid.ply");
    write_grid(&binary_ply)?;
    let mut files = vec![binary_ply];
    match tercio_testkit::shared_data() {
        Some(shared) => {
            let dragon = folder.path().join("dragon.ply");
            unpack(&shared.join("meshes/ply/dragon_vrip.ply.gz"), &dragon)?;
            let bunny = shared.join("meshes/obj/stanford-bunny.obj");
            models
                .extend([(&bunny, 0), (&dragon, 0), (&dragon, 2)].map(|(f, k)| (f.display().to_string(), k)));
            files.extend([dragon, bunny]);
        }
        None => eprintln!("../shared is absent: the scanned models are left out"),
    }

    let mut table = String::from(
        "| model | triangles | threads | cull | frame ms (min, max) | front end | back end | Mtri/s |\n|---|---|---|---|---|---|---|---|\n",
    );
    for (model, subdivide) in &models {
        for (threads, cull) in [("1", "auto"), ("2", "auto"), ("2", "back")] {
            let json = process::output(Command::new(&tercio).args(["bench", model, "--json", "-q"]).args([
                "--threads",
                threads,
                "--cull",
                cull,
                "--subdivide",
                &subdivide.to_string(),
            ]))?;
            let b: Value = serde_json::from_str(&json).context("reading what tercio bench wrote")?;
            let number = |v: &Value| v.as_f64().unwrap_or(f64::NAN);
            let _ = writeln!(
                table,
                "| {}{} | {} | {threads} | {cull} | {:.2} ({:.2}, {:.2}) | {:.2} | {:.2} | {:.0} |",
                short(model),
                if *subdivide > 0 { format!(" split {subdivide} times") } else { String::new() },
                b["triangles"],
                number(&b["median_ms"]),
                number(&b["min_ms"]),
                number(&b["max_ms"]),
                number(&b["stages"]["frontend"]["median_ms"]),
                number(&b["stages"]["backend"]["median_ms"]),
                number(&b["million_triangles_per_second"]),
            );
        }
    }

    table += "\n| file | MB | file to 1920x1080 PNG, s | reading alone, MB/s |\n|---|---|---|---|\n";
    for file in &files {
        let picture = folder.path().join("picture.png");
        let mut seconds = Vec::new();
        for _ in 0..RUNS {
            let begin = Instant::now();
            process::output(Command::new(&tercio).arg("render").arg(file).arg("-o").arg(&picture).args([
                "--size",
                "1920x1080",
                "-q",
            ]))?;
            seconds.push(begin.elapsed().as_secs_f64());
        }
        seconds.sort_by(f64::total_cmp);
        let said = process::output(Command::new(release.join("examples/time_read")).arg(file))?;
        let rate = said.split(" s, ").nth(1).and_then(|s| s.split(" MB/s").next()).unwrap_or("?");
        let megabytes = std::fs::metadata(file)?.len() as f64 / 1e6;
        let name = short(&file.display().to_string());
        let _ = writeln!(table, "| {name} | {megabytes:.0} | {:.3} | {rate} |", seconds[RUNS / 2]);
    }
    println!("{table}");
    if let Some(path) = &arguments.output {
        std::fs::write(path, format!("{}\n{table}", heading()?))?;
    }
    Ok(())
}

/// A model's name without its folder.
fn short(model: &str) -> String {
    Path::new(model).file_name().map_or(model.into(), |n| n.to_string_lossy().into_owned())
}

/// Machine, compiler and load, without which a table of times means nothing.
fn heading() -> Result<String> {
    let cpu = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = cpu.lines().find_map(|l| l.strip_prefix("model name")).unwrap_or(": unknown");
    let cores = std::thread::available_parallelism()?;
    let load = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    let compiler = process::output(Command::new("rustc").arg("--version"))?;
    Ok(format!(
        "Processor{model}, {cores} threads; load at the end {}; {}. Written by `cargo xtask bench --output FILE`.\n",
        load.split(' ').next().unwrap_or("?"),
        compiler.trim()
    ))
}

fn unpack(from: &Path, to: &Path) -> Result<()> {
    let mut stream = flate2::read::MultiGzDecoder::new(std::fs::File::open(from)?);
    std::io::copy(&mut stream, &mut std::fs::File::create(to)?)?;
    Ok(())
}

/// A hilly grid of five million triangles as binary PLY.
fn write_grid(path: &Path) -> Result<()> {
    const N: u32 = 1582;
    let mut file = BufWriter::new(std::fs::File::create(path)?);
    write!(
        file,
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\n\
         property float z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
        N * N,
        2 * (N - 1) * (N - 1)
    )?;
    for j in 0..N {
        for i in 0..N {
            let hill = |k: u32| ((k % 97) as f32 - 48.0).abs();
            for c in [i as f32, hill(i) + hill(j), j as f32] {
                file.write_all(&c.to_le_bytes())?;
            }
        }
    }
    for j in 0..N - 1 {
        for i in 0..N - 1 {
            let v = j * N + i;
            for t in [[v, v + N, v + 1], [v + 1, v + N, v + N + 1]] {
                file.write_all(&[3])?;
                t.iter().try_for_each(|v| file.write_all(&v.to_le_bytes()))?;
            }
        }
    }
    file.flush()?;
    Ok(())
}
