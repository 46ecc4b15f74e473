//! The work of one process of an MPI job.

use anyhow::{Context, Result};
use tercio::parallel::organisation::{Rank, Task};
use tercio::parallel::trace::{Span, Step};
use tercio::parallel::{Communicator, between_processes};
use tercio::raster::{Frame, Settings};

use super::{Done, Drawn, Render, Writing};
use crate::args::ProgressMode;
use crate::args::ranks::{Drawers, How};
use crate::progress::Display;
use crate::{mpi, organisation};

impl Render {
    /// The work of one process of an MPI job, on one thread of the pool, where all MPI calls stay. Only rank 0 returns
    /// a result.
    pub(super) fn draw_as_rank(
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
            let scene = &*self.with_strokes(&loaded, camera)?;
            let picture = (scene, camera, settings);
            let (sharing, chosen) = organisation::between(comm, how, rayon::current_num_threads(), picture)
                .with_context(|| self.model.name())?;
            how = How::As(sharing);
            choice = choice.or(chosen);
            let task = Task { sharing, scene, camera, settings };
            let mut frame = Frame::default();
            let parallel = between_processes::draw_frame(&mut own, comm, &task, &mut frame)
                .with_context(|| self.model.name())?;
            if writes {
                let effect_milliseconds =
                    self.add_effects(&mut frame, (scene, &loaded.background), camera, settings)?;
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
}
