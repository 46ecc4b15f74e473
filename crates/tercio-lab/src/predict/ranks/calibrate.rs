//! Measures the costs of ranks on this machine, by fitting them to frames of models that are in no table.

use std::sync::Arc;

use tercio::LoadOptions;
use tercio_parallel::Organisation;
use tercio_raster::{Outputs, Settings};
use tercio_scene::{Camera, Scene};

use super::RanksError;
use super::exchange::{Charges, Exchange, ExchangeCosts, KINDS, OF_DIVISION, OPERATIONS, keys, missed};
use super::measure::MeasuredRanks;
use super::renderer::RanksWork;
use crate::machines::{Machine, Sourced};
use crate::predict::calibrate::prepare;
use crate::predict::frame::Caches;
use crate::predict::measure::{Clock, measure as measure_alone};
use crate::predict::{fit, views};

/// Models, sizes of pictures and numbers of ranks that the costs are fitted to.
const MODELS: [&str; 3] = ["builtin:sphere@20k", "builtin:gyroid@100k", "builtin:terrain@50k"];
const SIZES: [(u32, u32); 2] = [(800, 500), (1900, 1100)];
const RANKS: [usize; 3] = [1, 2, 3];
/// Number of kinds of work that are about keys; they come first.
const OF_KEYS: usize = 3;

/// Frames of one picture, drawn by ranks.
struct Shared {
    work: RanksWork,
    measured: MeasuredRanks,
}

/// One picture.
struct Picture {
    scene: Arc<Scene>,
    camera: Camera,
    settings: Settings,
    /// Seconds on one thread, without keys and with them.
    alone: f64,
    keyed: f64,
    shared: Vec<Shared>,
}

impl Picture {
    fn new(scene: Arc<Scene>, camera: Camera, size: (u32, u32)) -> Result<Self, RanksError> {
        let settings = Settings::one_sample(size.0, size.1);
        let mut shared = Vec::new();
        for ranks in RANKS {
            for organisation in [Organisation::SortFirst, Organisation::SortLast] {
                let work = RanksWork::count(&scene, &camera, &settings, (ranks, organisation.into()))?;
                shared.push(Shared { work, measured: MeasuredRanks::default() });
            }
        }
        Ok(Self { scene, camera, settings, alone: f64::INFINITY, keyed: f64::INFINITY, shared })
    }

    fn draw(&mut self, frames: u32) -> Result<(), RanksError> {
        let alone = measure_alone(&self.scene, &self.camera, &self.settings, 1, frames, Clock::Processor)?;
        self.alone = self.alone.min(alone.seconds);
        let outputs = Outputs { keys: true, ..self.settings.outputs };
        let settings = Settings { outputs, ..self.settings.clone() };
        let keyed = measure_alone(&self.scene, &self.camera, &settings, 1, frames, Clock::Processor)?;
        self.keyed = self.keyed.min(keyed.seconds);
        for shared in &mut self.shared {
            let sharing = &shared.work.sharing;
            shared.measured.add(MeasuredRanks::draw(&self.scene, &self.camera, sharing, frames)?);
        }
        Ok(())
    }

    /// The work of keys, and the additional seconds of drawing with them.
    fn keys(&self, cache: f64) -> Option<(Charges, f64)> {
        let alone = self.shared.iter().find(|shared| shared.work.sharing.ranks == 1)?;
        let drawn = &alone.work.drawing[0];
        // The picture, with keys.
        let missed = missed(drawn.pixels as f64 * 12.0 + drawn.bytes_touched as f64, cache);
        Some((keys(drawn.pixels, drawn.pixels_visible, missed), self.keyed - self.alone))
    }
}

impl Shared {
    /// The work of dividing the picture, with the seconds of each rank of sort-first.
    fn divisions(&self, cache: f64) -> Vec<(Charges, f64)> {
        let (work, ranks) = (&self.work, self.work.sharing.ranks);
        let divided = work.sharing.organisation == Organisation::SortFirst && ranks > 1;
        let exchange = Exchange::new(&work.sharing, &work.messages, &work.drawing, (ranks, cache), false);
        let of_rank = |rank| (exchange.dividing(), self.measured.busy(rank, |s| &s.redistribute));
        (0..if divided { ranks } else { 0 }).map(of_rank).collect()
    }

