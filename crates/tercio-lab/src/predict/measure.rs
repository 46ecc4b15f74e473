//! Measures the real renderer's counters and times.

use std::time::Instant;

use serde::Serialize;
use tercio_parallel::placement;
use tercio_raster::{Frame, FrameStats, Renderer, Settings};
use tercio_scene::{Camera, Scene};

use super::PredictError;

/// Which clock times frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Clock {
    /// Wall time: correct on a machine that is otherwise idle.
    Wall,
    /// Processor time of this process divided by its threads: for machines with other load. It ignores threads that
    /// wait.
    Processor,
}

/// A measured frame.
#[derive(Clone, Debug)]
pub struct Measured {
    /// Counters of the renderer; its times are of the last frame.
    pub stats: FrameStats,
    /// Seconds of the fastest frame by the chosen clock.
    pub seconds: f64,
}

/// Seconds of processor time of this process; `None` where the system does not report it.
pub fn processor_time() -> Option<f64> {
    #[cfg(unix)]
    {
        let t = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
        Some(t.tv_sec as f64 + t.tv_nsec as f64 * 1e-9)
    }
    #[cfg(not(unix))]
    None
}

/// Draws a frame several times on a pool of `threads` threads, which start on processors of their own, as those of the
/// program do; the first frame, which allocates memory, is not timed.
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
    let builder = rayon::ThreadPoolBuilder::new().num_threads(threads);
    let pool = placement::spread(builder, placement::current()).build();
    let pool = pool.map_err(|e| PredictError::Threads(threads, e))?;
    let start = Instant::now();
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
