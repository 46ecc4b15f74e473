//! Predicts times from counts and costs: one process with several threads.

use serde::Serialize;
use tercio_raster::tally::batches;

use super::counts::{Counted, Counters, TileWork};
use crate::machines::{Machine, MachineError, Operation};

/// Which part of a frame a cost belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// The fixed cost of every frame, whatever is drawn.
    Frame,
    /// Clusters tested and sorted into tiles, whole or triangle by triangle.
    FrontEnd,
    /// Clusters of the tiles: hidden ones found, vertices transformed, triangles tested.
    Geometry,
    /// Set-up, samples and depths.
    Raster,
    /// Shading.
    Shading,
    /// Waiting for lines of memory that the caches do not hold.
    Memory,
    /// Tiles and pixels cleared and written.
    Picture,
}

/// Bytes of the caches that are available to a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Caches {
    /// Private caches of all threads together.
    pub own: f64,
    /// Shared caches.
    pub shared: f64,
    /// The part of them that pictures and messages of ranks stay in.
    pub exchange: f64,
}

impl Caches {
    /// The caches of `threads` processors of a machine. Unlimited if the description gives none.
    pub fn of(machine: &Machine, threads: usize) -> Self {
        let p = &machine.processors;
        let bytes = |cache: &Option<_>| cache.as_ref().map(|c: &crate::machines::Sourced<_>| c.value);
        let shared = bytes(&p.shared_cache).unwrap_or(f64::INFINITY);
        Self {
            own: bytes(&p.own_cache).map_or(f64::INFINITY, |b| b * threads as f64),
            shared,
            exchange: bytes(&p.exchange_cache).unwrap_or(EXCHANGE_SHARE * shared),
        }
    }
}

/// The share of a cache that is available to pictures and messages of ranks if nobody measured it; the model, the bins and other
/// programs take the rest.
const EXCHANGE_SHARE: f64 = 0.5;

/// Bytes of a line of memory.
const LINE: f64 = 64.0;

/// Lines of a frame's memory that miss a cache of `cache` bytes when the frame is drawn repeatedly.
fn missed_lines(touched: u64, cache: f64) -> f64 {
    ((touched as f64 - cache) / LINE).max(0.0)
}

/// The operations of a frame with the number of times each is charged.
pub fn charges(c: &Counters, caches: Caches) -> [(Phase, Operation, f64); 30] {
    use Operation as O;
    use Phase as P;
    let whole = (16 * c.whole_blocks) as f64;
    let n = |count: u64| count as f64;
    [
        (P::Frame, O::Frame, 1.0),
        (P::FrontEnd, O::Cluster, n(c.clusters)),
        (P::FrontEnd, O::ClusterEntry, n(c.cluster_entries)),
        (P::FrontEnd, O::ClusterApart, n(c.clusters_apart)),
        (P::FrontEnd, O::Polygon, n(c.triangles_apart)),
        (P::FrontEnd, O::PolygonSetUp, n(c.triangles_binned)),
        (P::FrontEnd, O::Entry, n(c.entries)),
        (P::Geometry, O::ClusterHidden, n(c.clusters_hidden)),
        (P::Geometry, O::HiddenStamp, n(c.hidden_stamps)),
        (P::Geometry, O::ClusterDrawn, n(c.clusters_drawn)),
        (P::Geometry, O::Vertex, n(c.vertices)),
        (P::Geometry, O::ClusterTriangle, n(c.triangles_in)),
        (P::Raster, O::SetUp, n(c.set_ups)),
        (P::Raster, O::SampleStep, n(c.steps)),
        (P::Raster, O::ClusterStamp, n(c.stamps - c.stamps_alone)),
        (P::Raster, O::DrawnEntry, n(c.entries_drawn)),
        (P::Raster, O::Stamp, n(c.stamps_alone)),
        (P::Raster, O::Pixel, n(c.samples_covered)),
        (P::Shading, O::ClusterShaded, n(c.clusters_won)),
        (P::Shading, O::Shading, n(c.shadings)),
        (P::Shading, O::PlaneShading, n(c.shadings_by_plane)),
        (P::Shading, O::ColoredShading, n(c.shadings_colored)),
        (P::Shading, O::ColoredPixel, n(c.pixels_colored)),
        (P::Shading, O::ColoredVertex, n(c.vertices_colored)),
        (P::Shading, O::WholeBlock, n(c.whole_blocks)),
        (P::Shading, O::ShadedPixel, n(c.pixels_shaded_late) - whole),
        (P::Memory, O::CacheLine, missed_lines(c.bytes_touched, caches.own)),
        (P::Memory, O::MemoryLine, missed_lines(c.bytes_touched, caches.shared)),
        (P::Picture, O::TileSample, n(c.tile_samples)),
        (P::Picture, O::PicturePixel, n(c.pixels)),
    ]
}

