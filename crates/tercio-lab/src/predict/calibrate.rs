//! Measures the description of this machine: caches, memory, costs of the renderer's work, messages between its threads
//! and, if they were measured before, over MPI.
//!
//! Costs are fitted to frames that end at different stages ([`LastStage`]), of models and views with different content:
//! few large triangles and many small ones, one layer and many, closed surfaces and triangle soups, smaller and larger
//! than the caches, sorted by clusters and by triangles. So each cost dominates some frames.

use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::sync::Arc;

use serde::Serialize;
use tercio::{LoadOptions, Normals};
use tercio_mesh::Mesh;
use tercio_mesh::cluster::{PartitionOptions, partition};
use tercio_raster::{LastStage, Settings, Sorting as RasterSorting};
use tercio_scene::{Camera, Scene};

use super::counts::{Counted, Counters, count};
use super::frame::{Caches, FrameTime, charges};
use super::hardware::{cache_bytes, composite_seconds, memory_bandwidth, nap_seconds, processor_name};
use super::measure::{Clock, measure};
use super::quoted::date::today;
use super::{PredictError, fit, messages, views};
use crate::machines::{
    self, Control, DataKind, Machine, Network, Operation, Processors, ScreenDivision, Sorting, SortingClass,
    Sourced,
};

/// Models that costs are fitted to, loaded as for `tercio render`.
pub const MODELS: [&str; 11] = [
    "builtin:sphere@2k",
    "builtin:sphere@200k",
    "builtin:teapot@8k",
    "builtin:teapot@30k",
    "builtin:soup@10k",
    "builtin:soup@100k",
    "builtin:gyroid@20k",
    "builtin:gyroid@100k",
    "builtin:terrain@150k",
    "builtin:gyroid@400k",
    "builtin:gyroid@4M",
];
/// Those without normals of their own: they are fitted without normals, too, when planes of triangles shade them.
pub const FLAT_MODELS: [&str; 2] = ["builtin:soup@10k", "builtin:soup@100k"];
/// Sizes of their pictures: one for each tile size that the renderer chooses, except that of the smallest pictures, and a large
/// one.
pub const SIZES: [(u32, u32); 4] = [(256, 256), (640, 480), (1200, 1000), (1920, 1080)];
/// Variants of each picture: what is sorted, and the last stage.
const VARIANTS: [(RasterSorting, LastStage); 8] = [
    (RasterSorting::Clusters, LastStage::Output),
    (RasterSorting::Clusters, LastStage::Visibility),
    (RasterSorting::Clusters, LastStage::Sieve),
    (RasterSorting::Clusters, LastStage::Bin),
    (RasterSorting::Clusters, LastStage::Cull),
    (RasterSorting::Triangles, LastStage::Output),
    (RasterSorting::Triangles, LastStage::Visibility),
    (RasterSorting::Triangles, LastStage::Bin),
];
/// Larger models are not sorted triangle by triangle, which would only take long.
const MOST_SORTED: usize = 1_000_000;

/// Extent and clock of the measurement.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Options {
    /// Threads of the machine.
    pub threads: usize,
    /// Frames in a round; the fastest counts.
    pub frames: u32,
    /// Rounds through all pictures, at least 2: other users of the machine do not disturb every one, and their spread
    /// shows whether they do.
    pub rounds: u32,
    /// Which clock times frames. Processor time ignores threads that wait, so the serial share comes out too small.
    pub clock: Clock,
    /// How often all rounds are repeated, at most, while the measurement is doubtful or too noisy.
    pub repeats: u32,
    /// Whether a measurement is kept that is still too noisy when it was repeated.
    pub accept_noise: bool,
}

/// A measured frame and its counts.
#[derive(Clone, Debug, PartialEq)]
pub struct Sample {
    /// Model.
    pub model: String,
    /// Its settings.
    pub settings: Settings,
    /// Its counts on one thread.
    pub counted: Counted,
    /// Seconds on one thread, of the fastest frame of all rounds.
    pub seconds: f64,
    /// Those of the slowest round's fastest frame.
    pub slowest: f64,
    /// Seconds predicted by the fitted costs.
    pub fitted: f64,
    /// For whole frames: seconds on all threads.
    pub together: Option<f64>,
    /// Its counts on all threads, which may share tiles, if it is a whole frame.
    pub shared: Option<Counted>,
}

