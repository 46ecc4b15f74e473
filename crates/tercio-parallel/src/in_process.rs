//! Ranks in one process: one thread each, messages in shared memory.

use std::sync::Mutex;
use std::time::Instant;

use rayon::ThreadPoolBuilder;
use tercio_raster::{Frame, Settings};
use tercio_scene::{Camera, Scene};

use crate::comm::threads::{self, ThreadComm};
use crate::comm::{Communicator, Kind, Observed};
use crate::organisation::{Rank, Task, tile_edge};
use crate::placement;
use crate::report::{FrameReport, RankReport};
use crate::trace::{Step, Timeline, Trace};
use crate::{ParallelError, Sharing};

/// Ranks in this process.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ranks {
    /// Number of ranks, at least 1.
    pub count: usize,
    /// Number of threads of each rank, at least 1.
    pub threads: usize,
    /// How they share a frame.
    pub sharing: Sharing,
}

/// Draws one frame per camera and returns the reports, the last one with [counts by partner](RankReport::partners).
/// `picture` gets each picture, with the number of its camera, and may take its contents.
///
/// # Errors
/// [`ParallelError`]: that of the first rank that failed.
///
/// # Panics
/// If there are no ranks.
pub fn draw_frames(
    ranks: Ranks,
    scene: &Scene,
    cameras: &[Camera],
    settings: &Settings,
    picture: impl Fn(usize, &mut Frame) + Sync,
) -> Result<Vec<FrameReport>, ParallelError> {
    Ok(Crew::default().frames(ranks, scene, cameras, settings, picture, false)?.0)
}

/// [`draw_frames`], and when each rank did what.
///
/// # Errors
/// As [`draw_frames`].
///
/// # Panics
/// If there are no ranks.
pub fn record_frames(
    ranks: Ranks,
    scene: &Scene,
    cameras: &[Camera],
    settings: &Settings,
    picture: impl Fn(usize, &mut Frame) + Sync,
) -> Result<(Vec<FrameReport>, Trace), ParallelError> {
    Crew::default().frames(ranks, scene, cameras, settings, picture, true)
}

/// Ranks of this process, kept from picture to picture with what they remember of the last one, as those of [`draw_frames`] are.
#[derive(Debug, Default)]
pub struct Crew {
    ranks: Vec<Mutex<Rank>>,
}

impl Crew {
    /// Draws the next picture; its stats are [`FrameReport::stats`].
    ///
    /// # Errors
    /// As [`draw_frames`].
    ///
    /// # Panics
    /// If there are no ranks.
    pub fn draw(
        &mut self,
        ranks: Ranks,
        scene: &Scene,
        camera: &Camera,
        settings: &Settings,
    ) -> Result<(Frame, FrameReport), ParallelError> {
        let (frame, report, _) = self.picture(ranks, scene, camera, settings, false)?;
        Ok((frame, report))
    }

    /// [`Self::draw`], and when each rank did what.
    ///
    /// # Errors
    /// As [`draw_frames`].
    ///
    /// # Panics
    /// If there are no ranks.
    pub fn record(
        &mut self,
        ranks: Ranks,
        scene: &Scene,
        camera: &Camera,
        settings: &Settings,
    ) -> Result<(Frame, FrameReport, Trace), ParallelError> {
        self.picture(ranks, scene, camera, settings, true)
    }

    fn picture(
        &mut self,
        ranks: Ranks,
        scene: &Scene,
        camera: &Camera,
        settings: &Settings,
        records: bool,
    ) -> Result<(Frame, FrameReport, Trace), ParallelError> {
        let drawn = Mutex::new(Frame::default());
        let keep = |_, frame: &mut Frame| {
            *drawn.lock().unwrap_or_else(|e| e.into_inner()) = std::mem::take(frame);
        };
        let (reports, trace) = self.frames(ranks, scene, &[*camera], settings, keep, records)?;
        let mut frame = drawn.into_inner().unwrap_or_else(|e| e.into_inner());
        let Some(report) = reports.into_iter().next() else { unreachable!("one camera makes one frame") };
        frame.stats = report.stats();
        Ok((frame, report, trace))
    }