/// Whether clusters have a cost. The documents' machines have costs of polygons only.
pub fn knows_clusters(machine: &Machine) -> bool {
    machine.seconds(Operation::ClusterDrawn).is_some()
}

/// Checks that a description has costs of geometry and of rasterization. Others may be missing: a fit that made them
/// zero leaves them out.
///
/// # Errors
/// [`MachineError::Missing`] with the names of those that would do.
pub fn need_costs(machine: &Machine) -> Result<(), MachineError> {
    use Operation as O;
    machine.need_costs(&[&[O::Polygon, O::ClusterDrawn], &[O::Pixel, O::Stamp, O::Segment, O::SampleStep]])
}

/// Work of a frame that a description charges nothing for, because it is from before calibrations measured it, where that makes a
/// difference: colours of pixels, clusters that are taken apart, and, if no two triangles share a vertex (`is_loose`), the stamps of
/// hidden clusters, which are few in other models; not what occurs less than [`FEW`] times. A calibrated machine without one of these
/// costs is one whose fit made it zero, and a machine without costs of clusters does not draw like the renderer.
pub fn uncharged(machine: &Machine, c: &Counters, is_loose: bool) -> Vec<(Operation, u64)> {
    if machine.calibration.is_some() || !knows_clusters(machine) {
        return Vec::new();
    }
    let occur = [
        (Operation::HiddenStamp, if is_loose { c.hidden_stamps } else { 0 }),
        (Operation::ColoredShading, c.shadings_colored),
        (Operation::ClusterApart, c.clusters_apart),
    ];
    occur.into_iter().filter(|(o, count)| *count >= FEW && !machine.costs.contains_key(o)).collect()
}

/// Fewer make no difference: calibrations have found costs of less than 100 ns each; 100 us is about what a thread takes to wake up.
const FEW: u64 = 1000;

/// A predicted frame in seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct FrameTime {
    /// Clusters tested and sorted into tiles, whole or triangle by triangle.
    pub front_end: f64,
    /// Clusters of the tiles up to their triangles.
    pub geometry: f64,
    /// Set-up, samples and depths.
    pub raster: f64,
    /// Shading.
    pub shading: f64,
    /// Waiting for memory.
    pub memory: f64,
    /// The fixed cost, and clearing and writing the picture.
    pub picture: f64,
    /// The additional time because one thread draws alone until the others have woken up.
    pub waking: f64,
    /// Busiest over mean thread while tiles are drawn.
    pub imbalance: f64,
}

impl FrameTime {
    /// On one thread.
    pub fn on_one_thread(machine: &Machine, c: &Counters) -> Self {
        Self::charged(machine, c, Caches::of(machine, 1))
    }

    fn charged(machine: &Machine, c: &Counters, caches: Caches) -> Self {
        let mut time = Self { imbalance: 1.0, ..Self::default() };
        for (phase, operation, count) in charges(c, caches) {
            let seconds = machine.seconds_or_0(operation) * count;
            *match phase {
                Phase::FrontEnd => &mut time.front_end,
                Phase::Geometry => &mut time.geometry,
                Phase::Raster => &mut time.raster,
                Phase::Shading => &mut time.shading,
                Phase::Memory => &mut time.memory,
                Phase::Frame | Phase::Picture => &mut time.picture,
            } += seconds;
        }
        if machine.seconds(Operation::WholeBlock).is_none() {
            // A machine without a cost of such blocks shades their pixels one by one.
            time.shading += machine.seconds_or_0(Operation::ShadedPixel) * (16 * c.whole_blocks) as f64;
        }
        time
    }

    /// On several threads: the front end is divided into batches, the back end into tiles, which threads take one after
    /// another; the serial share of the description is not divided, and memory is read at most at the bandwidth of all
    /// threads together. Until the others have woken up, the first thread works alone: of the work of n threads that
    /// takes them a time t, it does its own n-th part and that of the others one after the other. A frame that is shorter
    /// than that is one thread's.
    pub fn on_threads(machine: &Machine, counted: &Counted, threads: usize) -> Self {
        let threads = threads.max(1);
        let c = &counted.frame;
        let one = Self::charged(machine, c, Caches::of(machine, threads));
        let frame = machine.seconds_or_0(Operation::Frame);
        let serial = machine.processors.serial.as_ref().map_or(0.0, |s| s.value);
        let scale = |divided: f64| serial + (1.0 - serial) * divided;

        let front = scale(if knows_clusters(machine) {
            let batches = batches(c.clusters as usize, threads).max(1);
            batches.div_ceil(threads) as f64 / batches as f64
        } else {
            // How it distributes polygons is unknown.
            1.0 / threads as f64
        });
        let busiest = busiest_thread(machine, &one, counted, threads);
        let back = scale(busiest);
        let missed = missed_lines(c.bytes_touched, Caches::of(machine, threads).shared) * LINE;
        let bandwidth = machine.processors.memory_bandwidth.as_ref().map_or(f64::INFINITY, |b| b.value);
        let alone = one.total();
        let time = Self {
            front_end: one.front_end * front,
            geometry: one.geometry * back,
            raster: one.raster * back,
            shading: one.shading * back,
            memory: (one.memory * back).max(missed / bandwidth),
            picture: frame + (one.picture - frame) * back,
            waking: 0.0,
            imbalance: busiest * threads as f64,
        };
        let gain = (alone - time.total()).max(0.0);
        Self { waking: waking(machine, threads).min(gain), ..time }
    }

