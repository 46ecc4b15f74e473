//! The description of this machine: memory, costs of the renderer's work, messages between its threads.

use std::collections::BTreeMap;
use std::hint::black_box;
use std::sync::Arc;
use std::sync::mpsc::channel;
use std::time::Instant;

use serde::Serialize;
use tercio_mesh::cluster::{PartitionOptions, partition};
use tercio_mesh::{Mesh, builtin};
use tercio_raster::Settings;

use super::counters::{Counters, Picture, count};
use super::frame::charges;
use super::measure::{Clock, measure};
use super::{PredictError, fit, views};
use crate::machines::{
    DataKind, Machine, Network, Operation, Processors, ScreenDivision, Sorting, SortingClass, Sourced,
    Topology,
};

/// Models that costs are fitted to, from few large triangles to many small ones.
pub const MODELS: [&str; 6] = [
    "builtin:sphere@2k",
    "builtin:sphere@200k",
    "builtin:teapot@30k",
    "builtin:gyroid@100k",
    "builtin:terrain@150k",
    "builtin:gyroid@400k",
];
/// Sizes of their pictures.
pub const SIZES: [(u32, u32); 3] = [(256, 256), (640, 480), (1200, 1000)];

/// What is measured and how.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Options {
    /// Threads of the machine.
    pub threads: usize,
    /// Frames of which the fastest counts.
    pub frames: u32,
    /// Which clock times frames. Processor time does not see threads that wait: the serial share is then too small.
    pub clock: Clock,
}

/// A measured frame and what it amounts to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Sample {
    /// Model.
    pub model: String,
    /// Picture.
    pub picture: Picture,
    /// Its counts.
    pub counters: Counters,
    /// Seconds on one thread.
    pub seconds: f64,
    /// Seconds by the costs that were fitted.
    pub fitted: f64,
}

/// The machine, and what its costs were fitted to.
#[derive(Clone, Debug)]
pub struct Calibration {
    /// The description.
    pub machine: Machine,
    /// The frames.
    pub samples: Vec<Sample>,
}

/// Measures this machine. `tell` is told what is measured next.
///
/// # Errors
/// [`PredictError`].
pub fn calibrate(o: Options, mut tell: impl FnMut(&str)) -> Result<Calibration, PredictError> {
    let mut samples = Vec::new();
    let (mut alone, mut together) = (0.0, 0.0);
    for model in MODELS {
        tell(model);
        // The names are ours; a model that cannot be made takes no part.
        let Ok(mesh) = builtin::make(model) else { continue };
        let bounds = mesh.bounds();
        let scene = views::scene(Arc::new(partition(mesh, &PartitionOptions::default())));
        for size in SIZES {
            let camera = views::camera(&bounds, size, 1, 7);
            let settings = Settings::new(size.0, size.1);
            let one = measure(&scene, &camera, &settings, 1, o.frames, o.clock)?;
            if o.threads > 1 {
                alone += one.seconds;
                together += measure(&scene, &camera, &settings, o.threads, o.frames, o.clock)?.seconds;
            }
            let tile = one.stats.tile_size;
            let picture = Picture { width: size.0, height: size.1, tile, exact_binning: true };
            let (counters, _) = count(&scene, &camera, picture)?;
            samples.push(Sample {
                model: model.into(),
                picture,
                counters,
                seconds: one.seconds,
                fitted: 0.0,
            });
        }
    }
    tell("memory and messages");
    let rows: Vec<Vec<f64>> =
        samples.iter().map(|s| charges(&s.counters).map(|c| c.1 as f64).to_vec()).collect();
    let times: Vec<f64> = samples.iter().map(|s| s.seconds).collect();
    let fitted = fit::costs(&rows, &times);
    for (sample, row) in samples.iter_mut().zip(&rows) {
        sample.fitted = row.iter().zip(&fitted).map(|(count, cost)| count * cost).sum();
    }
    let operations = charges(&Counters::default()).map(|c| c.0);
    let costs: Vec<_> = operations.into_iter().zip(fitted).filter(|c| c.1 > 0.0).collect();
    let serial = serial_share(alone, together, o.threads);
    Ok(Calibration { machine: description(o, &costs, serial), samples })
}

/// The share of the work that is not divided, by Amdahl's law from the times of one thread and of several; 0 where
/// there is only one, or where the speed-up is more than linear.
fn serial_share(alone: f64, together: f64, threads: usize) -> f64 {
    if threads < 2 || alone <= 0.0 {
        return 0.0;
    }
    let n = threads as f64;
    ((together / alone - 1.0 / n) / (1.0 - 1.0 / n)).clamp(0.0, 1.0)
}

