//! `tercio lab workload`: makes a workload for the simulators, from a model or a distribution.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::Result;
use clap::{Args, ValueEnum};
use tercio::LoadOptions;
use tercio::image::Destination;
use tercio_lab::simulators::parks::figure_15;
use tercio_lab::workloads::projection::Model;
use tercio_lab::workloads::synthetic::{Distribution, Spread};
use tercio_lab::workloads::{BoxScene, MAX_SCREEN_PIXELS, PolygonScene};

use crate::args::camera::CameraArgs;
use crate::args::{RunningArgs, values};
use crate::named_files::NamedFiles;
use crate::output::{UsageError, write_text};
use crate::progress::Display;
use crate::{ending, messages};

/// Writes a workload for a machine: the boxes or the polygons that a camera sees of a model.
#[derive(Debug, Args)]
#[command(after_help = "\
Boxes are one line a triangle of the model, culled ones included, as document 000 (appendix A) writes them;
they are the input of the ring and of McManus and Beckmann. Polygons are the triangles on the screen with
their depth, for Parks and for Ortega and Hansen. Both come out of the renderer's own projection.

Examples:
  tercio lab workload builtin:teapot@10k --size 768x512 -o teapot.boxes
  tercio lab workload dragon.ply --size 512x512 --azimuth 40 -o dragon.polygons
  tercio lab workload random:10000 --size 768x512 --box 3.8x12 --deviation 30 --visible 0.67 -o made.boxes
  tercio lab workload parks:figure-15 -o runway.polygons

Exit code: 0 success, 1 error, 2 wrong usage.")]
pub struct Workload {
    /// A model as for 'tercio render'; random:COUNT for polygons of the distribution below; or parks:figure-15, the
    /// scene of document 002 rebuilt from its statistics.
    #[arg(value_name = "MODEL")]
    source: PathBuf,
    /// The file to write, - for standard output.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// The kind of workload [default: by the file's extension, .boxes or .polygons].
    #[arg(long, value_name = "KIND", value_enum)]
    format: Option<Format>,
    /// Size of the screen in pixels.
    #[arg(short, long, value_name = "WxH", default_value = "512x512", value_parser = values::size)]
    size: (u32, u32),
    #[command(flatten)]
    random: RandomArgs,
    #[command(flatten)]
    camera: CameraArgs,
    #[command(flatten)]
    running: RunningArgs,
}

/// Parameters of a random scene.
#[derive(Debug, Args)]
#[command(next_help_heading = "Random polygons")]
struct RandomArgs {
    /// The share that is visible.
    #[arg(long, value_name = "SHARE", default_value = "1", value_parser = share)]
    visible: f64,
    /// Mean width and height of a box in pixels.
    #[arg(long, value_name = "WxH", default_value = "8x8", value_parser = mean_box)]
    r#box: [f64; 2],
    /// Standard deviation round the middle column in pixels [default: uniform over the screen].
    #[arg(long, value_name = "PIXELS", value_parser = values::positive)]
    deviation: Option<f64>,
    /// Seed of the random numbers.
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
}

/// The scene of document 002.
const PARKS: &str = "parks:figure-15";
/// Prefix of the names of random scenes.
const RANDOM: &str = "random:";

/// The two kinds of workloads.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Format {
    /// Bounding boxes.
    Boxes,
    /// Screen polygons.
    Polygons,
}

/// A workload of either kind.
enum Scene {
    Boxes(BoxScene),
    Polygons(PolygonScene),
}

impl Workload {
    /// Runs the command.
    ///
    /// # Errors
    /// What went wrong.
    pub fn run(&self) -> Result<ExitCode> {
        let format = self.format()?;
        if u64::from(self.size.0) * u64::from(self.size.1) > MAX_SCREEN_PIXELS {
            return Err(UsageError(format!("--size: expected at most {MAX_SCREEN_PIXELS} pixels")).into());
        }
        let destination = Destination::from_path(&self.output);
        let files = NamedFiles::default().writes("--output", &destination);
        let files = if self.is_model() { files.reads_model(&self.source) } else { files };
        files.ready()?;
        let pool = self.running.pool()?;
        let scene = pool.install(|| self.scene(format, &files))?;
        let (text, summary) = match &scene {
            Scene::Boxes(scene) => {
                (scene.to_text(), format!("{} boxes, {} visible", scene.boxes.len(), scene.visible()))
            }
            Scene::Polygons(scene) => {
                let fronts = scene.polygons.iter().filter(|p| p.front).count();
                (scene.to_text(), format!("{} polygons, {fronts} show their front", scene.polygons.len()))
            }
        };
        write_text(&destination, &text)?;
        if self.running.verbose {
            messages::note(&summary);
        }
        Ok(ExitCode::SUCCESS)
    }

