//! All pictures of a run, one or many: drawn one after the other, and encoded and written while the next ones are drawn.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::time::{Duration, Instant, SystemTime};

use anyhow::Result;
use tercio::image::Picture;
use tercio::image::film::EncodedPicture;
use tercio::raster::Frame;
use tercio::scene::{Camera, Scene};
use tercio::vector::Page;

use super::vector::page_reason;
use super::{Drawn, Job, Loaded, Render, Shot};
use crate::args::ModelArgs;
use crate::args::ranks::Drawers;
use crate::args::stereo::StereoArgs;
use crate::progress::Display;
use crate::series::film::FilmOutput;
use crate::series::pipeline::{self, Stages};
use crate::series::whole;
use crate::stereo::ViewReport;

/// The most pictures that are encoded at a time.
const MOST_IN_WORK: usize = 32;

/// The pictures of a shot that are to be written.
pub(super) struct Frames {
    shot: usize,
    frames: Vec<Frame>,
    page: Option<Page>,
}

/// Where pictures go when they are drawn.
pub(super) struct Output<'a> {
    job: &'a Job,
    stereo: &'a StereoArgs,
    film: Option<FilmOutput>,
    display: &'a Display,
    /// Frames whose memory can be used again.
    spare: Mutex<Vec<Frame>>,
    microseconds: AtomicU64,
}

impl Output<'_> {
    fn spare(&self) -> Frame {
        self.spare.lock().ok().and_then(|mut spare| spare.pop()).unwrap_or_default()
    }
}

impl Stages<Frames, Option<EncodedPicture>> for Output<'_> {
    fn encode(&self, _: usize, drawn: Frames) -> Result<Option<EncodedPicture>> {
        let begin = Instant::now();
        if let Some(page) = &drawn.page {
            self.job.writing.pictures[drawn.shot].write_drawing(page)?;
        }
        let frames = self.stereo.written(drawn.frames)?;
        self.job.writing.pictures[drawn.shot].write(&frames)?;
        let film = self.job.writing.film.as_ref().zip(frames.first());
        let encoded =
            film.map(|(film, frame)| film.encode(&Picture::from_frame(frame), drawn.shot)).transpose()?;
        if let Ok(mut spare) = self.spare.lock() {
            spare.extend(frames);
        }
        self.add_time(begin.elapsed());
        Ok(encoded)
    }

    fn append(&self, _: usize, encoded: Option<EncodedPicture>) -> Result<()> {
        let begin = Instant::now();
        if let (Some(film), Some(encoded)) = (&self.film, encoded) {
            film.append(&encoded)?;
        }
        self.add_time(begin.elapsed());
        self.display.progress.advance(1);
        Ok(())
    }
}

impl Output<'_> {
    fn add_time(&self, time: Duration) {
        self.microseconds.fetch_add(time.as_micros() as u64, Relaxed);
    }
}

/// What drawing and writing all pictures has shown.
pub(super) struct Series {
    pub shots: Vec<Shot>,
    pub found: usize,
    pub output_milliseconds: f64,
    /// Why nothing was written, if that is the case.
    pub empty: Option<String>,
}

/// A series that is being written.
pub(super) struct Running<'a> {
    output: Output<'a>,
    room: usize,
    series: Series,
    /// Whether others draw the same pictures together with this process: then all are drawn, even if they are not wanted any more.
    is_shared: bool,
    /// With `--resume`, when the inputs were changed last.
    newest_input: Option<SystemTime>,
}

impl<'a> Running<'a> {
    /// Begins the outputs of a job, of a series of models if there are `steps`.
    ///
    /// # Errors
    /// The system's reason why a film cannot be written.
    pub fn new(render: &'a Render, steps: &[ModelArgs], job: &'a Job, display: &'a Display) -> Result<Self> {
        let film = job.writing.film.as_ref().map(|film| film.begin()).transpose()?;
        let output = Output {
            job,
            stereo: &render.stereo,
            film,
            display,
            spare: Mutex::default(),
            microseconds: AtomicU64::new(0),
        };
        let series = Series { shots: Vec::new(), found: 0, output_milliseconds: 0.0, empty: None };
        let is_shared = matches!(job.drawers, Drawers::Mpi(_));
        let newest_input = if render.series.resume { render.newest_input(steps) } else { None };
        Ok(Self { output, room: render.room(job), series, is_shared, newest_input })
    }

