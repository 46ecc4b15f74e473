//! `tercio prepare`: processes a model once, so that it can be drawn at once from then on.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use anyhow::{Result, bail};
use clap::Args;
use tercio::image::Destination;
use tercio::{LoadOptions, Loaded, Normals};

use crate::args::{ModelArgs, RunningArgs, values};
use crate::named_files::NamedFiles;
use crate::output::write_prepared;
use crate::progress::Display;
use crate::{ending, messages, report};

/// Reads, repairs and partitions a model once, and writes its memory layout to a file.
///
/// `render`, `info` and `bench` map the file and draw at once. It has all data of the model: normals (also generated
/// ones), colours, texture coordinates, materials, attributes, face numbers. It has no lines and no points. Only the version of tercio that wrote it
/// reads it, on any little-endian machine; keep the original model.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  tercio prepare scan.ply.gz -o scan.tercio
  tercio render scan.tercio -o scan.png

Exit code: 0 success, 1 error, 2 wrong usage.")]
pub struct Prepare {
    #[command(flatten)]
    model: ModelArgs,
    /// The prepared model, usually named .tercio, or `-` for standard output.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Edges sharper than this many degrees stay sharp where normals are made; 180 smooths all
    /// [default: 30].
    #[arg(long, value_name = "DEG", allow_negative_numbers = true, value_parser = values::crease_angle)]
    crease_angle: Option<f64>,
    #[command(flatten)]
    running: RunningArgs,
}

impl Prepare {
    /// Runs the command.
    ///
    /// # Errors
    /// [`crate::output::UsageError`] for an output that is an input, else what went wrong.
    pub fn run(&self) -> Result<ExitCode> {
        self.model.check_is_no_scene()?;
        let output = Destination::from_path(&self.output);
        let files = NamedFiles::default().reads_model(&self.model.model).writes("--output", &output);
        files.ready()?;
        ending::name_model(self.model.name());
        let pool = self.running.pool()?;
        pool.install(|| self.prepare(&files, &output))?;
        Ok(ExitCode::SUCCESS)
    }

    fn prepare(&self, files: &NamedFiles, output: &Destination) -> Result<()> {
        let display = Display::new(self.running.progress_mode());
        let model = self.model.name();
        let angle = |degrees: f64| Normals::FileOrMade { crease_angle: Some(degrees.to_radians()) };
        let options = LoadOptions {
            memory_limit: self.running.memory_limit(),
            progress: Some(&display.progress),
            normals: self.crease_angle.map_or(Normals::default(), angle),
            details: true,
            ..LoadOptions::default()
        };
        let loaded = options.load_if(&self.model.model, |read| -> Result<()> {
            Ok(files.check_companions(&model, &read.companions)?)
        })?;
        if !self.running.quiet {
            for warning in report::warnings(&loaded.report) {
                messages::warning(&format!("{model}: {warning}"));
            }
            if let Some(why) = report::unused_crease_angle(self.crease_angle, &loaded.report) {
                messages::warning(&format!("{model}: {why}"));
            }
        }
        if loaded.report.mesh.triangles == 0 {
            bail!(
                "{model}: the model has no triangles, so there is nothing to prepare: {}",
                report::PREPARED
            );
        }
        if let Some(list) = report::lines_and_points(&loaded.report).filter(|_| !self.running.quiet) {
            messages::warning(&format!("{model}: left out: {list} ({})", report::PREPARED));
        }
        display.stage("writing");
        let start = Instant::now();
        write_prepared(output, &loaded, &model)?;
        if self.running.verbose {
            self.print_summary(&loaded, start);
        }
        Ok(())
    }

    fn print_summary(&self, loaded: &Loaded, start: Instant) {
        let times = &loaded.report.times;
        messages::note(&format!(
            "{} in {}; loaded in {:.1} ms, written in {:.1} ms",
            report::counted(loaded.report.mesh.triangles, "triangle"),
            report::counted(loaded.mesh.clusters().len() as u64, "cluster"),
            times.total,
            start.elapsed().as_secs_f64() * 1e3,
        ));
    }
}