    /// The work of the stages of its ranks, with their seconds.
    fn stages(&self, cache: f64) -> Vec<(Charges, f64)> {
        let ranks = self.work.sharing.ranks;
        let work = &self.work;
        let exchange = Exchange::new(&work.sharing, &work.messages, &work.drawing, (ranks, cache), false);
        let sum = |all: &mut dyn Iterator<Item = Charges>| {
            all.fold([0.0; KINDS], |sum, c| std::array::from_fn(|k| sum[k] + c[k]))
        };
        let mut stages = Vec::new();
        for rank in 0..ranks {
            if ranks == 1 {
                continue;
            }
            let packing = std::iter::once(exchange.packing(rank));
            let composing = exchange.composing(rank).into_iter().map(|merge| merge.1);
            stages.push((sum(&mut packing.chain(composing)), self.measured.busy(rank, |s| &s.compose)));
            let others = if rank == 0 { 1..ranks } else { 0..0 };
            let collecting = others.map(|from| exchange.collecting(from));
            let all = sum(&mut std::iter::once(exchange.finishing(rank)).chain(collecting));
            stages.push((all, self.measured.busy(rank, |s| &s.collect)));
        }
        stages
    }
}

/// Measured costs of ranks.
#[derive(Clone, Copy, Debug)]
pub struct MeasuredCosts {
    /// Seconds of each kind of work.
    pub costs: ExchangeCosts,
    /// Bytes of the cache that pictures and messages stay in.
    pub cache: f64,
}

/// Measures this machine, whose caches `machine` has: `frames` frames of each picture, of which the fastest counts, in `rounds` rounds
/// through all.
///
/// # Errors
/// [`RanksError`].
pub fn measure(frames: u32, rounds: u32, machine: &Machine) -> Result<MeasuredCosts, RanksError> {
    let mut pictures = Vec::new();
    for model in MODELS {
        // Built-in names; a model that cannot be made is skipped.
        let Ok(loaded) = LoadOptions::default().load_mesh(model) else { continue };
        let (scene, bounds) = prepare(loaded.mesh);
        let scene = Arc::new(scene);
        for size in SIZES {
            pictures.push(Picture::new(scene.clone(), views::camera(&bounds, size, 1, 7), size)?);
        }
    }
    for _ in 0..rounds.max(1) {
        pictures.iter_mut().try_for_each(|p| p.draw(frames))?;
    }
    let caches = caches(machine).into_iter().map(|cache| {
        let stages = pictures.iter().flat_map(|p| &p.shared).flat_map(|s| s.stages(cache));
        // Stages without work carry no information.
        let (rows, times) = stages
            .filter(|s| s.1 > 1e-6)
            .map(|s| (s.0[OF_KEYS..OF_DIVISION].to_vec(), s.1))
            .unzip::<_, _, Vec<_>, Vec<_>>();
        // Between errors in proportion, of which many short stages would have the most, and seconds, which the longest would.
        let weights: Vec<f64> = times.iter().map(|t| t.sqrt()).collect();
        let mut costs = [0.0; KINDS];
        place(&mut costs[OF_KEYS..OF_DIVISION], &rows, &times, &weights);
        (residual(&costs[OF_KEYS..OF_DIVISION], &rows, &times, &weights), cache, costs)
    });
    // What the cache holds depends on all programs and guests of the machine, so it is fitted, too: of several the first that is best.
    let best = caches.min_by(|a, b| a.0.total_cmp(&b.0));
    let (_, cache, mut costs) = best.unwrap_or((0.0, f64::INFINITY, [0.0; KINDS]));
    // If something else disturbed the machine, keys may seem to take no time.
    let of_keys = pictures.iter().filter_map(|p| p.keys(cache)).filter(|k| k.1 > 1e-6);
    let (rows, times): (Vec<_>, Vec<_>) = of_keys.map(|k| (k.0[..OF_KEYS].to_vec(), k.1)).unzip();
    place(&mut costs[..OF_KEYS], &rows, &times, &vec![1.0; times.len()]);
    let divisions = pictures.iter().flat_map(|p| &p.shared).flat_map(|s| s.divisions(cache));
    let divisions = divisions.filter(|d| d.1 > 1e-6);
    let (rows, times): (Vec<_>, Vec<_>) = divisions.map(|d| (d.0[OF_DIVISION..].to_vec(), d.1)).unzip();
    place(&mut costs[OF_DIVISION..], &rows, &times, &vec![1.0; times.len()]);
    Ok(MeasuredCosts { costs: ExchangeCosts(costs), cache })
}

