//! The real renderer's counters and times.

use std::time::Instant;

use serde::Serialize;
use tercio_raster::{Frame, FrameStats, Renderer, Settings, Sorting};
use tercio_scene::{Camera, Scene};

use super::PredictError;

/// Which clock times frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Clock {
    /// Wall time: the truth on a machine that does nothing else.
    Wall,
    /// Processor time of this process divided by its threads: for machines that others use at the same time. It does
    /// not see threads that wait.
    Processor,
}

/// A frame as it was measured.
#[derive(Clone, Debug)]
pub struct Measured {
    /// Counters of the renderer; its times are of the last frame.
    pub stats: FrameStats,
    /// Seconds of the fastest frame by the clock asked for.
    pub seconds: f64,
}

/// The renderer's counters under the names of [`super::counters::Counters::comparable`].
pub fn counted(stats: &FrameStats) -> [(&'static str, u64); 7] {
    [
        ("triangles", stats.frontend.triangles_in),
        ("triangles drawn", stats.binning.triangles),
        ("entries", stats.binning.entries),
        ("tiles used", stats.binning.tiles_used),
        ("largest tile", stats.binning.largest_tile),
        ("samples covered", stats.backend.samples_covered),
        ("pixels shown", stats.backend.pixels_shaded),
    ]
}

/// Seconds of processor time of this process; `None` where the system does not tell.
fn processor_time() -> Option<f64> {
    #[cfg(unix)]
    {
        let t = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
        Some(t.tv_sec as f64 + t.tv_nsec as f64 * 1e-9)
    }
    #[cfg(not(unix))]
    None
}

/// Draws a frame some times on a pool of `threads` threads; the first, which takes memory, is not timed.
///
/// Every triangle is sorted by itself: that is the sort-middle pipeline of the documents, and what the model counts.
///
/// # Errors
/// [`PredictError`].
pub fn measure(
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    threads: usize,
    frames: u32,
    clock: Clock,
) -> Result<Measured, PredictError> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|e| PredictError::Threads(threads, e))?;
    let start = Instant::now();
    let settings = &Settings { sorting: Sorting::Triangles, ..settings.clone() };
    let now = || {
        match clock {
            Clock::Processor => processor_time().map(|t| t / threads as f64),
            Clock::Wall => None,
        }
        .unwrap_or_else(|| start.elapsed().as_secs_f64())
    };
    pool.install(|| {
        let (mut renderer, mut frame) = (Renderer::new(), Frame::default());
        renderer.render_into(scene, camera, settings, &mut frame)?;
        let mut seconds = f64::INFINITY;
        for _ in 0..frames.max(1) {
            let begin = now();
            renderer.render_into(scene, camera, settings, &mut frame)?;
            seconds = seconds.min(now() - begin);
        }
        Ok(Measured { stats: frame.stats.clone(), seconds })
    })
}