    /// Without the time in which threads wake up: what grows with the work.
    pub fn awake(&self) -> f64 {
        self.total() - self.waking
    }

    /// The whole frame.
    pub fn total(&self) -> f64 {
        self.front_end + self.geometry + self.raster + self.shading + self.memory + self.picture + self.waking
    }
}

/// The seconds that a frame of so many threads takes longer because the others have to wake up, if it is long enough.
pub fn waking(machine: &Machine, threads: usize) -> f64 {
    let wake_up = machine.processors.wake_up.as_ref().map_or(0.0, |w| w.value);
    wake_up * (1.0 - 1.0 / threads.max(1) as f64)
}

/// The busiest thread's share of the work on the tiles: a free thread takes the longest tile that is left, and tiles that all draw
/// together come first. Of these, one thread merges what the others have drawn, shades it and writes the pixels.
fn busiest_thread(machine: &Machine, one: &FrameTime, counted: &Counted, threads: usize) -> f64 {
    let read = counted.frame.bytes_read.max(1) as f64;
    let fits = Caches { own: f64::INFINITY, shared: f64::INFINITY, exchange: f64::INFINITY };
    let frame = machine.seconds_or_0(Operation::Frame);
    // All of a tile, and of that the end, which one thread does.
    let seconds = |tile: &TileWork| {
        let memory = one.memory * tile.counters.bytes_read as f64 / read;
        let time = FrameTime::charged(machine, &tile.counters, fits);
        (time.total() - frame + memory, time.shading + time.picture - frame)
    };
    let (mut all, mut busy) = (0.0, vec![0.0f64; threads]);
    for tile in &counted.tiles {
        let (seconds, end) = seconds(tile);
        all += seconds;
        if tile.is_shared {
            busy.iter_mut().for_each(|b| *b += (seconds - end) / threads as f64 + end);
        }
    }
    let mut alone: Vec<f64> =
        counted.tiles.iter().filter(|t| !t.is_shared).map(|tile| seconds(tile).0).collect();
    alone.sort_by(|a, b| b.total_cmp(a));
    for seconds in alone {
        if let Some(free) = busy.iter_mut().min_by(|a, b| a.total_cmp(b)) {
            *free += seconds;
        }
    }
    let busiest = busy.iter().copied().fold(0.0, f64::max);
    if all > 0.0 { busiest / all } else { 1.0 / threads as f64 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machines::{Sourced, builtin};

    fn tile(clusters_drawn: u64, is_shared: bool) -> TileWork {
        TileWork { counters: Counters { clusters_drawn, ..Counters::default() }, is_shared }
    }

    #[test]
    fn threads_wait_for_the_fullest_tile() {
        let machine = builtin("two-core-2026").unwrap().unwrap();
        let one = FrameTime::default();
        let share = |tiles: &[TileWork], threads| {
            let frame = Counters { clusters_drawn: 12, ..Counters::default() };
            busiest_thread(&machine, &one, &Counted { frame, tiles: tiles.to_vec() }, threads)
        };
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-9, "{a} {b}");
        near(share(&[tile(4, false), tile(4, false), tile(4, false)], 1), 1.0);
        near(share(&[tile(4, false), tile(4, false), tile(4, false)], 2), 8.0 / 12.0);
        near(share(&[tile(2, false), tile(8, false), tile(2, false)], 4), 8.0 / 12.0);
        near(share(&[tile(2, false), tile(8, true), tile(2, false)], 4), 4.0 / 12.0);
        // The longest tile is begun first, wherever it is.
        near(share(&[tile(2, false), tile(2, false), tile(8, false)], 2), 8.0 / 12.0);
        // Shading a tile that all have drawn is one thread's.
        let shadings = 8;
        let shaded = TileWork { counters: Counters { shadings, ..Counters::default() }, is_shared: true };
        near(share(&[shaded], 4), 1.0);
        let [cluster, shading] =
            [Operation::ClusterDrawn, Operation::Shading].map(|o| machine.seconds(o).unwrap());
        let both = TileWork {
            counters: Counters { shadings, clusters_drawn: 8, ..Counters::default() },
            is_shared: true,
        };
        near(share(&[both], 4), (cluster / 4.0 + shading) / (cluster + shading));
    }

    #[test]
    fn one_thread_works_alone_until_the_others_have_woken_up() {
        let mut machine = builtin("two-core-2026").unwrap().unwrap();
        machine.processors.serial = None;
        let frame = |clusters_drawn| {
            let half = tile(clusters_drawn / 2, false);
            let frame = Counters { clusters_drawn, ..Counters::default() };
            Counted { frame, tiles: vec![half; 2] }
        };
        let seconds = |machine: &Machine, counted: &Counted, threads| {
            FrameTime::on_threads(machine, counted, threads).total()
        };
        let (long, short) = (frame(100_000), frame(2));
        let [one, two] = [1, 2].map(|threads| seconds(&machine, &long, threads));
        let wake_up = (one - two) / 5.0;
        machine.processors.wake_up = Some(Sourced::new(wake_up, String::new(), String::new()));
        assert_eq!(seconds(&machine, &long, 1), one, "one thread wakes nobody up");
        // In the time until it wakes up, the second thread would have done the same as the first.
        assert!((seconds(&machine, &long, 2) / (two + wake_up / 2.0) - 1.0).abs() < 1e-12);
        let [one, two] = [1, 2].map(|threads| seconds(&machine, &short, threads));
        assert!((two / one - 1.0).abs() < 1e-12, "{two} {one}");
    }

    #[test]
    fn machines_without_costs_are_refused_with_the_keys_that_are_missing() {
        for name in crate::machines::NAMES {
            let machine = builtin(name).unwrap().unwrap();
            let seconds = FrameTime::on_one_thread(
                &machine,
                &Counters {
                    clusters_drawn: 9,
                    vertices: 9,
                    triangles_apart: 9,
                    triangles_binned: 9,
                    samples_covered: 9,
                    stamps: 9,
                    ..Counters::default()
                },
            );
            match need_costs(&machine) {
                Ok(()) => assert!(seconds.total() > 0.0, "{name} has costs of nothing"),
                Err(error) => {
                    let error = error.to_string();
                    assert!(machine.costs.is_empty(), "{error}");
                    assert!(
                        error.contains("costs.polygon or ") && error.contains("costs.pixel or "),
                        "{error}"
                    );
                }
            }
        }
    }

    #[test]
    fn work_that_old_descriptions_do_not_charge_is_named() {
        let c = Counters { hidden_stamps: FEW, shadings_colored: 2 * FEW, ..Counters::default() };
        let machine = builtin("two-core-2026").unwrap().unwrap();
        let both = [(Operation::HiddenStamp, FEW), (Operation::ColoredShading, 2 * FEW)];
        assert_eq!(uncharged(&machine, &c, true), both);
        assert_eq!(uncharged(&machine, &c, false), both[1..]);
        let few = Counters { hidden_stamps: FEW - 1, clusters_apart: FEW - 1, ..Counters::default() };
        assert!(uncharged(&machine, &few, true).is_empty(), "what occurs rarely costs next to nothing");
        let polygons = builtin("hybris-single-cpu").unwrap().unwrap();
        assert!(uncharged(&polygons, &c, true).is_empty(), "a machine that draws without clusters");
        let mut with = machine.clone();
        let cost = with.costs[&Operation::Shading].clone();
        with.costs.insert(Operation::HiddenStamp, cost);
        assert_eq!(uncharged(&with, &c, true), both[1..]);
        let share = || Sourced::new(0.1, String::new(), String::new());
        let calibrated = crate::machines::Calibration {
            date: String::new(),
            processor: String::new(),
            version: String::new(),
            frames: Sourced::new(9.0, "9".into(), String::new()),
            residual: share(),
            worst_residual: share(),
            spread: share(),
            doubt: None,
        };
        assert!(uncharged(&Machine { calibration: Some(calibrated), ..machine }, &c, true).is_empty());
    }

    #[test]
    fn memory_takes_time_only_if_the_caches_are_too_small() {
        let c = Counters { bytes_touched: 10_000, ..Counters::default() };
        let lines = |own: f64, shared: f64| {
            let of = |o| move |c: &(Phase, Operation, f64)| c.1 == o;
            let all = charges(&c, Caches { own, shared, exchange: shared });
            [Operation::CacheLine, Operation::MemoryLine].map(|o| all.iter().find(|c| of(o)(c)).unwrap().2)
        };
        assert_eq!(lines(10_000.0, 20_000.0), [0.0, 0.0]);
        assert_eq!(lines(3_600.0, 6_800.0), [100.0, 50.0]);
    }
}
