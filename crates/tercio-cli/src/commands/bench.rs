//! `tercio bench`: measures how fast a model that turns is drawn.

use std::fmt::Write;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

use anyhow::Result;
use clap::Args;
use serde_json::{Value, json};
use tercio::glam::DVec3;
use tercio::image::Destination;
use tercio::mesh::cluster::{PartitionOptions, partition};
use tercio::mesh::{Aabb, ClusteredMesh, Mesh};
use tercio::parallel::in_process::record_frames;
use tercio::parallel::organisation::{Rank, Task};
use tercio::parallel::trace::{Span, Step, Trace, now};
use tercio::parallel::{Communicator, FrameReport, Ranks, between_processes, draw_frames};
use tercio::raster::{Frame, FrameStats, LastStage, Renderer, Settings};
use tercio::scene::{Camera, Projection, Scene};
use tercio::{LoadOptions, LoadReport, Model, Normals, TextureReport};
use tercio_lab::predict::choose::Choice;

use crate::args::bench::{Copies, LookName, StageName, StillArgs};
use crate::args::drawing::{CullName, TuningArgs};
use crate::args::ranks::{Drawers, How, RanksArgs};
use crate::args::sampling::SamplingArgs;
use crate::args::textures::{TextureArgs, TextureLimits};
use crate::args::{ModelArgs, ProgressMode, RunningArgs, values};
use crate::named_files::NamedFiles;
use crate::output::{UsageError, write_text};
use crate::progress::Display;
use crate::report::{self, camera_json, grouped};
use crate::{ending, memory, messages, mpi, organisation};

/// Measures how fast a model is drawn: loads it once, then draws views evenly round its vertical axis.
///
/// Each frame is a whole picture with smooth shading from vertex normals, finished in memory; the model fills about
/// 80 % of it.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  tercio bench builtin:gyroid@5.4M
  tercio bench dragon.ply --subdivide 2 --threads 2 --json
  mpirun -n 4 tercio bench dragon.ply --threads 1 --organisation sort-first

Exit code: 0 success, 1 error, 2 wrong usage.")]
pub struct Bench {
    #[command(flatten)]
    model: ModelArgs,
    /// Splits every triangle into four, this many times.
    #[arg(long, value_name = "K", default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=6))]
    subdivide: u32,
    /// Size of the picture in pixels.
    #[arg(short, long, value_name = "WxH", default_value = "1024x1024", value_parser = values::size)]
    size: (u32, u32),
    /// Number of views.
    #[arg(long, value_name = "N", default_value_t = 36, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    frames: u32,
    /// Which triangles to cull by their facing.
    #[arg(long, value_name = "SIDE", value_enum, default_value_t = CullName::Auto)]
    cull: CullName,
    /// Stops after a stage and discards its results, to measure what the stages up to it cost.
    #[arg(long, value_name = "STAGE", value_enum)]
    toss: Option<StageName>,
    #[command(flatten)]
    still: StillArgs,
    /// Draws this many copies of the model, in a cube with room between them.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    copies: u32,
    /// The look of the model.
    #[arg(long, value_name = "LOOK", value_enum, default_value_t = LookName::Default)]
    look: LookName,
    /// Opacity of the model, 0 to 1.
    #[arg(long, value_name = "ALPHA", default_value_t = 1.0, value_parser = values::opacity)]
    opacity: f64,
    /// Writes JSON with stable keys.
    #[arg(long)]
    json: bool,
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

/// Median, minimum and maximum of times in milliseconds.
struct Spread {
    median: f64,
    least: f64,
    most: f64,
}

impl Spread {
    fn of(frames: &[FrameStats], time: impl Fn(&FrameStats) -> f64) -> Self {
        let mut times: Vec<f64> = frames.iter().map(time).collect();
        times.sort_by(f64::total_cmp);
        Self { median: times[times.len() / 2], least: times[0], most: times[times.len() - 1] }
    }

