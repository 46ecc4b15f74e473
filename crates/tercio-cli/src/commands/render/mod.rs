//! `tercio render`: from a model file to a picture.

mod alone;
mod annotate;
mod bands;
mod batch;
mod cameras;
mod companions;
mod job;
mod load;
pub mod members;
pub mod models;
mod picture;
mod plan;
mod series;
mod shared_colors;
mod sheet;
mod steps;
mod strokes;
mod subject;
mod summary;
mod vector;
mod watch;

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

use anyhow::{Result, bail};
use clap::Args;
use serde_json::Value;
use tercio::LoadReport;
use tercio::image::Destination;
use tercio::parallel::FrameReport;
use tercio::parallel::trace::Trace;
use tercio::raster::{Frame, Settings};
use tercio::scene::framing::Outline;
use tercio::scene::{Background, Scene};
use tercio::vector::Page;
use tercio_lab::predict::choose::Choice;

use self::annotate::Annotated;
use self::members::{ModelReport, OfModel, Placement};
use crate::args::annotation::AnnotationArgs;
use crate::args::camera::CameraArgs;
use crate::args::clip::ClipArgs;
use crate::args::data::DataArgs;
use crate::args::drawing::{DrawingArgs, TuningArgs};
use crate::args::effects::EffectArgs;
use crate::args::environment::EnvironmentArgs;
use crate::args::place::PlaceArgs;
use crate::args::ranks::{Drawers, RanksArgs};
use crate::args::sampling::SamplingArgs;
use crate::args::scene::SceneArgs;
use crate::args::series::{Motion, SeriesArgs};
use crate::args::stereo::{Cameras, StereoArgs};
use crate::args::strokes::StrokeArgs;
use crate::args::textures::TextureArgs;
use crate::args::writing::WritingArgs;
use crate::args::{ModelArgs, RunningArgs};
use crate::named_files::{FilesRead, NamedFiles};
use crate::output::write_text;
use crate::progress::Display;
use crate::scene_file::Origin;
use crate::stereo::ViewReport;
use crate::{ending, mpi};

pub use sheet::{EXAMPLES, Sheet};

use models::Models;
use plan::Writing;

/// Draws a model into a picture file.
#[derive(Clone, Debug, Args)]
#[command(after_help = "\
Examples:
  tercio render builtin:teapot@1M -o teapot.png
  tercio render scan.ply.gz -o scan.png --size 1920x1080 --view front
  tercio render part.stl -o part.webp --up-axis z --crease-angle 40 --background transparent
  tercio render scan.ply --output-depth depth.npy --output-ids ids.npy --stats -
  tercio render scan.ply -o turn.gif --turntable 90 --size 640x480
  tercio render scan.ply -o 'frame_{:04}.png' --turntable 360 --resume
  tercio render scan.ply -o '{view}.png' --view front,left,top,iso
  tercio render *.stl -o 'thumbs/{name}.png' --size 256x256
  tercio render step_*.ply -o steps.mp4 --fps 30
  tercio render run.pvd -o run.webp --color-by pressure --title 't = {time:.2f} s'
  tercio render scan.ply -o scan.png --color-by quality --colormap turbo --range 2%,98% --isolines 9
  tercio render bone.ply --color ivory --with 'skin.stl;opacity=0.3' -o both.png
  tercio render a.ply b.ply c.ply --together -o all.png --save-scene all.toml
  tercio render all.toml -o all.png   (docs/scenes.md has what a scene file may say)
  tercio render part.stl -o part.svg --mode hidden-line --edges=feature,silhouette
  tercio render scan.ply -o scan.png --stereo anaglyph
  tercio render scan.ply -o scan.png --stereo pair --eye-distance 2.5   (scan.left.png, scan.right.png)
  tercio render scan.ply -o scan.png --ranks 4 --organisation sort-last --stats -
  tercio render scan.ply -o scan.png --ranks 4 --trace trace.json   (for ui.perfetto.dev)
  mpirun -n 4 tercio render scan.ply -o scan.png --organisation sort-last   (built with --features mpi)
  mpirun -n 4 tercio render 'part_{rank}.ply' -o scan.png --parts   (no rank holds the whole model)
  zcat scan.obj.gz | tercio render - -o - | display

