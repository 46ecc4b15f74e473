//! `tercio render`: from a model file to a picture.

mod alone;
mod bands;
mod job;
mod load;
mod picture;
mod strokes;
mod summary;
mod write;

use std::process::ExitCode;
use std::time::Instant;

use anyhow::{Result, bail};
use clap::Args;
use serde_json::Value;
use tercio::parallel::FrameReport;
use tercio::parallel::trace::Trace;
use tercio::raster::Frame;
use tercio::scene::{Background, Scene};
use tercio::{LoadReport, TextureReport};
use tercio_lab::predict::choose::Choice;

use self::strokes::Drawable;
use crate::args::camera::CameraArgs;
use crate::args::clip::ClipArgs;
use crate::args::drawing::{DrawingArgs, TuningArgs};
use crate::args::effects::EffectArgs;
use crate::args::environment::EnvironmentArgs;
use crate::args::ranks::{Drawers, RanksArgs};
use crate::args::sampling::SamplingArgs;
use crate::args::stereo::{Cameras, StereoArgs};
use crate::args::strokes::StrokeArgs;
use crate::args::textures::TextureArgs;
use crate::args::writing::WritingArgs;
use crate::args::{ModelArgs, RunningArgs};
use crate::named_files::NamedFiles;
use crate::output::{Plan, UsageError, write_text};
use crate::stereo::ViewReport;
use crate::{ending, mpi};

/// Draws a model into a picture file.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  tercio render builtin:teapot@1M -o teapot.png
  tercio render scan.ply.gz -o scan.png --size 1920x1080 --view front
  tercio render part.stl -o part.webp --up-axis z --crease-angle 40 --background transparent
  tercio render scan.ply --output-depth depth.npy --output-ids ids.npy --stats -
  tercio render scan.ply -o scan.png --stereo anaglyph
  tercio render scan.ply -o scan.png --stereo pair --eye-distance 2.5   (scan.left.png, scan.right.png)
  tercio render scan.ply -o scan.png --ranks 4 --organisation sort-last --stats -
  tercio render scan.ply -o scan.png --ranks 4 --trace trace.json   (for ui.perfetto.dev)
  mpirun -n 4 tercio render scan.ply -o scan.png --organisation sort-last   (built with --features mpi)
  mpirun -n 4 tercio render 'part_{rank}.ply' -o scan.png --parts   (no rank holds the whole model)
  zcat scan.obj.gz | tercio render - -o - | display

Colours are #rrggbb, #rgb or #rrggbbaa; the # may be left out. Files are replaced only when the new
one is whole, also if the run is interrupted; an output must not be an input. Exit code: 0 success,
1 error or nothing drawn (see --allow-empty), 2 wrong usage.")]
pub struct Render {
    #[command(flatten)]
    model: ModelArgs,
    #[command(flatten)]
    writing: WritingArgs,
    #[command(flatten)]
    camera: CameraArgs,
    #[command(flatten)]
    stereo: StereoArgs,
    #[command(flatten)]
    clip: ClipArgs,
    #[command(flatten)]
    drawing: DrawingArgs,
    #[command(flatten)]
    strokes: StrokeArgs,
    #[command(flatten)]
    environment: EnvironmentArgs,
    #[command(flatten)]
    effects: EffectArgs,
    #[command(flatten)]
    textures: TextureArgs,
    #[command(flatten)]
    sampling: SamplingArgs,
    #[command(flatten)]
    tuning: TuningArgs,
    #[command(flatten)]
    ranks: RanksArgs,
    #[command(flatten)]
    running: RunningArgs,
}

/// The outputs, and all files that the command line names.
struct Writing {
    plan: Plan,
    files: NamedFiles,
    allow_empty: bool,
}

/// A loaded model and its cameras.
struct Loaded {
    report: LoadReport,
    /// `None` if materials and textures are not used.
    textures: Option<TextureReport>,
    scene: Scene,
    drawable: Drawable,
    /// That of the picture: effects need a scene without one.
    background: Background,
    /// For `--stats`.
    look: Value,
    cameras: Cameras,
}

