//! `tercio render`: from a model file to a picture.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use anyhow::{Context, Result, bail};
use clap::Args;
use serde_json::{Value, json};
use tercio::mesh::io::ReadReport;
use tercio::parallel::organisation::{Rank, Task};
use tercio::parallel::parts::share_materials;
use tercio::parallel::trace::{Span, Step, Trace};
use tercio::parallel::{Communicator, FrameReport, between_processes, in_process};
use tercio::raster::frame::fragments::fragment_bytes;
use tercio::raster::{Frame, FrameStats, Outputs, Renderer, Settings};
use tercio::scene::{Background, Camera, Scene};
use tercio::{LoadOptions, LoadReport, LoadedPart, TextureReport, band_bytes, parts, write_png_in_bands};
use tercio_lab::predict::choose::Choice;

use crate::args::camera::CameraArgs;
use crate::args::clip::ClipArgs;
use crate::args::drawing::{DrawingArgs, TuningArgs};
use crate::args::effects::EffectArgs;
use crate::args::environment::EnvironmentArgs;
use crate::args::ranks::{Drawers, How, RanksArgs};
use crate::args::sampling::SamplingArgs;
use crate::args::stereo::{Cameras, StereoArgs};
use crate::args::textures::{TextureArgs, TextureLimits};
use crate::args::writing::WritingArgs;
use crate::args::{ModelArgs, ProgressMode, RunningArgs};
use crate::named_files::NamedFiles;
use crate::output::{Plan, UsageError, frame_bytes, write_text};
use crate::progress::Display;
use crate::stereo::{self, ViewReport};
use crate::{ending, memory, messages, mpi, nothing_drawn, organisation, report};

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

    fn draw(&self, writing: &Writing, settings: &Settings, drawers: Drawers) -> Result<Done> {
        let display = Display::new(self.running.progress_mode());
        let begin = self.ranks.now();
        let loaded = self.load(writing, &display, drawers, None::<&mut mpi::Comm>)?;
        let mut trace = begin.map(|begin| {
            let mut trace = Trace::default();
            trace.add(0, Step::Load, 0, Span::since(begin));
            trace
        });
        if self.is_in_bands(&writing.plan, drawers) {
            return self.draw_in_bands(writing, settings, loaded, &display, trace);
        }
        let (mut drawn, mut choice, mut drawers) = (Vec::new(), None, drawers);
        for camera in &loaded.cameras.views {
            let none = None::<&mut mpi::Comm>;
            let settings = &self.with_shadows(settings, &loaded.scene, camera, &display, none)?;
            display.stage("drawing");
            let (mut frame, parallel, chosen) = self
                .frame(&loaded.scene, camera, settings, drawers, &mut trace)
                .with_context(|| self.model.name())?;
            if let (Some(chosen), Drawers::InProcess(count, _)) = (chosen, drawers) {
                // The second eye sees almost the same.
                drawers = Drawers::InProcess(count, How::As(chosen.sharing()));
                choice = Some(chosen);
            }
            let effect_milliseconds = self.add_effects(&mut frame, &loaded, camera, settings)?;
            drawn.push(Drawn { frame, parallel, effect_milliseconds });
        }
        display.stage("writing");
        self.write(writing, loaded, drawn, choice, trace)
    }

    /// Settings with the shadows of the scene's lights, if they are requested. Every rank draws the same ones; if there are `parts`,
    /// the ranks that have the others, those of its own.
    fn with_shadows(
        &self,
        settings: &Settings,
        scene: &Scene,
        camera: &Camera,
        display: &Display,
        parts: Option<&mut impl Communicator>,
    ) -> Result<Settings> {
        display.stage("drawing shadows");
        let name = || self.model.name();
        let shadows = match parts {
            None => self.drawing.shadows(scene, camera, settings).with_context(name)?,
            Some(comm) => self.drawing.shadows_of_parts(comm, scene, camera, settings).with_context(name)?,
        };
        Ok(Settings { shadows, ..settings.clone() })
    }

    /// Applies the effects that are requested; returns the milliseconds that they took.
    fn add_effects(
        &self,
        frame: &mut Frame,
        loaded: &Loaded,
        camera: &Camera,
        settings: &Settings,
    ) -> Result<f64> {
        let begin = Instant::now();
        let added = self.effects.apply(frame, &loaded.scene, camera, settings, &loaded.background);
        added.with_context(|| self.model.name())?;
        Ok(begin.elapsed().as_secs_f64() * 1e3)
    }

    /// Whether the picture is drawn in bands, because it is too large to be kept in memory.
    fn is_in_bands(&self, plan: &Plan, drawers: Drawers) -> bool {
        drawers == Drawers::Alone && self.stereo.layout().is_none() && plan.is_in_bands(self.drawing.size)
    }

    fn draw_in_bands(
        &self,
        writing: &Writing,
        settings: &Settings,
        loaded: Loaded,
        display: &Display,
        mut trace: Option<Trace>,
    ) -> Result<Done> {
        let Loaded { report, textures, scene, look, cameras, .. } = loaded;
        let camera = &cameras.middle;
        let settings = &self.with_shadows(settings, &scene, camera, display, None::<&mut mpi::Comm>)?;
        let (begin, began) = (Instant::now(), self.ranks.now());
        let (progress, allow_empty) = (Some(&*display.progress), writing.allow_empty);
        let stats = writing.plan.write_drawn(&self.model.name(), allow_empty, |out| {
            write_png_in_bands(&scene, camera, settings, allow_empty, progress, out)
        })?;
        let all = begin.elapsed().as_secs_f64() * 1e3;
        if let (Some(trace), Some(began)) = (&mut trace, began) {
            trace.add(0, Step::Draw, 1, Span::since(began));
        }
        let output_milliseconds = (all - stats.milliseconds.total).max(0.0);
        let empty = self.reason(&report, camera, &stats);
        let views = vec![ViewReport { stats, parallel: None }];
        let (effect_milliseconds, choice) = (0.0, None);
        Ok(Done {
            report,
            textures,
            look,
            cameras,
            choice,
            views,
            effect_milliseconds,
            output_milliseconds,
            empty,
            trace,
        })
    }

    /// Why nothing was drawn, if that is the case.
    fn reason(&self, report: &LoadReport, camera: &Camera, stats: &FrameStats) -> Option<String> {
        if let Some(reason) = report::all_clipped(report) {
            return Some(reason);
        }
        let empty = nothing_drawn::reason(&report.mesh.bounds, camera, self.drawing.cull(), stats);
        empty.map(|reason| match report::only(&report.read.not_drawn) {
            Some(only) if report.mesh.triangles == 0 => format!("{reason}, only {only}"),
            _ => reason,
        })
    }

    /// The work of one process of an MPI job, on one thread of the pool, where all MPI calls stay. Only rank 0 returns
    /// a result.
    fn draw_as_rank(
        &self,
        comm: &mut mpi::Comm,
        writing: &Writing,
        settings: &Settings,
        mut how: How,
    ) -> Result<Option<Done>> {
        mpi::watch(comm, self.ranks.timeout());
        let writes = comm.rank() == 0;
        if writes {
            writing.files.check_places()?;
        }
        let display = Display::new(if writes { self.running.progress_mode() } else { ProgressMode::Never });
        let in_parts = self.ranks.parts();
        let begin = self.ranks.now();
        let loaded = self.load(writing, &display, Drawers::Mpi(how), in_parts.then_some(&mut *comm))?;
        let mut own = Rank::new();
        if let Some(begin) = begin {
            own.record();
            own.record_step(Step::Load, 0, Span::since(begin));
        }
        let (mut drawn, mut choice) = (Vec::new(), None);
        for camera in &loaded.cameras.views {
            let parts = in_parts.then_some(&mut *comm);
            let settings = &self.with_shadows(settings, &loaded.scene, camera, &display, parts)?;
            display.stage("drawing");
            let picture = (&loaded.scene, camera, settings);
            let (sharing, chosen) = organisation::between(comm, how, rayon::current_num_threads(), picture)
                .with_context(|| self.model.name())?;
            how = How::As(sharing);
            choice = choice.or(chosen);
            let task = Task { sharing, scene: &loaded.scene, camera, settings };
            let mut frame = Frame::default();
            let parallel = between_processes::draw_frame(&mut own, comm, &task, &mut frame)
                .with_context(|| self.model.name())?;
            if writes {
                let effect_milliseconds = self.add_effects(&mut frame, &loaded, camera, settings)?;
                drawn.push(Drawn { frame, parallel, effect_milliseconds });
            }
        }
        let records = self.ranks.trace().is_some();
        let trace = if records { between_processes::gather_trace(&mut own, comm)? } else { None };
        if !writes {
            return Ok(None);
        }
        display.stage("writing");
        self.write(writing, loaded, drawn, choice, trace).map(Some)
    }

    /// The files of the model: of all ranks, if each has its own.
    fn models(&self, processes: Option<usize>) -> Vec<PathBuf> {
        let model = &self.model.model;
        if !self.ranks.parts() {
            return vec![model.clone()];
        }
        let ranks = 0..processes.unwrap_or(1);
        let mut files: Vec<PathBuf> = ranks.map(|rank| parts::file_of_rank(model, rank)).collect();
        files.dedup();
        files
    }

    /// Loads the model, or this rank's part of it if there are `parts`, the ranks that load the others.
    fn load(
        &self,
        writing: &Writing,
        display: &Display,
        drawers: Drawers,
        mut parts: Option<&mut impl Communicator>,
    ) -> Result<Loaded> {
        // First, because it is read quickly: what is wrong with it should be known at once.
        if self.environment.is_given() {
            display.stage("reading the environment");
        }
        let environment = self.environment.load(self.camera.front(), self.running.memory_limit())?;
        let options = LoadOptions {
            memory_limit: self.running.memory_limit(),
            progress: Some(&display.progress),
            normals: self.drawing.normals(writing.plan.outputs),
            clip: self.clip.clipping(),
            ..LoadOptions::default()
        };
        let check = |read: &ReadReport| -> Result<()> {
            Ok(writing.files.check_companions(&self.model.name(), &read.companions)?)
        };
        let (loaded, share) = match &mut parts {
            None => (options.load_if(&self.model.model, check)?, None),
            Some(comm) => {
                let LoadedPart { loaded, share, .. } = options.load_part(*comm, &self.model.model)?;
                check(&loaded.report.read)?;
                (loaded, Some(share))
            }
        };
        let mut report = loaded.report;
        let picture = self.frame_bytes(&writing.plan, drawers);
        self.check_memory(picture, report.mesh.bytes)?;
        let mut scene = Scene::from_mesh(loaded.mesh);
        scene.instances[0].share = share;
        scene.environment = environment;
        self.drawing.dress(&mut scene);
        let background = scene.background;
        if self.effects.are_applied() {
            scene.background = Background::Solid([0.0; 4]);
        }
        // Layers of what is not opaque need memory, too.
        let shadows = self.drawing.shadow_bytes(&scene);
        let taken = picture.saturating_add(report.mesh.bytes).saturating_add(shadows);
        let left = |limit: u64| limit.saturating_sub(taken) / 4 * 3;
        let limits = TextureLimits {
            memory: self.running.memory_limit().map(left),
            progress: &display.progress,
            specular: self.drawing.specular(),
            is_unlit: self.drawing.is_unlit(),
        };
        let textures = self.textures.load(&mut scene, &self.model.model, &report, &limits);
        if let Some(textures) = &textures {
            // They are not always where the model says.
            writing.files.check_companions(&self.model.name(), &textures.files)?;
        }
        if let Some(comm) = &mut parts {
            share_materials(*comm, &mut scene)?;
        }
        let taken = report.mesh.bytes.saturating_add(textures.as_ref().map_or(0, |textures| textures.bytes));
        self.check_memory(picture.saturating_add(shadows), taken)?;
        self.clip.add_caps(&mut scene, loaded.caps);
        report.read.warnings.extend(self.drawing.shadow_warning(&scene));
        let camera = match parts {
            None => self.camera.camera_for(&scene, loaded.whole.as_ref(), self.drawing.size),
            Some(comm) => self.camera.camera_of_parts(comm, &scene, self.drawing.size)?,
        };
        let cameras = self.stereo.cameras(camera, self.camera.zoom()).with_context(|| self.model.name())?;
        let look = self.drawing.look(&scene, &background, &self.environment, &self.effects);
        Ok(Loaded { report, textures, scene, background, look, cameras })
    }

    fn frame(
        &self,
        scene: &Scene,
        camera: &Camera,
        settings: &Settings,
        drawers: Drawers,
        trace: &mut Option<Trace>,
    ) -> Result<(Frame, Option<FrameReport>, Option<Choice>)> {
        let threads = rayon::current_num_threads();
        let begin = self.ranks.now();
        let recorded;
        let drawn = match (organisation::in_process(drawers, threads, (scene, camera, settings))?, &trace) {
            (None, _) => {
                let frame = Renderer::new().render(scene, camera, settings)?;
                let Some(begin) = begin else { return Ok((frame, None, None)) };
                recorded = Trace::of_one(Step::Draw, Span::since(begin));
                (frame, None, None)
            }
            (Some((ranks, choice)), None) => {
                let (frame, report) = in_process::draw(ranks, scene, camera, settings)?;
                return Ok((frame, Some(report), choice));
            }
            (Some((ranks, choice)), Some(_)) => {
                let (frame, report, of_ranks) = in_process::record(ranks, scene, camera, settings)?;
                recorded = of_ranks;
                (frame, Some(report), choice)
            }
        };
        if let Some(trace) = trace {
            trace.append(recorded);
        }
        Ok(drawn)
    }

    /// Bytes of the pictures of this process; with their keys if there are ranks. Ranks that composite samples keep
    /// fragments, too: how many is known only when they are drawn, but a full picture has one in each pixel.
    fn frame_bytes(&self, plan: &Plan, drawers: Drawers) -> u64 {
        if self.is_in_bands(plan, drawers) {
            return band_bytes(&self.drawing.settings(&self.tuning, &self.sampling, plan.outputs));
        }
        let (frames, keys) = drawers.frames();
        let bytes = frame_bytes(Outputs { keys, ..plan.outputs }, self.drawing.size);
        let count = self.sampling.sampling().pattern.count();
        let mut fragments = 0;
        if count > 1 && drawers.composites() {
            let (width, height) = self.drawing.size;
            let pixels = u64::from(width) * u64::from(height);
            fragments = pixels.saturating_mul(fragment_bytes(&plan.outputs, count) as u64);
        }
        let further =
            frame_bytes(plan.outputs, self.drawing.size).saturating_mul(self.stereo.further_frames());
        let effects = self.effects.bytes(self.drawing.size);
        let bytes = bytes.saturating_mul(frames as u64).saturating_add(fragments);
        bytes.saturating_add(further).saturating_add(effects)
    }

    fn check_memory(&self, picture: u64, model: u64) -> Result<()> {
        match self.running.memory_limit() {
            Some(limit) if picture.saturating_add(model) > limit => bail!(
                "{}: the picture needs {picture} bytes (with its shadow maps and effects) besides {model} for the model (with its textures), the limit is {limit} bytes ({})",
                self.model.name(),
                memory::limit_source()
            ),
            _ => Ok(()),
        }
    }

    /// Writes the outputs, unless nothing was drawn.
    fn write(
        &self,
        writing: &Writing,
        loaded: Loaded,
        drawn: Vec<Drawn>,
        choice: Option<Choice>,
        trace: Option<Trace>,
    ) -> Result<Done> {
        let Loaded { report, textures, scene, look, cameras, .. } = loaded;
        let mut frames = Vec::new();
        let (mut views, mut reasons) = (Vec::new(), Vec::new());
        let effect_milliseconds = drawn.iter().map(|d| d.effect_milliseconds).sum();
        for (Drawn { frame, parallel, .. }, camera) in drawn.into_iter().zip(&cameras.views) {
            reasons.push(self.reason(&report, camera, &frame.stats));
            views.push(ViewReport { stats: frame.stats.clone(), parallel });
            frames.push(frame);
        }
        // What one eye sees is something.
        let empty = reasons.into_iter().collect::<Option<Vec<_>>>().and_then(|all| all.into_iter().next());
        let begin = Instant::now();
        // A large model takes longer to free than a picture takes to write.
        let is_written = empty.is_none() || writing.allow_empty;
        let write = || if is_written { writing.plan.write(&self.stereo.written(frames)?) } else { Ok(()) };
        let (written, ()) = rayon::join(write, || drop(scene));
        written?;
        let output_milliseconds = begin.elapsed().as_secs_f64() * 1e3;
        Ok(Done {
            report,
            textures,
            look,
            cameras,
            choice,
            views,
            effect_milliseconds,
            output_milliseconds,
            empty,
            trace,
        })
    }

    fn print_summary(&self, done: &Done) {
        if self.running.quiet {
            return;
        }
        let model = self.model.name();
        let of_textures = done.textures.iter().flat_map(|textures| textures.warnings.clone());
        for warning in report::warnings(&done.report).into_iter().chain(of_textures) {
            messages::warning(&format!("{model}: {warning}"));
        }
        // For a model without triangles, the error lists its other content.
        if let Some(list) = report::not_drawn(&done.report.read.not_drawn)
            && done.report.mesh.triangles > 0
        {
            let drawn = report::drawn(&done.report.read.not_drawn);
            messages::warning(&format!("{model}: not drawn: {list} ({drawn})"));
        }
        if let Some(why) = report::unused_crease_angle(self.drawing.crease_angle, &done.report) {
            messages::warning(&format!("{model}: {why}"));
        }
        if let Some(reason) = done.empty.as_ref().filter(|_| self.writing.allow_empty) {
            messages::warning(&format!("{model}: {reason}"));
        }
        if let Some(eye) = stereo::blind_eye(&done.views) {
            messages::warning(&format!("{model}: the {eye} eye sees nothing of the model"));
        }
        if self.running.verbose {
            print_details(done);
        }
    }

    fn stats(&self, done: &Done, threads: usize, start: Instant) -> Result<Value> {
        let frame = stereo::together(&done.views);
        let (width, height) = self.stereo.picture_size(self.drawing.size).unwrap_or(self.drawing.size);
        // Those of eyes are with the eyes.
        let parallel =
            done.views.first().filter(|_| done.cameras.stereo.is_none()).map(|view| &view.parallel);
        Ok(json!({
            "tercio_version": env!("CARGO_PKG_VERSION"),
            "load": report::load_json(&self.model.name(), &done.report),
            "textures": done.textures.as_ref().map(report::textures_json),
            "camera": report::camera_json(&done.cameras.middle),
            "stereo": stereo::json(self.stereo.layout(), &done.cameras, &done.views),
            "picture": {
                "width": width,
                "height": height,
                "anti_aliasing": self.sampling.json(),
            },
            "look": done.look,
            "frame": serde_json::to_value(&frame)?,
            "parallel": parallel,
            "choice": done.choice.as_ref().map(organisation::json),
            "threads": threads,
            "simd": frame.simd,
            "effect_milliseconds": done.effect_milliseconds,
            "output_milliseconds": done.output_milliseconds,
            "total_milliseconds": start.elapsed().as_secs_f64() * 1e3,
            "peak_memory_bytes": memory::peak_bytes(),
        }))
    }
}