Colours are those of CSS: #rrggbb, #rgb or #rrggbbaa (the # may be left out), names such as steelblue,
rgb(255, 128, 0). The word render may be left out: tercio scan.ply -o scan.png. Files are replaced only when the new
one is whole, also if the run is interrupted; an output must not be an input. Exit code: 0 success,
1 error or nothing drawn (see --allow-empty), 2 wrong usage.")]
pub struct Render {
    #[command(flatten)]
    model: ModelArgs,
    /// More models: one picture each, with {name} in the output's name; or the steps of a series, with {frame} in it, or a film.
    #[arg(value_name = "MODELS")]
    more: Vec<PathBuf>,
    #[command(flatten)]
    writing: WritingArgs,
    #[command(flatten)]
    camera: CameraArgs,
    #[command(flatten)]
    series: SeriesArgs,
    #[command(flatten)]
    stereo: StereoArgs,
    #[command(flatten)]
    clip: ClipArgs,
    #[command(flatten)]
    drawing: DrawingArgs,
    #[command(flatten)]
    data: DataArgs,
    #[command(flatten)]
    strokes: StrokeArgs,
    #[command(flatten)]
    environment: EnvironmentArgs,
    #[command(flatten)]
    effects: EffectArgs,
    #[command(flatten)]
    annotation: AnnotationArgs,
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
    #[command(flatten)]
    place: PlaceArgs,
    #[command(flatten)]
    pub scene: SceneArgs,
    /// The other models of the picture. Their options of the picture are those of this one.
    #[arg(skip)]
    pub others: Vec<Self>,
    /// Further places of the model.
    #[arg(skip)]
    pub placements: Vec<Placement>,
    /// The other models of the series, which the camera frames, too.
    #[arg(skip)]
    outline: Option<Arc<Outline>>,
    /// Whether it is loaded only to measure it for the series: without textures and data.
    #[arg(skip)]
    is_measured: bool,
    /// Where the options come from, besides the command line.
    #[arg(skip)]
    pub origin: Origin,
    /// The files that were read for the pictures drawn so far.
    #[arg(skip)]
    files_read: FilesRead,
}

/// Everything that is known before a model is loaded.
struct Job {
    writing: Writing,
    motion: Motion,
    settings: Settings,
    drawers: Drawers,
}

/// Loaded models and their cameras.
struct Loaded {
    scene: Scene,
    models: Vec<OfModel>,
    /// What the camera would frame, if it was loaded to be measured.
    outline: Option<Outline>,
    /// What is said about each model.
    reports: Vec<ModelReport>,
    /// What is said about all of them together.
    together: LoadReport,
    /// That of the picture: effects need a scene without one.
    background: Background,
    /// For `--stats`.
    look: Value,
    annotated: Annotated,
    /// Those of every shot.
    cameras: Vec<Cameras>,
}

/// The picture of one camera.
struct Drawn {
    frame: Frame,
    /// The drawing, in place of a picture.
    page: Option<Page>,
    /// The report of every rank, if there are ranks.
    parallel: Option<FrameReport>,
    /// Of the effects on the finished picture.
    effect_milliseconds: f64,
}

/// What is known of a shot after it was drawn: of a picture, or of those of two eyes.
struct Shot {
    /// Its number in the series.
    number: usize,
    cameras: Cameras,
    /// Counts and times of every camera's picture.
    views: Vec<ViewReport>,
    /// Of the effects on the finished pictures.
    effect_milliseconds: f64,
    /// Why nothing was drawn, if that is the case.
    empty: Option<String>,
}