    fn json(&self) -> Value {
        json!({ "median_ms": self.median, "min_ms": self.least, "max_ms": self.most })
    }
}

impl Bench {
    /// Runs the command.
    ///
    /// # Errors
    /// What went wrong.
    pub fn run(&self) -> Result<ExitCode> {
        self.model.check_is_no_scene()?;
        self.textures.check().and_then(|()| self.sampling.check()).map_err(|e| UsageError(e.into()))?;
        let files = self.ranks.named_files(NamedFiles::default().reads_model(&self.model.model)).prints();
        files.ready()?;
        ending::name_model(self.model.name());
        let pool = self.running.pool()?;
        let processes = mpi::processes();
        let drawers = self.ranks.drawers(processes)?;
        self.ranks.check_samples(self.sampling.sampling().pattern.count())?;
        if self.ranks.parts() {
            return Err(UsageError("--parts is for tercio render: bench loads whole models".into()).into());
        }
        let stops_early = self.toss.is_some();
        if stops_early && drawers != Drawers::Alone {
            return Err(UsageError("--toss: ranks draw whole frames".into()).into());
        }
        let text = match drawers {
            Drawers::Mpi(how) => {
                self.model.check_reaches_all(processes)?;
                let work = |comm: &mut mpi::Comm| {
                    mpi::watch(comm, self.ranks.timeout());
                    let is_first = comm.rank() == 0;
                    let draw = |scene: &Scene, cameras: &[Camera], settings: &Settings, load| {
                        draw_as_rank(comm, (scene, cameras, settings, how), load)
                    };
                    self.measure(&files, is_first, draw)
                };
                pool.install(|| mpi::run(work))?
            }
            _ => {
                let threads = pool.current_num_threads();
                let draw = |scene: &Scene, cameras: &[Camera], settings: &Settings, load| {
                    // Chosen once, for the first view.
                    match organisation::in_process(drawers, threads, (scene, &cameras[0], settings))? {
                        None => draw_alone(scene, cameras, settings, load),
                        Some((ranks, choice)) => {
                            let frames = draw_with_ranks(ranks, scene, cameras, settings, load)?;
                            Ok(Frames { choice, ..frames })
                        }
                    }
                };
                pool.install(|| self.measure(&files, true, draw))?
            }
        };
        // Only rank 0 of a job has something to report.
        if let Some(text) = text {
            write_text(&Destination::Stdout, &text)?;
        }
        Ok(ExitCode::SUCCESS)
    }

    /// Loads the model and measures; `draw` draws a frame for each camera, and gets the time of loading if it is to record. If this is not the first rank of a job, it returns
    /// nothing.
    fn measure(
        &self,
        files: &NamedFiles,
        is_first: bool,
        draw: impl FnOnce(&Scene, &[Camera], &Settings, Option<Span>) -> Result<Frames>,
    ) -> Result<Option<String>> {
        let began = self.ranks.now();
        let display = Display::new(if is_first { self.running.progress_mode() } else { ProgressMode::Never });
        let options = LoadOptions {
            memory_limit: self.running.memory_limit(),
            progress: Some(&display.progress),
            normals: Normals::FileOrMade { crease_angle: None },
            ..LoadOptions::default()
        };
        let begin = Instant::now();
        let model = options.open(&self.model.model)?;
        let load_ms = begin.elapsed().as_secs_f64() * 1e3;
        let (mut scene, report, partition_ms) = self.scene(model, files, &display)?;
        scene.instances[0].surface.opacity = self.opacity as f32;
        let textures = self.textures(&mut scene, &report, files, &display)?;
        let copies = Copies::new(self.copies, &scene.bounds());
        copies.place(&mut scene);
        let cameras = self.cameras(&scene.bounds());
        display.stage("drawing");

        let last_stage = self.toss.map_or(LastStage::Output, StageName::stage);
        let settings = Settings {
            cull: self.cull.into(),
            last_stage,
            sampling: self.sampling.sampling(),
            texture_filter: self.textures.filter(),
            ..self.tuning.settings(self.size)
        };
        let load = began.map(Span::since);
        let frames = draw(&scene, &cameras, &settings, load)?;
        drop(display);
        if let (Some(destination), Some(trace)) = (self.ranks.trace(), &frames.trace) {
            write_text(&destination, &format!("{}\n", trace.json()))?;
        }
        let loaded =
            Loaded { scene: &scene, copies: &copies, textures: textures.as_ref(), load_ms, partition_ms };
        if is_first && self.running.verbose {
            frames.choice.iter().for_each(organisation::print);
        }
        Ok(is_first.then(|| self.report(&loaded, &cameras, &frames)))
    }