fn print_details(done: &Done) {
    let Done { report, textures, views, output_milliseconds, .. } = done;
    let times = &report.times;
    messages::note(&format!(
        "{}: {}, {}; read {:.1} ms, clean {:.1}, weld {:.1}, normals {:.1}, clusters {:.1}",
        report.read.format,
        report::counted(report.mesh.triangles, "triangle"),
        report::counted(report.mesh.vertices, "vertex"),
        times.read,
        times.clean,
        times.weld,
        times.normals,
        times.partition,
    ));
    report::repairs(report).iter().for_each(|r| messages::note(r));
    if let Some(textures) = textures.as_ref().filter(|textures| textures.textures > 0) {
        messages::note(&format!(
            "{} in {} read in {:.1} ms",
            report::counted(textures.textures, "texture"),
            report::size(textures.bytes),
            textures.milliseconds
        ));
    }
    report::clipped(report).iter().for_each(|c| messages::note(c));
    done.choice.iter().for_each(organisation::print);
    for frame in views.iter().flat_map(|view| &view.parallel) {
        messages::note(&format!(
            "{} ranks, {}, sent {} with {} bytes",
            frame.ranks.len(),
            frame.organisation,
            report::counted(frame.messages, "message"),
            report::grouped(frame.bytes)
        ));
        let tables = report::table_of_ranks(frame).into_iter().chain(report::tables_of_partners(frame));
        tables.for_each(|line| messages::note(&line));
    }
    let stats = &stereo::together(views);
    messages::note(&format!(
        "drawn in {:.1} ms ({}, {}): {} set up (counted once a tile and once a clipped \
         piece), {} covered, overdraw {:.2}; written in {output_milliseconds:.1} ms",
        stats.milliseconds.total,
        report::counted(stats.threads as u64, "thread"),
        stats.simd,
        report::counted(stats.frontend.triangles_out + stats.backend.triangles_drawn, "triangle"),
        report::counted(stats.backend.pixels_visible, "pixel"),
        stats.backend.overdraw,
    ));
}