fn description(o: Options, costs: &[(Operation, f64)], serial: f64) -> Machine {
    let measured = "measured by tercio lab calibrate";
    let rate = |value: f64| Sourced::new(value, format!("{:.4} GB/s", value / 1e9), measured.to_string());
    let count = |n: usize| Sourced::new(n as f64, n.to_string(), measured.to_string());
    let fitted = format!("fitted by tercio lab calibrate to {} frames", MODELS.len() * SIZES.len());
    // Tenths of a picosecond.
    let cost = |seconds: f64| Sourced::new(seconds, format!("{:.4} ns", seconds * 1e9), fitted.clone());
    let mut all: BTreeMap<_, _> = costs.iter().map(|&(o, s)| (o, cost(s))).collect();
    all.insert(Operation::CompositePixel, {
        let seconds = composite_seconds();
        Sourced::new(seconds, format!("{:.4} ns", seconds * 1e9), measured.into())
    });
    let (latency, bandwidth) = messages();
    let bytes = |n: f64, source: &str| Sourced::new(n, format!("{n} B"), source.to_string());
    Machine {
        name: "This machine".into(),
        summary: "Measured by tercio lab calibrate; clusters to tiles on all processors.".into(),
        sorting: Sorting {
            class: SortingClass::SortMiddle,
            screen: ScreenDivision::Tiles,
            how: "Clusters are transformed on any thread, triangles sorted into tiles, tiles drawn on any thread."
                .into(),
            source: "ARCHITECTURE.md".into(),
        },
        processors: Processors {
            count: count(o.threads),
            at_most: None,
            clock: None,
            memory: None,
            memory_bandwidth: Some(rate(memory_bandwidth(o.threads))),
            per_node: None,
            serial: Some(Sourced::new(serial, format!("{:.2} %", serial * 100.0), measured.into())),
        },
        screen: None,
        network: Some(Network {
            topology: Topology::Crossbar,
            bandwidth: rate(bandwidth),
            hop: Sourced::new(0.0, "0 s".into(), "threads of one process: no switch between them".into()),
            message: Sourced::new(latency, format!("{:.3} us", latency * 1e6), measured.into()),
        }),
        bytes: BTreeMap::from([
            (DataKind::Primitive, bytes(13.0, "ARCHITECTURE.md: 12 B a cluster vertex, about 0.5 of them and 7 B a triangle")),
            (DataKind::Descriptor, bytes(64.0, "ARCHITECTURE.md: edges and depth plane of a small triangle")),
            (DataKind::Sample, bytes(8.0, "colour and depth, 4 B each")),
        ]),
        costs: all,
        heap: None,
        sdram: None,
        tile_engine: None,
        transfer: None,
        claims: BTreeMap::new(),
    }
}

/// The fastest of some runs, in seconds.
fn fastest(runs: usize, mut run: impl FnMut()) -> f64 {
    let time = |()| {
        let begin = Instant::now();
        run();
        begin.elapsed().as_secs_f64()
    };
    std::iter::repeat_n((), runs).map(time).fold(f64::INFINITY, f64::min)
}

/// Bytes a second that all threads read from memory together.
fn memory_bandwidth(threads: usize) -> f64 {
    // Larger than caches are.
    const WORDS: usize = 1 << 24;
    let data: Vec<u64> = (0..WORDS as u64).collect();
    let share = WORDS.div_ceil(threads);
    let seconds = fastest(5, || {
        std::thread::scope(|scope| {
            for part in data.chunks(share) {
                scope.spawn(move || black_box(part.iter().fold(0u64, |sum, w| sum.wrapping_add(*w))));
            }
        });
    });
    (WORDS * 8) as f64 / seconds
}

/// Seconds of merging one pixel of two pictures by depth.
fn composite_seconds() -> f64 {
    const PIXELS: usize = 1 << 20;
    let other: Vec<(f32, u32)> = (0..PIXELS).map(|k| ((k % 7) as f32, k as u32)).collect();
    let mut own: Vec<(f32, u32)> = (0..PIXELS).map(|k| ((k % 5) as f32, k as u32)).collect();
    let seconds = fastest(5, || {
        own.iter_mut().zip(&other).for_each(|(a, b)| {
            if b.0 > a.0 {
                *a = *b;
            }
        });
        black_box(&own);
    });
    seconds / PIXELS as f64
}

/// Seconds of a small message between two threads, and bytes a second of large ones, both by sending to and fro.
fn messages() -> (f64, f64) {
    const LARGE: usize = 16 << 20;
    let round_trips = |bytes: usize, trips: usize| {
        let ((there, arrived), (back, returned)) = (channel::<Vec<u8>>(), channel::<Vec<u8>>());
        std::thread::scope(|scope| {
            scope.spawn(move || {
                // A message is copied where it arrives, as between processes.
                arrived.iter().try_for_each(|m| back.send(m.clone())).ok();
            });
            let message = vec![1u8; bytes];
            let seconds = fastest(5, || {
                for _ in 0..trips {
                    if there.send(message.clone()).is_ok() {
                        black_box(returned.recv().ok());
                    }
                }
            });
            drop(there);
            seconds / (2 * trips) as f64
        })
    };
    let latency = round_trips(8, 200);
    let large = round_trips(LARGE, 4);
    (latency, LARGE as f64 / (large - latency).max(f64::MIN_POSITIVE))
}

/// A scene that is drawn as `tercio bench` draws it.
pub fn prepare(mesh: Mesh) -> (tercio_scene::Scene, tercio_mesh::Aabb) {
    let bounds = mesh.bounds();
    (views::scene(Arc::new(partition(mesh, &PartitionOptions::default()))), bounds)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machines::parse;

    #[test]
    fn a_serial_share_follows_from_two_times() {
        assert_eq!(serial_share(2.0, 1.0, 2), 0.0);
        assert_eq!(serial_share(2.0, 2.0, 2), 1.0);
        assert!((serial_share(1.0, 0.55, 2) - 0.1).abs() < 1e-12);
        assert_eq!(serial_share(2.0, 0.9, 2), 0.0);
    }

    #[test]
    fn what_is_measured_is_a_description() {
        let costs = [(Operation::Frame, 1e-5), (Operation::Polygon, 3e-9)];
        let options = Options { threads: 2, frames: 1, clock: Clock::Wall };
        let machine = description(options, &costs, 0.05);
        let text = machine.to_toml().unwrap();
        let again = parse("this.toml", &text).unwrap_or_else(|e| panic!("{e}\n{text}"));
        assert!((again.seconds(Operation::Polygon).unwrap() - 3e-9).abs() < 1e-12);
        assert!(again.processors.memory_bandwidth.unwrap().value > 1e8);
        assert!(again.network.unwrap().bandwidth.value > 1e6);
    }
}