    /// Loads the materials and textures of the model. Their warnings are printed: what is missing makes frames faster.
    fn textures(
        &self,
        scene: &mut Scene,
        report: &LoadReport,
        files: &NamedFiles,
        display: &Display,
    ) -> Result<Option<TextureReport>> {
        let model = scene.instances[0].mesh.memory_bytes() as u64;
        let limits = TextureLimits {
            memory: self.running.memory_limit().map(|limit| limit.saturating_sub(model) / 4 * 3),
            progress: &display.progress,
            specular: self.look.specular(),
            is_unlit: false,
        };
        let textures = self.textures.load((scene, 0), &self.model.model, report, &limits);
        if let Some(textures) = &textures {
            files.check_companions(&self.model.name(), &textures.files)?;
            let warnings = textures.warnings.iter().filter(|_| !self.running.quiet);
            warnings.for_each(|w| messages::warning(&format!("{}: {w}", self.model.name())));
        }
        Ok(textures)
    }

    /// The model in clusters, with its look, what was found in it, and the milliseconds of partitioning it.
    fn scene(&self, model: Model, files: &NamedFiles, display: &Display) -> Result<(Scene, LoadReport, f64)> {
        Ok(match model {
            Model::Mesh(loaded) => {
                files.check_companions(&self.model.name(), &loaded.report.read.companions)?;
                let mut mesh = loaded.mesh;
                for _ in 0..self.subdivide {
                    mesh = tercio::mesh::subdivide::subdivide(&mesh);
                }
                let begin = Instant::now();
                let mesh = clusters(mesh, display);
                let milliseconds = begin.elapsed().as_secs_f64() * 1e3;
                (self.look.scene(Arc::new(mesh)), loaded.report, milliseconds)
            }
            Model::Prepared(loaded) if self.subdivide == 0 => {
                (self.look.scene(loaded.mesh), loaded.report, 0.0)
            }
            _ => {
                let model = self.model.name();
                let reason =
                    "triangles of a prepared model are not split: name the model that it was made from";
                return Err(UsageError(format!("{model}: {reason}")).into());
            }
        })
    }

    /// One camera a frame.
    fn cameras(&self, bounds: &Aabb) -> Vec<Camera> {
        let still = self.still.camera(bounds, self.size);
        (0..self.frames).map(|view| still.unwrap_or_else(|| self.camera(bounds, view))).collect()
    }

    /// View number `view` of `frames`, from above the centre by a fifth of the distance.
    fn camera(&self, bounds: &Aabb, view: u32) -> Camera {
        const DISTANCE: f64 = 2.2;
        const FILL: f64 = 0.8;
        let size = bounds.size().max_element();
        let angle = f64::from(view) / f64::from(self.frames) * std::f64::consts::TAU;
        let (sin, cos) = tercio::mesh::trig::sin_cos(angle);
        let target = bounds.center();
        let eye = target + DVec3::new(sin, 0.2, cos) * (DISTANCE * size);
        // The model's largest extent, at the distance of its centre, fills this part of the shorter side.
        let shorter = f64::from(self.size.0.min(self.size.1)) / f64::from(self.size.1);
        let fov_y = 2.0 * (0.5 / (FILL * shorter) / DISTANCE).atan();
        Camera {
            eye,
            target,
            up: DVec3::Y,
            projection: Projection::Perspective { fov_y },
            near: None,
            shift: [0.0; 2],
        }
    }

