//! Shared by prediction and advice: the model, its picture, the machine.

use anyhow::Result;
use clap::{Args, ValueEnum};
use tercio::LoadOptions;
use tercio::mesh::Aabb;
use tercio::raster::{Settings, Sorting};
use tercio::scene::{Camera, Scene};
use tercio_lab::machines::{Machine, Topology, load};
use tercio_lab::predict::boxes::boxes;
use tercio_lab::predict::calibrate::prepare;
use tercio_lab::predict::counts::{self, count};
use tercio_lab::predict::frame::{knows_clusters, uncharged};
use tercio_lab::predict::ranks::Picture;
use tercio_lab::predict::validate::is_loose;
use tercio_lab::predict::views;
use tercio_lab::workloads::BoxScene;

use crate::args::drawing::SortingName;
use crate::args::{ModelArgs, ProgressMode, RunningArgs, values};
use crate::ending;
use crate::messages;
use crate::named_files::NamedFiles;
use crate::progress::Display;

/// The picture to predict.
#[derive(Debug, Args)]
pub struct PictureArgs {
    #[command(flatten)]
    pub model: ModelArgs,
    /// Size of the picture in pixels.
    #[arg(short, long, value_name = "WxH", default_value = "1024x1024", value_parser = values::size)]
    pub size: (u32, u32),
    /// Number of the view, as in 'tercio bench'.
    #[arg(long, value_name = "K", default_value_t = 0)]
    view: u32,
    /// Number of views round the model.
    #[arg(long, value_name = "N", default_value_t = 36, value_parser = clap::value_parser!(u32).range(1..))]
    views: u32,
    /// Pixels along the edge of a tile [default: the renderer's choice].
    #[arg(long, value_name = "PIXELS", value_parser = tile)]
    tile_size: Option<u32>,
    /// What is sorted into tiles [default: clusters, or triangles if the machine has no costs of clusters].
    #[arg(long, value_name = "WHAT", value_enum)]
    sorting: Option<SortingName>,
}

/// The machine to predict.
#[derive(Debug, Args)]
#[command(next_help_heading = "Machine")]
pub struct MachineArgs {
    /// A built-in machine ('tercio lab machines'), or a file, such as one from 'tercio lab calibrate'.
    #[arg(short, long, value_name = "MACHINE", default_value = "two-core-2026")]
    pub machine: String,
    /// Another network than the machine's, with the machine's bandwidth and latency.
    #[arg(long, value_name = "SHAPE", value_enum)]
    network: Option<NetworkName>,
    /// Messages go over MPI, with the costs of the machine's section mpi, instead of between threads of one process.
    #[arg(long)]
    mpi: bool,
}

/// A machine by its name, or from a file. Unless `quiet`, it is a warning if its measurement was doubtful.
///
/// # Errors
/// It does not exist, or its description has mistakes.
pub fn machine(name_or_file: &str, quiet: bool) -> Result<Machine> {
    let machine = load(name_or_file)?;
    let doubt = machine.calibration.as_ref().and_then(|calibration| calibration.doubt.as_ref());
    if let Some(why) = doubt.filter(|_| !quiet) {
        messages::warning(&format!(
            "{name_or_file}: its measurement is doubtful, predictions may be, too: {why}"
        ));
    }
    Ok(machine)
}

/// What to expect of a prediction of work that the description charges nothing for.
const TOO_LOW: &str = "the predicted times are too low, of loose triangles, of which no two share a vertex, by 25 to 43 %; \
                       descriptions by 'tercio lab calibrate' have these costs";

/// It is a warning if the description has no costs of some of a picture's work.
fn warn_of_uncharged(machine: &Machine, counted: &counts::Counted, scene: &Scene) {
    let work = uncharged(machine, &counted.frame, is_loose(scene));
    let names: Vec<_> =
        work.iter().map(|(operation, count)| format!("{} ({count} times)", operation.name())).collect();
    if !names.is_empty() {
        let names = names.join(", ");
        messages::warning(&format!("{}: no costs of work in this picture, {names}: {TOO_LOW}", machine.name));
    }
}

