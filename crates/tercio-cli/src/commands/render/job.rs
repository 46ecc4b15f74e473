//! The work of one process of an MPI job.

use anyhow::{Context, Result};
use tercio::parallel::organisation::{Rank, Task};
use tercio::parallel::trace::{Span, Step};
use tercio::parallel::{Communicator, between_processes};
use tercio::raster::Frame;
use tercio::scene::Camera;

use super::alone::done;
use super::series::Running;
use super::{Done, Drawn, Job, Loaded, Render};
use crate::args::ProgressMode;
use crate::args::ranks::How;
use crate::progress::Display;
use crate::{mpi, organisation};

impl Render {
    /// The work of one process of an MPI job, on one thread of the pool, where all MPI calls stay. Only rank 0 returns
    /// a result.
    pub(super) fn draw_as_rank(&self, comm: &mut mpi::Comm, job: &Job, mut how: How) -> Result<Option<Done>> {
        mpi::watch(comm, self.ranks.timeout());
        let writes = comm.rank() == 0;
        if writes {
            job.writing.files.check_places()?;
            job.writing.check_film()?;
        }
        let display = Display::new(if writes { self.running.progress_mode() } else { ProgressMode::Never });
        let in_parts = self.ranks.parts();
        let begin = self.ranks.now();
        let mut loaded = self.load(job, &display, in_parts.then_some(&mut *comm))?;
        let mut own = Rank::new();
        // Of many ranks they are much to send with each picture.
        own.tell_partners(self.running.verbose || job.writing.plan.stats.is_some());
        if let Some(begin) = begin {
            own.record();
            own.record_step(Step::Load, 0, Span::since(begin));
        }
        let mut choice = None;
        // All processes draw the same pictures in the same order: none of them may end the series early.
        let mut draw = |loaded: &Loaded, camera: &Camera, mut frame: Frame| -> Result<Drawn> {
            let parts = in_parts.then_some(&mut *comm);
            let settings = &self.with_shadows(&job.settings, loaded, camera, &display, parts)?;
            display.stage("drawing");
            let scene = &*self.with_strokes(loaded, camera)?;
            let picture = (scene, camera, settings);
            let (sharing, chosen) = organisation::between(comm, how, rayon::current_num_threads(), picture)
                .with_context(|| self.model.name())?;
            how = How::As(sharing);
            choice = choice.take().or(chosen);
            let task = Task { sharing, scene, camera, settings };
            let parallel = between_processes::draw_frame(&mut own, comm, &task, &mut frame)
                .with_context(|| self.model.name())?;
            let mut effect_milliseconds = 0.0;
            if writes {
                effect_milliseconds = self.add_effects(&mut frame, (scene, loaded), camera, settings)?;
            }
            Ok(Drawn { frame, page: None, parallel, effect_milliseconds })
        };
        let mut series = None;
        if writes {
            let mut running = Running::new(self, &[], job, &display)?;
            self.begin_pictures(job, &display);
            running.draw(self, &mut loaded, 0, &mut draw)?;
            series = Some(running.finish()?);
        } else {
            let mut frame = Frame::default();
            for camera in loaded.cameras.iter().flat_map(|cameras| &cameras.views) {
                frame = draw(&loaded, camera, frame)?.frame;
            }
        }
        let records = self.ranks.trace().is_some();
        let trace = if records { between_processes::gather_trace(&mut own, comm)? } else { None };
        Ok(series.map(|series| done(loaded, series, choice, trace)))
    }
}