    /// Draws all shots of a model with `draw`, which gets the memory of another frame, and writes them; `first` is the number of
    /// its first shot. The scene is dropped when the last one is drawn. Returns whether more pictures are wanted.
    ///
    /// # Errors
    /// The first one of drawing or writing.
    pub fn draw(
        &mut self,
        render: &Render,
        loaded: &mut Loaded,
        first: usize,
        mut draw: impl FnMut(&Loaded, &Camera, Frame) -> Result<Drawn>,
    ) -> Result<bool> {
        let (output, series, is_shared) = (&self.output, &mut self.series, self.is_shared);
        let resumes = render.series.resume;
        let newest = self.newest_input.max(if resumes { loaded.newest_companion() } else { None });
        let is_found = |shot: usize| {
            let plan = &output.job.writing.pictures[shot];
            resumes && whole::is_there(plan, render.written_size(), newest)
        };
        let all = first..first + loaded.cameras.len();
        let mut wanted = all.clone().filter(|&shot| !is_found(shot)).collect::<Vec<_>>().into_iter();
        let found = all.len() - wanted.len();
        series.found += found;
        output.display.progress.advance(found as u64);
        let mut goes_on = true;
        let next = |_| -> Result<Option<Frames>> {
            let is_closed = output.film.as_ref().is_some_and(FilmOutput::is_closed);
            goes_on &= !is_closed;
            if !goes_on && is_shared {
                for camera in wanted.by_ref().flat_map(|shot| loaded.cameras[shot - first].views.clone()) {
                    draw(loaded, &camera, output.spare())?;
                }
            }
            let shot = wanted.next().filter(|_| goes_on);
            let Some(shot) = shot else {
                // A large model takes longer to free than a picture takes to write.
                loaded.scene = Scene::default();
                return Ok(None);
            };
            loaded.annotated.shot = shot;
            let cameras = loaded.cameras[shot - first].clone();
            let (mut frames, mut views, mut reasons) = (Vec::new(), Vec::new(), Vec::new());
            let (mut effect_milliseconds, mut page) = (0.0, None);
            for camera in &cameras.views {
                let drawn = draw(loaded, camera, output.spare())?;
                reasons.push(match &drawn.page {
                    Some(page) => page_reason(page),
                    None => render.reason(&loaded.together, camera, &drawn.frame.stats),
                });
                page = drawn.page;
                views.push(ViewReport { stats: drawn.frame.stats.clone(), parallel: drawn.parallel });
                effect_milliseconds += drawn.effect_milliseconds;
                frames.push(drawn.frame);
            }
            // What one eye sees is something.
            let empty =
                reasons.into_iter().collect::<Option<Vec<_>>>().and_then(|all| all.into_iter().next());
            // A series has to show something at its beginning; later, a camera may look elsewhere.
            let is_nothing = empty.is_some() && shot == 0;
            if is_nothing {
                series.empty.clone_from(&empty);
            }
            series.shots.push(Shot { number: shot, cameras, views, effect_milliseconds, empty });
            if is_nothing && !output.job.writing.allow_empty {
                goes_on = false;
                for camera in wanted
                    .by_ref()
                    .filter(|_| is_shared)
                    .flat_map(|s| loaded.cameras[s - first].views.clone())
                {
                    draw(loaded, &camera, output.spare())?;
                }
                loaded.scene = Scene::default();
                return Ok(None);
            }
            Ok(Some(Frames { shot, frames, page }))
        };
        pipeline::run(self.room, output, next)?;
        Ok(goes_on)
    }

    /// Ends the outputs.
    ///
    /// # Errors
    /// The system's reason why the film could not be written.
    pub fn finish(self) -> Result<Series> {
        let is_written = self.series.empty.is_none() || self.output.job.writing.allow_empty;
        let begin = Instant::now();
        if let Some(film) = self.output.film.filter(|_| is_written) {
            film.finish()?;
        }
        let milliseconds = self.output.microseconds.into_inner() as f64 * 1e-3;
        Ok(Series { output_milliseconds: milliseconds + begin.elapsed().as_secs_f64() * 1e3, ..self.series })
    }
}

impl Render {
    /// How many pictures may be in memory besides the one that is drawn.
    pub(super) fn room(&self, job: &Job) -> usize {
        let threads = rayon::current_num_threads().min(MOST_IN_WORK).min(job.writing.pictures.len());
        let own = self.frame_bytes(&job.writing.plan, job.drawers).max(1);
        let spare = self.running.memory_limit().map_or(u64::MAX, |limit| limit / 4 / own);
        threads.min(spare as usize).max(1)
    }
}