/// Shapes of networks.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum NetworkName {
    /// Neighbour to neighbour in a circle.
    Ring,
    /// A square grid.
    Mesh,
    /// A grid of three dimensions, each closed to a ring.
    Torus,
    /// A tree whose links double towards the root.
    FatTree,
    /// Everyone to everyone.
    Crossbar,
}

impl MachineArgs {
    /// The machine.
    ///
    /// # Errors
    /// It does not exist, its description has mistakes, or it lacks the section mpi where that was requested.
    pub fn machine(&self, quiet: bool) -> Result<Machine> {
        let machine = machine(&self.machine, quiet)?;
        Ok(if self.mpi { machine.over_mpi()? } else { machine })
    }

    /// The requested shape of network.
    pub fn topology(&self) -> Option<Topology> {
        self.network.map(Into::into)
    }
}

impl From<NetworkName> for Topology {
    fn from(name: NetworkName) -> Self {
        match name {
            NetworkName::Ring => Self::Ring,
            NetworkName::Mesh => Self::Mesh,
            NetworkName::Torus => Self::Torus,
            NetworkName::FatTree => Self::FatTree,
            NetworkName::Crossbar => Self::Crossbar,
        }
    }
}

/// A model's picture and its counts.
pub struct Counted {
    pub size: (u32, u32),
    pub tile_size: u32,
    pub counted: counts::Counted,
    scene: Scene,
    camera: Camera,
    settings: Settings,
}

impl Counted {
    /// The picture to draw.
    pub fn picture(&self) -> Picture<'_> {
        Picture { scene: &self.scene, camera: &self.camera, settings: &self.settings }
    }

    /// Its triangles as input of the simulator.
    ///
    /// # Errors
    /// The camera makes no view.
    pub fn boxes(&self) -> Result<BoxScene> {
        Ok(boxes(&self.scene, &self.camera, self.size)?)
    }
}

impl PictureArgs {
    /// Checks that standard output is open and is none of the input files.
    ///
    /// # Errors
    /// Standard output is closed or is one of the files.
    pub fn ready(&self, machine: &MachineArgs) -> Result<()> {
        NamedFiles::default().reads_model(&self.model.model).reads_machine(&machine.machine).prints().ready()
    }

    /// Loads the model and counts the picture, drawn by one process on some threads.
    ///
    /// # Errors
    /// What went wrong.
    pub fn count(&self, running: &RunningArgs, machine: &Machine, threads: usize) -> Result<Counted> {
        let printed = NamedFiles::default().prints();
        let (scene, bounds) = load_scene(&self.model, running, running.progress_mode(), &printed)?;
        let camera = views::camera(&bounds, self.size, self.view % self.views, self.views);
        let sorting = match self.sorting {
            Some(name) => name.into(),
            None if knows_clusters(machine) => Sorting::Clusters,
            None => Sorting::Triangles,
        };
        let settings =
            Settings { sorting, tile_size: self.tile_size, ..Settings::one_sample(self.size.0, self.size.1) };
        let counted = count(&scene, &camera, &settings, threads)?;
        if !running.quiet {
            warn_of_uncharged(machine, &counted, &scene);
        }
        Ok(Counted {
            size: self.size,
            tile_size: settings.tile_edge_for(threads),
            counted,
            scene,
            camera,
            settings,
        })
    }
}

/// A model under one light. No file of the model may be one of the outputs.
pub fn load_scene(
    model: &ModelArgs,
    running: &RunningArgs,
    progress: ProgressMode,
    files: &NamedFiles,
) -> Result<(Scene, Aabb)> {
    ending::name_model(model.name());
    let display = Display::new(progress);
    let options = LoadOptions {
        memory_limit: running.memory_limit(),
        progress: Some(&display.progress),
        ..LoadOptions::default()
    };
    let loaded = options.load_mesh(&model.model)?;
    files.check_companions(&model.name(), &loaded.report.read.companions)?;
    Ok(prepare(loaded.mesh))
}

fn tile(text: &str) -> Result<u32, String> {
    let known = [8, 16, 32, 64, 128];
    text.parse().ok().filter(|t| known.contains(t)).ok_or_else(|| "expected 8, 16, 32, 64 or 128".into())
}
