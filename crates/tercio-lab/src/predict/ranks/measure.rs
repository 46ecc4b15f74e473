//! Measures ranks that draw, threads of this process or processes: their times, counters, and page faults and context
//! switches.

use std::sync::Mutex;

use tercio_parallel::organisation::{Rank, Task};
use tercio_parallel::report::{RankStages, Stage};
use tercio_parallel::{Communicator, FrameReport, ParallelError, Ranks, between_processes, draw_frames};
use tercio_raster::{Frame, Settings};
use tercio_scene::{Camera, Scene};

use super::traffic::Sharing;
use crate::predict::difference::RANK_TERMS;
use crate::predict::usage::Usage;

/// Frames that allocate memory and fill caches; they are not evaluated.
const WARM_UP: usize = 2;

/// Several frames of one picture.
#[derive(Clone, Debug, Default)]
pub struct MeasuredRanks {
    /// The frames' reports.
    pub reports: Vec<FrameReport>,
    /// Page faults and context switches of each.
    pub usage: Vec<Usage>,
}

impl MeasuredRanks {
    /// Draws a picture several times with threads of this process.
    ///
    /// # Errors
    /// [`ParallelError`].
    pub fn draw(
        scene: &Scene,
        camera: &Camera,
        sharing: &Sharing,
        frames: u32,
    ) -> Result<Self, ParallelError> {
        let settings = settings(sharing);
        let cameras = vec![*camera; frames.max(1) as usize + WARM_UP];
        let ranks = Ranks { count: sharing.ranks, threads: 1, sharing: sharing.of_ranks() };
        // Rank 0 reads the counts while the others wait for the next frame.
        let seen = Mutex::new(Vec::new());
        let look = || seen.lock().unwrap_or_else(|e| e.into_inner()).push(Usage::now());
        let mut reports = draw_frames(ranks, scene, &cameras, &settings, |_, _| look())?;
        reports.drain(..WARM_UP.min(reports.len()));
        let seen = seen.into_inner().unwrap_or_else(|e| e.into_inner());
        Ok(Self { reports, usage: of_frames(&seen) })
    }

    /// The same with processes: all of them call this with the same picture, and rank 0 gets the frames. Each of them
    /// draws with the threads of the pool that this is called in, usually only the calling thread.
    ///
    /// # Errors
    /// [`ParallelError`].
    pub fn draw_between(
        comm: &mut impl Communicator,
        scene: &Scene,
        camera: &Camera,
        sharing: &Sharing,
        frames: u32,
    ) -> Result<Self, ParallelError> {
        let settings = settings(sharing);
        let task = Task { sharing: sharing.of_ranks(), scene, camera, settings: &settings };
        let (mut own, mut frame) = (Rank::new(), Frame::default());
        own.tell_partners(false);
        let (mut reports, mut seen) = (Vec::new(), Vec::new());
        for _ in 0..frames.max(1) as usize + WARM_UP {
            reports.extend(between_processes::draw_frame(&mut own, comm, &task, &mut frame)?);
            seen.extend(usage_of_all(comm)?);
        }
        reports.drain(..WARM_UP.min(reports.len()));
        Ok(Self { reports, usage: of_frames(&seen) })
    }

    /// Adds frames of the same picture.
    pub fn add(&mut self, o: Self) {
        self.reports.extend(o.reports);
        self.usage.extend(o.usage);
    }

    /// Seconds of processor time of a rank's stage, the minimum over the frames.
    pub fn busy(&self, rank: usize, of: impl Fn(&RankStages) -> &Stage) -> f64 {
        let of_frame = |r: &FrameReport| of(&r.ranks[rank].stages).busy_milliseconds * 1e-3;
        self.reports.iter().map(of_frame).fold(f64::INFINITY, f64::min)
    }

    /// Seconds that rank 0 waited for messages, the median over the frames.
    pub fn waited(&self) -> f64 {
        median(self.reports.iter().filter_map(|r| Some(r.ranks.first()?.stages.wait.milliseconds * 1e-3)))
    }

    /// Seconds of the fastest frame, by wall time.
    pub fn fastest(&self) -> f64 {
        self.reports.iter().map(|r| r.milliseconds * 1e-3).fold(f64::INFINITY, f64::min)
    }

    /// What rank 0 did in the fastest frame, in seconds: dividing the picture, drawing, composing and collecting by processor time, waiting
    /// for messages, and the rest, in which it was not running.
    pub fn terms_of_the_fastest(&self) -> [f64; RANK_TERMS.len()] {
        let fastest = self.reports.iter().min_by(|a, b| a.milliseconds.total_cmp(&b.milliseconds));
        let Some((frame, first)) = fastest.and_then(|f| Some((f, f.ranks.first()?))) else {
            return [0.0; RANK_TERMS.len()];
        };
        let s = &first.stages;
        let busy = [&s.redistribute, &s.draw, &s.compose, &s.collect].map(|stage| stage.busy_milliseconds);
        let rest = frame.milliseconds - s.wait.milliseconds - busy.iter().sum::<f64>();
        let [divide, draw, compose, collect] = busy;
        [divide, draw, compose, collect, s.wait.milliseconds, rest].map(|ms| ms * 1e-3)
    }

    /// Medians over the frames: page faults; context switches.
    pub fn usage(&self) -> [f64; 2] {
        let of = |of: fn(&Usage) -> u64| median(self.usage.iter().map(|u| of(u) as f64));
        [of(|u| u.page_faults), of(|u| u.waits + u.preemptions)]
    }
}

fn settings(sharing: &Sharing) -> Settings {
    Settings { tile_size: Some(sharing.edge), ..Settings::one_sample(sharing.size.0, sharing.size.1) }
}

/// Differences of successive counts, one per frame.
fn of_frames(seen: &[Usage]) -> Vec<Usage> {
    seen.windows(2).skip(WARM_UP - 1).map(|w| w[1].since(w[0])).collect()
}

/// Page faults and context switches of all processes so far, for rank 0.
fn usage_of_all(comm: &mut impl Communicator) -> Result<Option<Usage>, ParallelError> {
    let all = between_processes::tell(comm, Usage::now())?;
    Ok(all.map(|all| all.into_iter().fold(Usage::default(), Usage::plus)))
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::median;

    #[test]
    fn medians() {
        assert_eq!(median([5.0, 1.0, 3.0].into_iter()), 3.0);
        assert_eq!(median(std::iter::empty()), 0.0);
    }
}