    fn report(&self, loaded: &Loaded, cameras: &[Camera], frames: &Frames) -> String {
        let Frames { stats: frames, reports, choice, .. } = frames;
        let &Loaded { scene, copies, textures, load_ms, partition_ms } = loaded;
        let mesh = &scene.instances[0].mesh;
        let triangles = mesh.triangle_count() as u64 * scene.instances.len() as u64;
        let total = Spread::of(frames, |f| f.milliseconds.total);
        let front = Spread::of(frames, |f| f.milliseconds.frontend);
        let back = Spread::of(frames, |f| f.milliseconds.backend);
        let last = &frames[frames.len() - 1];
        let rate = triangles as f64 / total.median / 1e3;
        if self.json {
            let mut value = json!({
                "model": self.model.name(),
                "triangles": triangles,
                "width": self.size.0,
                "height": self.size.1,
                "frames": frames.len(),
                "threads": last.threads,
                "simd": last.simd,
                "opacity": self.opacity,
                "toss": self.toss.map(StageName::name),
                "look": self.look.name(),
                "anti_aliasing": self.sampling.json(),
                "tile_size": last.tile_size,
                "million_triangles_per_second": rate,
                "stages": { "frontend": front.json(), "backend": back.json() },
                "load_ms": load_ms,
                "partition_ms": partition_ms,
                "core_bytes_per_triangle": mesh.core_bytes() as f64 / mesh.triangle_count().max(1) as f64,
                "copies": copies.json(),
                "textures": textures.map(report::textures_json),
                "views": cameras.iter().zip(frames).map(|(c, f)| view_json(c, f)).collect::<Vec<_>>(),
                "peak_memory_bytes": memory::peak_bytes(),
                "last_frame": last,
                "last_frame_of_ranks": reports.last(),
                "choice": choice.as_ref().map(organisation::json),
            });
            if let (Value::Object(value), Value::Object(spread)) = (&mut value, total.json()) {
                value.extend(spread);
            }
            return format!("{value:#}\n");
        }
        let mut text = String::new();
        let _ = writeln!(
            text,
            "{}: {} triangles, {}x{}, {} threads, {}, tiles of {}",
            self.model.name(),
            grouped(triangles),
            self.size.0,
            self.size.1,
            last.threads,
            last.simd,
            last.tile_size
        );
        if let Some(last) = reports.last() {
            let _ = writeln!(
                text,
                "{} ranks, {}; last frame: {} messages, {} bytes",
                last.ranks.len(),
                last.organisation,
                grouped(last.messages),
                grouped(last.bytes)
            );
        }
        let _ = writeln!(text, "load {load_ms:.1} ms, partition {partition_ms:.1} ms");
        for (name, s) in [("frame", &total), ("front end", &front), ("back end", &back)] {
            let _ =
                writeln!(text, "{name:9} {:8.2} ms median {:8.2} min {:8.2} max", s.median, s.least, s.most);
        }
        let _ = writeln!(text, "{rate:.1} million triangles/s");
        text
    }
}

/// The frames that were drawn.
#[derive(Default)]
struct Frames {
    /// One a frame.
    stats: Vec<FrameStats>,
    /// Those of ranks, if there are any.
    reports: Vec<FrameReport>,
    /// Why ranks share the frames as they do, if that was chosen.
    choice: Option<Choice>,
    /// When each rank did what, with the first frame that is not measured; if it is recorded, and on rank 0.
    trace: Option<Trace>,
}

impl Frames {
    fn of_ranks(reports: Vec<FrameReport>, trace: Option<Trace>) -> Self {
        Self { stats: reports.iter().map(FrameReport::stats).collect(), reports, choice: None, trace }
    }
}

/// The cameras, the first of them twice: the first frame allocates the memory that later frames reuse.
fn with_first_frame(cameras: &[Camera]) -> Vec<Camera> {
    cameras.iter().take(1).chain(cameras).copied().collect()
}

fn draw_alone(scene: &Scene, cameras: &[Camera], settings: &Settings, load: Option<Span>) -> Result<Frames> {
    let (mut renderer, mut frame, mut frames) = (Renderer::new(), Frame::default(), Frames::default());
    frames.trace = load.map(of_loading);
    for camera in with_first_frame(cameras) {
        let begin = frames.trace.as_ref().map(|_| now());
        renderer.render_into(scene, &camera, settings, &mut frame)?;
        if let (Some(trace), Some(begin)) = (&mut frames.trace, begin) {
            trace.append(Trace::of_one(Step::Draw, Span::since(begin)));
        }
        frames.stats.push(frame.stats.clone());
    }
    frames.stats.remove(0);
    Ok(frames)
}

/// A trace of loading by the first rank, or by the process for all of its ranks.
fn of_loading(span: Span) -> Trace {
    let mut trace = Trace::default();
    trace.add(0, Step::Load, 0, span);
    trace
}

fn draw_with_ranks(
    ranks: Ranks,
    scene: &Scene,
    cameras: &[Camera],
    settings: &Settings,
    load: Option<Span>,
) -> Result<Frames> {
    let cameras = with_first_frame(cameras);
    let mut trace = load.map(of_loading);
    let mut reports = match &mut trace {
        None => draw_frames(ranks, scene, &cameras, settings, |_, _| ())?,
        Some(trace) => {
            let (reports, recorded) = record_frames(ranks, scene, &cameras, settings, |_, _| ())?;
            trace.append(recorded);
            reports
        }
    };
    reports.remove(0);
    Ok(Frames::of_ranks(reports, trace))
}

/// The frames of a rank of an MPI job, empty except on rank 0.
fn draw_as_rank(
    comm: &mut mpi::Comm,
    (scene, cameras, settings, how): (&Scene, &[Camera], &Settings, How),
    load: Option<Span>,
) -> Result<Frames> {
    let picture = (scene, &cameras[0], settings);
    let (sharing, choice) = organisation::between(comm, how, rayon::current_num_threads(), picture)?;
    let (mut own, mut frame, mut reports) = (Rank::new(), Frame::default(), Vec::new());
    if let Some(load) = load {
        own.record();
        own.record_step(Step::Load, 0, load);
    }
    for (number, camera) in with_first_frame(cameras).into_iter().enumerate() {
        let task = Task { sharing, scene, camera: &camera, settings };
        // The counts by partner of the last frame are reported; it is number `cameras.len()`.
        own.tell_partners(number == cameras.len());
        reports.extend(between_processes::draw_frame(&mut own, comm, &task, &mut frame)?);
    }
    reports.drain(..reports.len().min(1));
    let trace = if load.is_some() { between_processes::gather_trace(&mut own, comm)? } else { None };
    Ok(Frames { choice, ..Frames::of_ranks(reports, trace) })
}

/// The scene, and the time of loading and partitioning it.
struct Loaded<'a> {
    scene: &'a Scene,
    copies: &'a Copies,
    textures: Option<&'a TextureReport>,
    load_ms: f64,
    partition_ms: f64,
}

/// One frame: its camera, its time, and the number of pixels that show the model.
fn view_json(camera: &Camera, frame: &FrameStats) -> Value {
    json!({
        "camera": camera_json(camera),
        "milliseconds": frame.milliseconds.total,
        "pixels": frame.backend.pixels_visible,
    })
}

/// The mesh in clusters.
fn clusters(mesh: Mesh, display: &Display) -> ClusteredMesh {
    let options = PartitionOptions { progress: Some(&display.progress), ..Default::default() };
    partition(mesh, &options)
}
