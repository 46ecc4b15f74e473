//! Pictures that this process draws, by itself or with ranks that are its threads.

use anyhow::{Context, Result};
use tercio::parallel::FrameReport;
use tercio::parallel::in_process::Crew;
use tercio::parallel::trace::{Span, Step, Trace};
use tercio::raster::{Frame, Renderer, Settings};
use tercio::scene::{Camera, Scene};
use tercio_lab::predict::choose::Choice;

use super::series::{Running, Series};
use super::{Done, Drawn, Job, Loaded, Render};
use crate::args::ranks::{Drawers, How};
use crate::progress::Display;
use crate::{mpi, organisation};

/// Draws frames, and keeps what is the same for all of them.
pub(super) struct Artist {
    renderer: Renderer,
    crew: Crew,
    pub drawers: Drawers,
    /// Why ranks share frames as they do, if that was chosen.
    pub choice: Option<Choice>,
    pub trace: Option<Trace>,
}

impl Artist {
    pub fn new(drawers: Drawers, trace: Option<Trace>) -> Self {
        Self { renderer: Renderer::new(), crew: Crew::default(), drawers, choice: None, trace }
    }
}

impl Render {
    pub(super) fn draw(&self, job: &Job, display: &Display) -> Result<Done> {
        let begin = self.ranks.now();
        let mut loaded = self.load(job, display, None::<&mut mpi::Comm>)?;
        let trace = begin.map(|begin| {
            let mut trace = Trace::default();
            trace.add(0, Step::Load, 0, Span::since(begin));
            trace
        });
        let mut artist = Artist::new(job.drawers, trace);
        let series = if self.is_in_bands(&job.writing.plan, job.drawers) {
            self.draw_in_bands(job, &mut loaded, display, &mut artist)?
        } else {
            let mut running = Running::new(self, &[], job, display)?;
            self.begin_pictures(job, display);
            running.draw(self, &mut loaded, 0, |loaded, camera, frame| {
                self.draw_one(job, loaded, camera, display, &mut artist, frame)
            })?;
            running.finish()?
        };
        Ok(done(loaded, series, artist.choice, artist.trace))
    }

    /// Shows the progress of several pictures, if there are several.
    pub(super) fn begin_pictures(&self, job: &Job, display: &Display) {
        if job.writing.is_series {
            display.pictures(job.writing.pictures.len() as u64);
        }
    }

    /// One picture of one camera, with its effects.
    pub(super) fn draw_one(
        &self,
        job: &Job,
        loaded: &Loaded,
        camera: &Camera,
        display: &Display,
        artist: &mut Artist,
        mut frame: Frame,
    ) -> Result<Drawn> {
        if job.writing.plan.drawing.is_some() {
            display.stage("drawing");
            return self.draw_page(loaded, camera, frame);
        }
        let settings = &self.with_shadows(&job.settings, loaded, camera, display, None::<&mut mpi::Comm>)?;
        display.stage("drawing");
        let scene = &*self.with_strokes(loaded, camera)?;
        let parallel =
            self.frame(scene, camera, settings, artist, &mut frame).with_context(|| self.model.name())?;
        let effect_milliseconds = self.add_effects(&mut frame, (scene, loaded), camera, settings)?;
        display.stage("writing");
        Ok(Drawn { frame, page: None, parallel, effect_milliseconds })
    }

    fn frame(
        &self,
        scene: &Scene,
        camera: &Camera,
        settings: &Settings,
        artist: &mut Artist,
        frame: &mut Frame,
    ) -> Result<Option<FrameReport>> {
        let threads = rayon::current_num_threads();
        let begin = self.ranks.now();
        let chosen = organisation::in_process(artist.drawers, threads, (scene, camera, settings))?;
        let Some((ranks, choice)) = chosen else {
            artist.renderer.render_into(scene, camera, settings, frame)?;
            if let (Some(trace), Some(begin)) = (&mut artist.trace, begin) {
                trace.append(Trace::of_one(Step::Draw, Span::since(begin)));
            }
            return Ok(None);
        };
        if let (Some(choice), Drawers::InProcess(count, _)) = (choice, artist.drawers) {
            // Other cameras see almost the same.
            artist.drawers = Drawers::InProcess(count, How::As(choice.sharing()));
            artist.choice = Some(choice);
        }
        let report;
        if let Some(trace) = &mut artist.trace {
            let of_ranks;
            (*frame, report, of_ranks) = artist.crew.record(ranks, scene, camera, settings)?;
            trace.append(of_ranks);
        } else {
            (*frame, report) = artist.crew.draw(ranks, scene, camera, settings)?;
        }
        Ok(Some(report))
    }
}

/// All results.
pub(super) fn done(loaded: Loaded, series: Series, choice: Option<Choice>, trace: Option<Trace>) -> Done {
    let Loaded { reports: models, look, .. } = loaded;
    let Series { shots, found, output_milliseconds, empty } = series;
    Done { models, look, choice, shots, found, output_milliseconds, empty, trace }
}