/// The picture of one camera.
struct Drawn {
    frame: Frame,
    /// The report of every rank, if there are ranks.
    parallel: Option<FrameReport>,
    /// Of the effects on the finished picture.
    effect_milliseconds: f64,
}

/// The results of the work, for `--stats`.
struct Done {
    report: LoadReport,
    textures: Option<TextureReport>,
    look: Value,
    cameras: Cameras,
    /// Why ranks share the frame as they do, if that was chosen.
    choice: Option<Choice>,
    /// Counts and times of every camera's picture.
    views: Vec<ViewReport>,
    /// Of the effects on the finished pictures.
    effect_milliseconds: f64,
    output_milliseconds: f64,
    /// Why nothing was drawn, if that is the case.
    empty: Option<String>,
    /// When each rank did what, if that is recorded.
    trace: Option<Trace>,
}

impl Render {
    /// Runs the command.
    ///
    /// # Errors
    /// [`UsageError`] for options that contradict each other, else what went wrong.
    pub fn run(&self) -> Result<ExitCode> {
        let start = Instant::now();
        let mut plan = self.writing.plan(&self.drawing, &self.stereo).map_err(UsageError)?;
        self.stereo.check(&self.camera, &self.drawing, &plan).map_err(UsageError)?;
        if plan.picture.is_none() && (self.effects.are_given() || self.environment.is_given()) {
            let what = "--exposure, --tone, --ao, --edl and --environment change the picture only";
            return Err(UsageError(format!("{what}, which is not written: add -o")).into());
        }
        plan.outputs = plan.outputs.with(self.effects.needed());
        let checks = [
            self.drawing.check(&self.effects, &self.environment),
            self.strokes.check(self.ranks.parts()),
            self.textures.check(),
            self.sampling.check(),
            self.environment.check(),
        ];
        checks.into_iter().collect::<Result<(), _>>().map_err(|e| UsageError(e.into()))?;
        let processes = mpi::processes();
        let files = self.ranks.named_files(plan.named_files());
        let files = self.models(processes).iter().fold(files, |files, m| files.reads_model(m));
        let files = self.environment.named_files(files);
        files.check()?;
        let writing = Writing { plan, files, allow_empty: self.writing.allow_empty };
        let mut settings = self.drawing.settings(&self.tuning, &self.sampling, writing.plan.outputs);
        if let Some(limit) = self.running.memory_limit() {
            settings.layer_memory = settings.layer_memory.min((limit / 4) as usize);
        }
        settings.texture_filter = self.textures.filter();
        settings.tone = self.effects.tone();
        settings.check().map_err(|e| UsageError(e.to_string()))?;
        let drawers = self.ranks.drawers(processes)?;
        ending::name_model(self.model.name());
        let pool = self.running.pool()?;
        let done = match drawers {
            Drawers::Mpi(how) => {
                self.model.check_reaches_all(processes)?;
                let work = |comm: &mut _| self.draw_as_rank(comm, &writing, &settings, how);
                pool.install(|| mpi::run(work))?
            }
            _ => {
                writing.files.check_places()?;
                Some(pool.install(|| self.draw(&writing, &settings, drawers))?)
            }
        };
        // Only rank 0 has something to report.
        let Some(done) = done else { return Ok(ExitCode::SUCCESS) };
        self.print_summary(&done);
        // The statistics are written, too: they show why nothing was drawn.
        if let Some(destination) = &writing.plan.stats {
            let stats = self.stats(&done, pool.current_num_threads(), start)?;
            write_text(destination, &format!("{stats:#}\n"))?;
        }
        if let (Some(destination), Some(trace)) = (self.ranks.trace(), &done.trace) {
            write_text(&destination, &format!("{}\n", trace.json()))?;
        }
        match &done.empty {
            Some(reason) if !writing.allow_empty => {
                let model = self.model.name();
                bail!("{model}: {reason}; {} (--allow-empty writes that)", writing.plan.left_out())
            }
            _ => Ok(ExitCode::SUCCESS),
        }
    }
}