/// Caches to fit costs with, in bytes: from that of a processor on to the shared one, where a description has them.
fn caches(machine: &Machine) -> Vec<f64> {
    let Caches { own, shared, .. } = Caches::of(machine, 1);
    // A description may say that a processor has none, of which no larger one would follow.
    let least = if own.is_finite() { own.max(1.0) } else { 1e6 };
    let most = if shared.is_finite() { shared } else { 1e9 };
    let sizes = std::iter::successors(Some(least), |size| Some(size * std::f64::consts::SQRT_2));
    sizes.take_while(|&size| size < most).chain([most]).collect()
}

/// The sum of the squares of the differences between times and those of the costs, relative to the times, each times its weight.
fn residual(costs: &[f64], rows: &[Vec<f64>], times: &[f64], weights: &[f64]) -> f64 {
    let fitted = rows.iter().map(|row| row.iter().zip(costs).map(|(count, cost)| count * cost).sum::<f64>());
    fitted
        .zip(times)
        .zip(weights)
        .map(|((fitted, time), weight)| ((fitted / time - 1.0) * weight).powi(2))
        .sum()
}

fn place(costs: &mut [f64], rows: &[Vec<f64>], times: &[f64], weights: &[f64]) {
    if !times.is_empty() {
        costs.copy_from_slice(&fit::costs(rows, times, weights));
    }
}

/// Writes costs into a description, and the cache that they are for. Costs of zero are omitted.
pub fn describe(measured: &MeasuredCosts, source: &str, machine: &mut Machine) {
    if measured.cache.is_finite() {
        let text = format!("{:.0} B", measured.cache);
        machine.processors.exchange_cache = Some(Sourced::new(measured.cache, text, source.into()));
    }
    for (operation, &seconds) in OPERATIONS.into_iter().zip(&measured.costs.0).filter(|c| *c.1 > 0.0) {
        // A resolution of 0.1 ps.
        let text = format!("{:.4} ns", seconds * 1e9);
        machine.costs.insert(operation, Sourced::new(seconds, text, source.into()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machines::{builtin, parse};

    #[test]
    fn caches_to_fit_begin_with_that_of_a_processor_and_end_with_the_shared_one() {
        let mut machine = builtin("two-core-2026").unwrap().unwrap();
        let Caches { own, shared, .. } = Caches::of(&machine, 1);
        let all = caches(&machine);
        assert_eq!((all[0], *all.last().unwrap()), (own, shared));
        assert!(all.windows(2).all(|w| w[0] < w[1] && w[1] <= 1.5 * w[0]), "{all:?}");
        (machine.processors.own_cache, machine.processors.shared_cache) = (None, None);
        assert!(caches(&machine).iter().all(|c| (1e6..=1e9).contains(c)));
        machine.processors.own_cache = Some(Sourced::new(0.0, "0 B".into(), String::new()));
        assert_eq!(caches(&machine)[0], 1.0);
    }

    #[test]
    fn residuals_are_relative() {
        let rows = vec![vec![1.0, 2.0], vec![4.0, 0.0]];
        // Fitted 5 and 4: a quarter too much, and half of what it is.
        let of = |weights: &[f64]| residual(&[1.0, 2.0], &rows, &[4.0, 8.0], weights);
        assert_eq!((of(&[1.0, 1.0]), of(&[2.0, 1.0])), (0.0625 + 0.25, 0.25 + 0.25));
    }

    #[test]
    fn costs_survive_a_description() {
        let mut machine = builtin("two-core-2026").unwrap().unwrap();
        OPERATIONS.iter().for_each(|o| drop(machine.costs.remove(o)));
        assert!(ExchangeCosts::of(&machine).unwrap_err().to_string().contains("costs.scanned-pixel"));
        let mut costs = ExchangeCosts(std::array::from_fn(|k| k as f64 * 1e-9));
        // Zero as a fit may make it, of which older descriptions have another.
        (costs.0[9], costs.0[10]) = (1.5 * 1e-9, 0.0);
        describe(&MeasuredCosts { costs, cache: 12.5e6 }, "a test", &mut machine);
        let again = parse("this.toml", &machine.to_toml().unwrap()).unwrap();
        assert_eq!(ExchangeCosts::of(&again).unwrap(), costs);
        assert_eq!(Caches::of(&again, 1).exchange, 12.5e6);
        // By default half of the shared cache, and of an older description merging a pixel takes as long as unpacking a sample.
        machine.processors.exchange_cache = None;
        let Caches { shared, exchange, .. } = Caches::of(&machine, 1);
        assert_eq!(exchange, shared / 2.0);
        assert_eq!(ExchangeCosts::of(&machine).unwrap().0[10], costs.0[7]);
    }
}