/// The results of the work, for `--stats`.
struct Done {
    models: Vec<ModelReport>,
    look: Value,
    /// Why ranks share the frame as they do, if that was chosen.
    choice: Option<Choice>,
    shots: Vec<Shot>,
    /// Shots that `--resume` found.
    found: usize,
    output_milliseconds: f64,
    /// Why nothing was written, if that is the case.
    empty: Option<String>,
    /// When each rank did what, if that is recorded.
    trace: Option<Trace>,
}

impl Render {
    /// Runs the command.
    ///
    /// # Errors
    /// Usage errors for options that contradict each other, else what went wrong.
    pub fn run(&self) -> Result<ExitCode> {
        if self.series.watch { self.watch() } else { self.run_once() }
    }

    fn run_once(&self) -> Result<ExitCode> {
        let code = match self.models()? {
            Models::One(model) => self.with_model(&model).run_one(),
            Models::Batch(models) => self.run_batch(&models),
            Models::Steps(steps) => self.run_steps(&steps),
        }?;
        if let (Some(path), Some(text)) = (&self.scene.save_scene, &self.origin.saved)
            && mpi::is_first()
        {
            write_text(&Destination::from_path(path), text)?;
        }
        Ok(code)
    }

    fn run_one(&self) -> Result<ExitCode> {
        let start = Instant::now();
        let job = self.job(&[])?;
        let mut files = self.saved_files(self.named_files(&job, NamedFiles::default()));
        files.check()?;
        if job.motion.is_series() && !matches!(job.drawers, Drawers::Mpi(_)) {
            files.make_folders()?;
        }
        let job = Job { writing: Writing { files: Arc::new(files), ..job.writing }, ..job };
        ending::name_model(self.model.name());
        let pool = self.running.pool()?;
        let done = match job.drawers {
            Drawers::Mpi(how) => {
                self.members().try_for_each(|member| member.model.check_reaches_all(mpi::processes()))?;
                let work = |comm: &mut _| self.draw_as_rank(comm, &job, how);
                pool.install(|| mpi::run(work))?
            }
            _ => {
                job.writing.files.check_places()?;
                job.writing.check_film()?;
                let display = Display::new(self.running.progress_mode());
                Some(pool.install(|| self.draw(&job, &display))?)
            }
        };
        // Only rank 0 has something to report.
        let Some(done) = done else { return Ok(ExitCode::SUCCESS) };
        self.print_summary(&done);
        self.finish(&job, &done, pool.current_num_threads(), start)?;
        Ok(ExitCode::SUCCESS)
    }

    /// Writes what is known of a run.
    ///
    /// # Errors
    /// Nothing was drawn, though it should have been.
    fn finish(&self, job: &Job, done: &Done, threads: usize, start: Instant) -> Result<()> {
        self.finish_steps(job, done, None, threads, start)
    }

    /// The same for a series of models, of which these were loaded.
    ///
    /// # Errors
    /// As [`Render::finish`].
    fn finish_steps(
        &self,
        job: &Job,
        done: &Done,
        loads: Option<Vec<Value>>,
        threads: usize,
        start: Instant,
    ) -> Result<()> {
        // The statistics are written, too: they show why nothing was drawn.
        if let Some(destination) = &job.writing.plan.stats {
            let mut stats = self.stats(job, done, threads, start)?;
            if let Some(loads) = loads {
                stats["load"] = loads.into();
            }
            write_text(destination, &format!("{stats:#}\n"))?;
        }
        if let (Some(destination), Some(trace)) = (self.ranks.trace(), &done.trace) {
            write_text(&destination, &format!("{}\n", trace.json()))?;
        }
        match &done.empty {
            Some(reason) if !job.writing.allow_empty => {
                let model = self.model.name();
                bail!("{model}: {reason}; {} (--allow-empty writes that)", job.writing.plan.left_out())
            }
            _ => Ok(()),
        }
    }
}