/// The machine, and the samples its costs were fitted to.
#[derive(Clone, Debug)]
pub struct Calibration {
    /// The description.
    pub machine: Machine,
    /// The frames.
    pub samples: Vec<Sample>,
}

/// What a calibration reports while it runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Progress<'a> {
    /// What is measured next.
    Next(&'a str),
    /// Why the rounds are repeated: the machine was too busy.
    Repeated(&'a str),
    /// What is still doubtful, or too noisy, of the measurement that is kept.
    Doubtful(&'a str),
}

/// Measures this machine. `mpi` is the network over MPI, if the caller has [measured](messages::measure) it with its
/// ranks. If the measurement is doubtful or too noisy, the rounds are repeated ([`Options::repeats`]); of all the first of the least noise is kept,
/// and its description says what remains doubtful.
///
/// # Errors
/// [`PredictError`]; [`PredictError::Noisy`] if it is still too noisy then.
pub fn calibrate(
    o: Options,
    mpi: Option<Network>,
    mut progress: impl FnMut(Progress<'_>),
) -> Result<Calibration, PredictError> {
    let mut pictures = Vec::new();
    let flat = FLAT_MODELS.map(|model| (model, Normals::File));
    for (model, normals) in MODELS.map(|model| (model, Normals::default())).into_iter().chain(flat) {
        progress(Progress::Next(model));
        // Built-in names; a model that cannot be made is skipped.
        let Ok(loaded) = LoadOptions { normals, ..LoadOptions::default() }.load_mesh(model) else { continue };
        pictures.extend(pictures_of(model, loaded.mesh, o.threads)?);
    }
    let rounds = o.rounds.max(2);
    least_noisy((o.repeats, o.accept_noise), &mut progress, |progress| {
        // A repeat begins anew: one frame that was too fast would keep every spread large.
        for Picture { sample, .. } in &mut pictures {
            (sample.seconds, sample.slowest, sample.together) = (f64::INFINITY, 0.0, None);
        }
        for round in 0..rounds {
            progress(Progress::Next(&format!("round {} of {rounds}", round + 1)));
            pictures.iter_mut().try_for_each(|p| p.draw(o))?;
        }
        progress(Progress::Next("memory and messages"));
        let samples = pictures.iter().map(|p| p.sample.clone()).collect();
        Ok(fitted(description(o, mpi.clone())?, samples, o.threads))
    })
}

/// Measures, at most this many times more, until there is little noise; of all the first of the least noise, which says what is
/// doubtful of it.
fn least_noisy(
    (repeats, accept_noise): (u32, bool),
    progress: &mut impl FnMut(Progress<'_>),
    mut measure: impl FnMut(&mut dyn FnMut(Progress<'_>)) -> Result<Calibration, PredictError>,
) -> Result<Calibration, PredictError> {
    let mut kept = measure(progress)?;
    let mut least = noise(&kept.machine);
    for _ in 0..repeats {
        let (Noise::Doubtful(why) | Noise::TooMuch(why)) = &least else { break };
        progress(Progress::Repeated(why));
        let again = measure(progress)?;
        let noise = noise(&again.machine);
        if noise.level() < least.level() {
            (kept, least) = (again, noise);
        }
    }
    match least {
        Noise::TooMuch(why) if !accept_noise => return Err(PredictError::Noisy(why)),
        Noise::TooMuch(why) | Noise::Doubtful(why) => {
            progress(Progress::Doubtful(&why));
            kept.machine.calibration.iter_mut().for_each(|c| c.doubt = Some(why.clone()));
        }
        Noise::Little => {}
    }
    Ok(kept)
}

/// How much other programs, or other guests of the host, have disturbed a measurement.
#[derive(Clone, Debug, PartialEq)]
enum Noise {
    /// As usual.
    Little,
    /// So much that predictions may miss; the reason.
    Doubtful(String),
    /// So much that it is no property of the machine; the reason.
    TooMuch(String),
}

impl Noise {
    fn level(&self) -> u8 {
        match self {
            Self::Little => 0,
            Self::Doubtful(_) => 1,
            Self::TooMuch(_) => 2,
        }
    }
}

/// The largest median spread of the rounds, root mean square of the residuals, and serial share that are not doubtful, and that are
/// not too noisy. Quiet calibrations of virtual machines with two processors had spreads of 5 to 7 %, residuals of 11 to 14 % and serial
/// shares of 2 to 12 %, disturbed ones serial shares of 19 and 23 %, with which rows of docs/laboratory/prediction.md missed: so what is
/// above 15 % is doubtful, and residuals above 20 %, the largest error that a prediction may have there. Beyond the second numbers
/// two threads gain less than a third, and an interval of twice the residual reaches to five times the prediction.
const MOST_SPREAD: [f64; 2] = [0.15, 0.25];
const MOST_RESIDUAL: [f64; 2] = [0.2, 0.4];
const MOST_SERIAL: [f64; 2] = [0.15, 0.5];

/// How noisy a measurement is.
fn noise(machine: &Machine) -> Noise {
    let Some(c) = &machine.calibration else { return Noise::Little };
    let serial = machine.processors.serial.as_ref().map_or(0.0, |s| s.value);
    let values = [
        ("the rounds spread by", c.spread.value, MOST_SPREAD),
        ("the costs miss the frames by", c.residual.value, MOST_RESIDUAL),
        ("the serial share is", serial, MOST_SERIAL),
    ];
    // What is larger than the limits of a level, in words. A number that is none is too large, too.
    let above = |level: usize| {
        let is_above = |value: f64, most: f64| value.partial_cmp(&most).is_none_or(Ordering::is_gt);
        let words = |(what, value, most): (&str, f64, [f64; 2])| {
            let [value_in_percent, most_in_percent] = [value, most[level]].map(|share| share * 100.0);
            let text = format!("{what} {value_in_percent:.1} %, more than {most_in_percent:.0} %");
            is_above(value, most[level]).then_some(text)
        };
        let words: Vec<_> = values.into_iter().filter_map(words).collect();
        (!words.is_empty()).then(|| words.join("; "))
    };
    match (above(1), above(0)) {
        (Some(why), _) => Noise::TooMuch(why),
        (None, Some(why)) => Noise::Doubtful(why),
        (None, None) => Noise::Little,
    }
}

/// The measurement of the costs: day, processor, version, residuals and spread.
fn quality(samples: &[Sample]) -> machines::Calibration {
    let residuals = || samples.iter().map(|s| s.fitted / s.seconds - 1.0);
    let of_all = (residuals().map(|r| r * r).sum::<f64>() / samples.len().max(1) as f64).sqrt();
    let worst = residuals().map(f64::abs).fold(0.0, f64::max);
    let mut spreads: Vec<f64> = samples.iter().map(|s| s.slowest / s.seconds - 1.0).collect();
    spreads.sort_by(f64::total_cmp);
    let spread = spreads.get(spreads.len() / 2).copied().unwrap_or(0.0);
    let measured = || "measured by tercio lab calibrate".to_string();
    let share = |value: f64| Sourced::new(value, format!("{:.2} %", value * 100.0), measured());
    machines::Calibration {
        date: today(),
        processor: processor_name(),
        version: env!("CARGO_PKG_VERSION").into(),
        frames: Sourced::new(samples.len() as f64, samples.len().to_string(), measured()),
        residual: share(of_all),
        worst_residual: share(worst),
        spread: share(spread),
        doubt: None,
    }
}

/// What the relative error of a frame is multiplied by: whole frames are what is predicted; those that end earlier tell costs apart.
fn weight(last_stage: LastStage) -> f64 {
    match last_stage {
        LastStage::Output => 4.0,
        LastStage::Visibility => 2.0,
        _ => 1.0,
    }
}

/// Fits the costs to the samples and adds them to a description.
fn fitted(mut machine: Machine, mut samples: Vec<Sample>, threads: usize) -> Calibration {
    let caches = Caches::of(&machine, 1);
    let rows: Vec<Vec<f64>> =
        samples.iter().map(|s| charges(&s.counted.frame, caches).map(|c| c.2).to_vec()).collect();
    let times: Vec<f64> = samples.iter().map(|s| s.seconds).collect();
    let weights: Vec<f64> = samples.iter().map(|s| weight(s.settings.last_stage)).collect();
    let fitted = fit::costs(&rows, &times, &weights);
    for (sample, row) in samples.iter_mut().zip(&rows) {
        sample.fitted = row.iter().zip(&fitted).map(|(count, cost)| count * cost).sum();
    }
    let operations = charges(&Counters::default(), caches).map(|c| c.1);
    let source = format!("fitted by tercio lab calibrate to {} frames", samples.len());
    for (operation, seconds) in operations.into_iter().zip(fitted).filter(|c| c.1 > 0.0) {
        // A resolution of 0.1 ps.
        let text = format!("{:.4} ns", seconds * 1e9);
        machine.costs.insert(operation, Sourced::new(seconds, text, source.clone()));
    }
    let [serial, wake_up] = of_threads(&machine, &samples, threads);
    let measured = || "measured by tercio lab calibrate".to_string();
    machine.processors.serial = Some(Sourced::new(serial, format!("{:.2} %", serial * 100.0), measured()));
    machine.processors.wake_up = Some(Sourced::new(wake_up, format!("{:.2} us", wake_up * 1e6), measured()));
    machine.calibration = Some(quality(&samples));
    Calibration { machine, samples }
}

/// Whether a frame is one that is also measured on all threads: it has all stages and is sorted by clusters.
fn is_whole(settings: &Settings) -> bool {
    settings.last_stage == LastStage::Output && settings.sorting == RasterSorting::Clusters
}

/// The picture of a sample.
struct Picture {
    scene: Arc<Scene>,
    camera: Camera,
    sample: Sample,
}

/// One model in all sizes and variants, counted but not drawn yet.
fn pictures_of(model: &str, mesh: Mesh, threads: usize) -> Result<Vec<Picture>, PredictError> {
    let triangles = mesh.triangles.len();
    let (scene, bounds) = prepare(mesh);
    let scene = Arc::new(scene);
    let mut pictures = Vec::new();
    for size in SIZES {
        let camera = views::camera(&bounds, size, 1, 7);
        for (sorting, last_stage) in VARIANTS {
            if sorting == RasterSorting::Triangles && triangles > MOST_SORTED {
                continue;
            }
            let settings = Settings { sorting, last_stage, ..Settings::one_sample(size.0, size.1) };
            let counted = count(&scene, &camera, &settings, 1)?;
            let shared =
                (is_whole(&settings) && threads > 1).then(|| count(&scene, &camera, &settings, threads));
            let shared = shared.transpose()?;
            let seconds = f64::INFINITY;
            let sample = Sample {
                model: model.into(),
                settings,
                counted,
                seconds,
                slowest: 0.0,
                fitted: 0.0,
                together: None,
                shared,
            };
            pictures.push(Picture { scene: scene.clone(), camera, sample });
        }
    }
    Ok(pictures)
}

impl Picture {
    /// Draws it several times; the fastest frame of all rounds counts.
    fn draw(&mut self, o: Options) -> Result<(), PredictError> {
        let seconds = |threads| {
            let s = &self.sample.settings;
            measure(&self.scene, &self.camera, s, threads, o.frames, o.clock).map(|m| m.seconds)
        };
        let together = if self.sample.shared.is_some() { Some(seconds(o.threads)?) } else { None };
        let alone = seconds(1)?;
        self.sample.seconds = self.sample.seconds.min(alone);
        self.sample.slowest = self.sample.slowest.max(alone);
        self.sample.together = together.map(|t| self.sample.together.map_or(t, |before| before.min(t)));
        Ok(())
    }
}

/// The share of the work that is not parallel, by Amdahl's law, at most 1, and the seconds until the other threads take part,
/// from frames of one thread and of all: what makes the measured time on all threads longer than that predicted for the frame's
/// tiles distributed among them, as far as it grows with the frame, and as far as it does not. 0 if there is only one thread,
/// or if the speed-up is more than linear.
fn of_threads(machine: &Machine, samples: &[Sample], threads: usize) -> [f64; 2] {
    let machine = &Machine {
        processors: Processors { serial: None, wake_up: None, ..machine.processors.clone() },
        ..machine.clone()
    };
    let (mut terms, mut excess, mut times) = (Vec::new(), Vec::new(), Vec::new());
    for sample in samples {
        let (Some(together), Some(shared)) = (sample.together, &sample.shared) else { continue };
        let one = FrameTime::on_one_thread(machine, &sample.counted.frame).total();
        let divided = sample.seconds * FrameTime::on_threads(machine, shared, threads).total() / one;
        terms.push([sample.seconds - divided, 1.0 - 1.0 / threads as f64]);
        excess.push(together - divided);
        times.push(together);
    }
    let [serial, wake_up] = fit::two_terms(&terms, &excess, &times);
    [serial.min(1.0), wake_up]
}

/// A description of this machine without the costs of drawing.
fn description(o: Options, mpi: Option<Network>) -> Result<Machine, PredictError> {
    let measured = "measured by tercio lab calibrate";
    let rate = |value: f64| Sourced::new(value, format!("{:.4} GB/s", value / 1e9), measured.to_string());
    let count = |n: usize| Sourced::new(n as f64, n.to_string(), measured.to_string());
    let composite = composite_seconds();
    let composite = Sourced::new(composite, format!("{:.4} ns", composite * 1e9), measured.into());
    let bytes = |n: f64, source: &str| Sourced::new(n, format!("{n} B"), source.to_string());
    let cache = |level| cache_bytes(level).map(|n| bytes(n as f64, "reported by the operating system"));
    Ok(Machine {
        name: "This machine".into(),
        summary: "Measured by tercio lab calibrate; clusters to tiles on all processors.".into(),
        sorting: Sorting {
            class: SortingClass::SortMiddle,
            screen: ScreenDivision::Tiles,
            how: "Clusters are sorted into tiles on any thread, tiles drawn on any thread.".into(),
            source: "ARCHITECTURE.md".into(),
        },
        processors: Processors {
            count: count(o.threads),
            control: Control::default(),
            at_most: None,
            clock: None,
            memory: None,
            memory_bandwidth: Some(rate(memory_bandwidth(o.threads))),
            own_cache: cache(2),
            shared_cache: cache(3),
            exchange_cache: None,
            per_node: None,
            serial: None,
            wake_up: None,
            nap: nap_seconds()
                .map(|nap| Sourced::new(nap, format!("{:.2} us", nap * 1e6), measured.to_string())),
        },
        screen: None,
        node: None,
        calibration: None,
        uncertainty: None,
        network: Some(messages::between_threads()?),
        mpi,
        bytes: BTreeMap::from([
            (
                DataKind::Primitive,
                bytes(
                    13.0,
                    "ARCHITECTURE.md: 12 B a cluster vertex, about 0.5 of them, 3 B of corners and up to 4 B of number a triangle",
                ),
            ),
            (DataKind::Descriptor, bytes(64.0, "ARCHITECTURE.md: edges and depth plane of a small triangle")),
            (DataKind::Sample, bytes(8.0, "colour and depth, 4 B each")),
        ]),
        costs: BTreeMap::from([(Operation::CompositePixel, composite)]),
        heap: None,
        sdram: None,
        stages: Vec::new(),
        tile_engine: None,
        transfer: None,
        claims: BTreeMap::new(),
    })
}

/// A scene as in `tercio bench`.
pub fn prepare(mesh: Mesh) -> (Scene, tercio_mesh::Aabb) {
    let bounds = mesh.bounds();
    (views::scene(Arc::new(partition(mesh, &PartitionOptions::default()))), bounds)
}

#[cfg(test)]
mod tests {
    use tercio_mesh::builtin;

    use super::*;
    use crate::machines::parse;

    #[test]
    fn serial_share_and_waking_follow_from_the_times_of_two_frames() {
        let machine = machine();
        let frame = Counters { clusters_drawn: 2000, clusters: 4096, ..Counters::default() };
        let tile = crate::predict::counts::TileWork {
            counters: Counters { clusters_drawn: 1000, ..Counters::default() },
            is_shared: false,
        };
        // Seconds on one thread and on two.
        let of = |frames: [(f64, f64); 2]| {
            let sample = |(seconds, together)| Sample {
                model: "x".into(),
                settings: Settings::one_sample(8, 8),
                counted: Counted { frame, tiles: vec![tile; 2] },
                shared: Some(Counted { frame, tiles: vec![tile; 2] }),
                seconds,
                slowest: seconds,
                fitted: 0.0,
                together: Some(together),
            };
            of_threads(&machine, &frames.map(sample), 2)
        };
        // The fixed cost of a frame is serial already and accounts for a little of it.
        let fixed = machine.seconds_or_0(Operation::Frame);
        let one = FrameTime::on_one_thread(&machine, &frame_of(2000, 4096)).total();
        let divided = (1.0 + fixed / one) / 2.0;
        let near = |found: [f64; 2], serial: f64, wake_up: f64| {
            assert!((found[0] - serial).abs() < 1e-9 && (found[1] - wake_up).abs() < 1e-9, "{found:?}");
        };
        near(of([(1.0, divided), (2.0, 2.0 * divided)]), 0.0, 0.0);
        near(of([(1.0, 1.0), (2.0, 2.0)]), 1.0, 0.0);
        let tenth = divided + 0.1 * (1.0 - divided);
        near(of([(1.0, tenth), (2.0, 2.0 * tenth)]), 0.1, 0.0);
        // Both threads gain nothing in the first 0.04 s.
        near(of([(1.0, tenth + 0.02), (2.0, 2.0 * tenth + 0.02)]), 0.1, 0.04);
        near(of([(1.0, divided + 0.02), (2.0, 2.0 * divided + 0.02)]), 0.0, 0.04);
        near(of([(1.0, 0.4), (2.0, 0.8)]), 0.0, 0.0);
    }

    fn frame_of(clusters_drawn: u64, clusters: u64) -> Counters {
        Counters { clusters_drawn, clusters, ..Counters::default() }
    }

    fn machine() -> Machine {
        machines::builtin("two-core-2026").unwrap().unwrap()
    }

    /// A frame of this many hidden clusters, measured in some rounds.
    fn sample(clusters_hidden: u64, seconds: f64, slowest: f64, together: f64) -> Sample {
        let frame = Counters { clusters_hidden, ..Counters::default() };
        let counted = Counted { frame, tiles: Vec::new() };
        let shared = Some(counted.clone());
        let (settings, together) = (Settings::one_sample(8, 8), Some(together));
        Sample { model: "x".into(), settings, counted, seconds, slowest, fitted: 0.0, together, shared }
    }

    #[test]
    fn residuals_and_spread_are_part_of_the_description() {
        let empty = || Machine { costs: BTreeMap::new(), ..machine() };
        // A millisecond for a thousand clusters, and for the second frame a tenth more; rounds 10 % apart.
        let samples = [(1000, 1e-3), (2000, 2.2e-3), (3000, 3e-3)];
        let samples = samples.map(|(n, seconds)| sample(n, seconds, seconds * 1.1, seconds / 2.0)).to_vec();
        let calibration = fitted(empty(), samples, 2);
        assert_eq!(noise(&calibration.machine), Noise::Little);
        let text = calibration.machine.to_toml().unwrap();
        let again = parse("this.toml", &text).unwrap_or_else(|e| panic!("{e}\n{text}")).calibration.unwrap();
        assert_eq!((again.frames.whole(), again.spread.text.as_str()), (3, "10.00 %"));
        let residuals = calibration.samples.iter().map(|s| s.fitted / s.seconds - 1.0);
        let worst = residuals.clone().map(f64::abs).fold(0.0, f64::max);
        let squares = (residuals.map(|r| r * r).sum::<f64>() / 3.0).sqrt();
        assert!(worst > 0.01 && (again.worst_residual.value - worst).abs() < 1e-4, "{again:?}");
        assert!((again.residual.value - squares).abs() < 1e-4, "{again:?}");
        assert_eq!(again.version, env!("CARGO_PKG_VERSION"));
        assert!(again.date.as_str() > "2026-01-01" && !again.processor.is_empty());
    }

    #[test]
    fn noisy_measurements_are_doubtful_or_refused_with_the_reason() {
        let empty = || Machine { costs: BTreeMap::new(), ..machine() };
        let of_all = |samples: Vec<Sample>| noise(&fitted(empty(), samples, 2).machine);
        // Frames of 1, 2 and 4 ms, with the slowest round and all threads together in proportion.
        let scaled = |slowest: f64, together: f64| {
            let of = |n: u64| sample(1000 * n, 1e-3 * n as f64, slowest * n as f64, together * n as f64);
            of_all([1, 2, 4].map(of).to_vec())
        };
        assert_eq!(scaled(1.1e-3, 0.55e-3), Noise::Little);
        let too_noisy = |noise: Noise| match noise {
            Noise::TooMuch(why) => why,
            other => panic!("{other:?}"),
        };
        // All threads together as slow as one: a serial share of 100 % is no property of a machine.
        let busy = too_noisy(scaled(1e-3, 1e-3));
        assert!(busy.contains("the serial share is 100.0 %, more than 50 %"), "{busy}");
        let spread = too_noisy(scaled(2e-3, 0.5e-3));
        assert!(spread.contains("the rounds spread by 100.0 %, more than 25 %"), "{spread}");
        let fit = vec![sample(1000, 1e-3, 1e-3, 0.5e-3), sample(1000, 1e-2, 1e-2, 0.5e-2)];
        assert!(too_noisy(of_all(fit)).contains("the costs miss the frames by"));
        // Between the two limits a measurement is kept, and doubtful.
        let doubtful = |noise: Noise| match noise {
            Noise::Doubtful(why) => why,
            other => panic!("{other:?}"),
        };
        let serial = doubtful(scaled(1e-3, 0.65e-3));
        assert!(serial.contains("the serial share is") && serial.contains("more than 15 %"), "{serial}");
        let spread = doubtful(scaled(1.2e-3, 0.5e-3));
        assert_eq!(spread, "the rounds spread by 20.0 %, more than 15 %");
        let fit = vec![sample(1000, 1e-3, 1e-3, 0.5e-3), sample(1000, 1.7e-3, 1.7e-3, 0.85e-3)];
        assert!(doubtful(of_all(fit)).contains("the costs miss the frames by"));
    }

    /// What is kept is the first of the least noise; it is said, in the file, too, or refused.
    #[test]
    fn doubtful_measurements_are_repeated_and_say_so() {
        let of_serial = |serial: f64| {
            let samples =
                [1.0, 2.0, 4.0].map(|n: f64| sample(1000 * n as u64, 1e-3 * n, 1e-3 * n, 0.5e-3 * n));
            let mut calibration =
                fitted(Machine { costs: BTreeMap::new(), ..machine() }, samples.to_vec(), 2);
            let text = format!("{:.0} %", serial * 100.0);
            calibration.machine.processors.serial = Some(Sourced::new(serial, text, "x".into()));
            calibration
        };
        // The serial shares that are measured, one after another; that which is kept, with its doubt, and what was reported.
        let run_at_most = |most: u32, shares: &[f64], accept_noise: bool| {
            let (mut next, mut repeats, mut doubts) = (shares.iter(), 0, 0);
            let mut progress = |what: Progress<'_>| match what {
                Progress::Repeated(_) => repeats += 1,
                Progress::Doubtful(_) => doubts += 1,
                Progress::Next(_) => {}
            };
            let kept = least_noisy((most, accept_noise), &mut progress, |_| {
                Ok(of_serial(*next.next().expect("no more")))
            });
            let kept = kept
                .map(|c| (c.machine.processors.serial.unwrap().value, c.machine.calibration.unwrap().doubt));
            assert_eq!(next.len(), 0, "all are measured");
            (kept.map_err(|e| e.to_string()), repeats, doubts)
        };
        let run = |shares: &[f64], accept_noise: bool| run_at_most(2, shares, accept_noise);
        assert_eq!(run(&[0.1], false), (Ok((0.1, None)), 0, 0));
        assert_eq!(run_at_most(0, &[0.1], false), (Ok((0.1, None)), 0, 0));
        assert_eq!(run_at_most(0, &[0.2], false).1, 0);
        assert!(run_at_most(0, &[0.6], false).0.is_err() && run_at_most(1, &[0.6, 0.2], false).0.is_ok());
        assert_eq!(run(&[0.2, 0.1], false), (Ok((0.1, None)), 1, 0));
        let doubt = |percent: &str| Some(format!("the serial share is {percent} %, more than 15 %"));
        assert_eq!(run(&[0.2, 0.3, 0.6], false), (Ok((0.2, doubt("20.0"))), 2, 1));
        assert_eq!(run(&[0.6, 0.3, 0.4], false), (Ok((0.3, doubt("30.0"))), 2, 1));
        let (refused, ..) = run(&[0.6, 0.7, 0.8], false);
        assert!(refused.unwrap_err().contains("the serial share is 60.0 %, more than 50 %"));
        let (accepted, _, doubts) = run(&[0.6, 0.7, 0.8], true);
        assert_eq!(
            (accepted.unwrap().1.unwrap(), doubts),
            ("the serial share is 60.0 %, more than 50 %".into(), 1)
        );
        // The file says so, and is read again.
        let mut calibration = of_serial(0.2).machine;
        calibration.calibration.as_mut().unwrap().doubt = doubt("20.0");
        let again = parse("this.toml", &calibration.to_toml().unwrap()).unwrap();
        assert_eq!(again.calibration.unwrap().doubt, doubt("20.0"));
    }

    #[test]
    fn what_is_measured_is_a_description() {
        let options =
            Options { threads: 2, frames: 1, rounds: 1, clock: Clock::Wall, repeats: 0, accept_noise: false };
        let measured = messages::Measured { latency: 1.5e-6, bandwidth: 4.25e9 };
        let mpi = messages::network(measured, "over MPI", "one machine");
        for mpi in [None, Some(mpi)] {
            let machine = description(options, mpi.clone()).unwrap();
            let text = machine.to_toml().unwrap();
            let again = parse("this.toml", &text).unwrap_or_else(|e| panic!("{e}\n{text}"));
            assert!(again.seconds(Operation::CompositePixel).unwrap() > 0.0);
            assert!(again.processors.memory_bandwidth.unwrap().value > 1e8);
            assert!(again.network.unwrap().bandwidth.value > 1e6);
            assert_eq!(again.mpi.is_some(), mpi.is_some());
            let numbers =
                |n: Network| [n.message.value * 1e6, n.bandwidth.value / 1e9].map(|v| (v * 1e3).round());
            assert!(again.mpi.is_none_or(|n| numbers(n) == [1500.0, 4250.0]), "{text}");
        }
    }

    #[test]
    fn frames_of_a_model_are_drawn_and_counted_in_all_variants() {
        let options =
            Options { threads: 2, frames: 1, rounds: 1, clock: Clock::Wall, repeats: 0, accept_noise: false };
        let mesh = builtin::make("builtin:teapot@2k").unwrap();
        let mut pictures = pictures_of("builtin:teapot@2k", mesh, options.threads).unwrap();
        assert_eq!(pictures.len(), VARIANTS.len() * SIZES.len());
        pictures.iter_mut().for_each(|p| p.draw(options).unwrap());
        let first: Vec<f64> = pictures.iter().map(|p| p.sample.seconds).collect();
        pictures.iter_mut().for_each(|p| p.draw(options).unwrap());
        assert!(pictures.iter().zip(first).all(|(p, first)| p.sample.seconds <= first && first.is_finite()));
        assert!(pictures.iter().all(|p| p.sample.counted.frame.clusters > 0));
        assert_eq!(pictures.iter().filter(|p| p.sample.together.is_some()).count(), SIZES.len());
    }
}