    fn frames(
        &mut self,
        ranks: Ranks,
        scene: &Scene,
        cameras: &[Camera],
        settings: &Settings,
        picture: impl Fn(usize, &mut Frame) + Sync,
        records: bool,
    ) -> Result<(Vec<FrameReport>, Trace), ParallelError> {
        // After an error the ranks may not remember the same: they are lost then.
        let mut crew = std::mem::take(&mut self.ranks);
        if crew.len() != ranks.count {
            crew = (0..ranks.count).map(|_| Mutex::default()).collect();
        }
        let drawn = frames(&crew, ranks, scene, cameras, settings, picture, records)?;
        self.ranks = crew;
        Ok(drawn)
    }
}

fn frames(
    crew: &[Mutex<Rank>],
    ranks: Ranks,
    scene: &Scene,
    cameras: &[Camera],
    settings: &Settings,
    picture: impl Fn(usize, &mut Frame) + Sync,
    records: bool,
) -> Result<(Vec<FrameReport>, Trace), ParallelError> {
    let layer_memory = settings.layer_memory / ranks.count.max(1);
    let settings = &Settings { layer_memory, ..settings.clone() };
    let draw = |comm: &mut ThreadComm, own: &mut Rank| {
        let mut frame = Frame::default();
        let mut reports: Vec<(RankReport, Instant, Instant)> = Vec::new();
        let drawn_before = own.frames();
        for (number, camera) in cameras.iter().enumerate() {
            let mut waiting = Observed::new(comm, Kind::Barrier);
            let number_of_frame = own.frames().wrapping_add(1);
            own.timed(Step::Wait, number_of_frame, || waiting.barrier())?;
            let signals = waiting.finish();
            let begin = Instant::now();
            let task = Task { sharing: ranks.sharing, scene, camera, settings };
            let mut report = own.draw_into(comm, &task, &mut frame)?;
            report.add_partners(signals);
            // As many counts as ranks, for each rank.
            if let Some((earlier, ..)) = reports.last_mut() {
                earlier.partners = Vec::new();
            }
            reports.push((report, begin, Instant::now()));
            if comm.rank() == 0 {
                picture(number, &mut frame);
            }
        }
        let mut timeline = own.take_timeline();
        timeline.count_frames_from(drawn_before);
        Ok((reports, timeline))
    };
    let first = placement::current();
    let drawn = threads::run(ranks.count, |comm| {
        // Nobody else has it.
        let mut own = crew[comm.rank()].lock().unwrap_or_else(|e| e.into_inner());
        let own: &mut Rank = &mut own;
        if records {
            own.record();
        }
        // All work of a rank runs on its own threads: it is not passed between pools, and no thread searches for more
        // work.
        let threads = ranks.threads.max(1);
        let own_first = first + comm.rank() * threads;
        let pool = placement::spread(ThreadPoolBuilder::new().num_threads(threads), own_first).build();
        let pool = pool.map_err(|source| ParallelError::Threads { threads, source })?;
        pool.install(|| draw(comm, own))
    })?;
    let (reports, timelines): (Vec<_>, Vec<Timeline>) = drawn.into_iter().unzip();
    // Transpose: from a list per rank to a list per frame.
    let mut of_ranks: Vec<_> = reports.into_iter().map(Vec::into_iter).collect();
    let frame = |_| {
        let all: Vec<_> = of_ranks.iter_mut().filter_map(Iterator::next).collect();
        // If ranks share processors, rank 0 may be the last to begin.
        let begin = all.iter().map(|rank| rank.1).min();
        let whole = all.first().map(|first| first.2).zip(begin).map(|(end, begin)| end - begin);
        let milliseconds = whole.map_or(0.0, |whole| whole.as_secs_f64() * 1e3);
        let ranks_of_frame = all.into_iter().map(|rank| rank.0).collect();
        let edge = tile_edge(scene, settings, ranks.sharing.organisation, ranks.count);
        FrameReport::new(ranks.sharing, edge, settings, milliseconds, ranks_of_frame)
    };
    Ok((cameras.iter().map(frame).collect(), Trace { ranks: timelines }))
}

/// Draws one picture; its stats are [`FrameReport::stats`].
///
/// # Errors
/// As [`draw_frames`].
///
/// # Panics
/// If there are no ranks.
pub fn draw(
    ranks: Ranks,
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
) -> Result<(Frame, FrameReport), ParallelError> {
    Crew::default().draw(ranks, scene, camera, settings)
}