    fn format(&self) -> Result<Format, UsageError> {
        let extension = self.output.extension().and_then(|e| e.to_str());
        match (self.format, extension) {
            (Some(format), _) => Ok(format),
            (None, Some("boxes")) => Ok(Format::Boxes),
            (None, Some("polygons")) => Ok(Format::Polygons),
            _ => {
                Err(UsageError("the extension must be .boxes or .polygons, or --format name the kind".into()))
            }
        }
    }

    /// False for generated scenes.
    fn is_model(&self) -> bool {
        let made = |name: &str| name == PARKS || name.starts_with(RANDOM);
        !self.source.to_str().is_some_and(made)
    }

    fn scene(&self, format: Format, files: &NamedFiles) -> Result<Scene> {
        let name = self.source.to_str().unwrap_or_default();
        if name == PARKS {
            let scene = figure_15::scene();
            return Ok(match format {
                Format::Boxes => Scene::Boxes(scene.boxes()),
                Format::Polygons => Scene::Polygons(scene),
            });
        }
        if let Some(count) = name.strip_prefix(RANDOM) {
            let polygons = count.parse().map_err(|_| {
                UsageError(format!("expected random:COUNT with a whole number below 2^32, found '{name}'"))
            })?;
            let distribution = self.random.distribution(polygons, self.size);
            return Ok(match format {
                Format::Boxes => Scene::Boxes(distribution.boxes()),
                Format::Polygons => Scene::Polygons(distribution.triangles()),
            });
        }
        let model = self.load(&self.source, files)?;
        if self.camera.views().len() > 1 {
            return Err(UsageError("a workload has one view: give one --view".into()).into());
        }
        self.camera.check().map_err(|e| UsageError(e.into()))?;
        let camera = self.camera.camera(model.scene(), self.size);
        Ok(match format {
            Format::Boxes => Scene::Boxes(model.boxes(&camera, self.size)?),
            Format::Polygons => Scene::Polygons(model.polygons(&camera, self.size)?),
        })
    }

    fn load(&self, source: &Path, files: &NamedFiles) -> Result<Model> {
        ending::name_model(source.display().to_string());
        let display = Display::new(self.running.progress_mode());
        let options = LoadOptions {
            memory_limit: self.running.memory_limit(),
            progress: Some(&display.progress),
            ..LoadOptions::default()
        };
        let loaded = options.load_mesh(source)?;
        files.check_companions(&source.display().to_string(), &loaded.report.read.companions)?;
        Ok(Model::new(loaded.mesh))
    }
}

impl RandomArgs {
    fn distribution(&self, polygons: u32, (width, height): (u32, u32)) -> Distribution {
        let across = self.deviation.map_or(Spread::Uniform, |deviation| Spread::Normal { deviation });
        Distribution {
            width,
            height,
            polygons,
            visible: self.visible,
            size: self.r#box,
            spread: [across, Spread::Uniform],
            seed: self.seed,
        }
    }
}

fn share(text: &str) -> Result<f64, String> {
    values::number(text).ok().filter(|s| (0.0..=1.0).contains(s)).ok_or_else(|| "expected 0 to 1".into())
}

fn mean_box(text: &str) -> Result<[f64; 2], String> {
    let side = |s: &str| values::number(s).ok().filter(|&s| s >= 1.0);
    text.split_once(['x', 'X'])
        .and_then(|(w, h)| Some([side(w)?, side(h)?]))
        .ok_or_else(|| "expected WIDTHxHEIGHT, at least 1 pixel each".into())
}
