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
use crate::predict::hardware::cache_bytes;
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

/// Measures this machine: `frames` frames of each picture, of which the fastest counts, in `rounds` rounds through all.
///
/// # Errors
/// [`RanksError`].
pub fn measure(frames: u32, rounds: u32) -> Result<ExchangeCosts, RanksError> {
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
    let cache = cache_bytes(3).map_or(f64::INFINITY, |bytes| bytes as f64);
    let mut costs = [0.0; KINDS];
    // If something else disturbed the machine, keys may seem to take no time.
    let of_keys = pictures.iter().filter_map(|p| p.keys(cache)).filter(|k| k.1 > 1e-6);
    let (rows, times): (Vec<_>, Vec<_>) = of_keys.map(|k| (k.0[..OF_KEYS].to_vec(), k.1)).unzip();
    place(&mut costs[..OF_KEYS], &rows, &times);
    let stages = pictures.iter().flat_map(|p| &p.shared).flat_map(|s| s.stages(cache));
    // Stages without work carry no information.
    let stages = stages.filter(|s| s.1 > 1e-6);
    let (rows, times): (Vec<_>, Vec<_>) = stages.map(|s| (s.0[OF_KEYS..OF_DIVISION].to_vec(), s.1)).unzip();
    place(&mut costs[OF_KEYS..OF_DIVISION], &rows, &times);
    let divisions = pictures.iter().flat_map(|p| &p.shared).flat_map(|s| s.divisions(cache));
    let divisions = divisions.filter(|d| d.1 > 1e-6);
    let (rows, times): (Vec<_>, Vec<_>) = divisions.map(|d| (d.0[OF_DIVISION..].to_vec(), d.1)).unzip();
    place(&mut costs[OF_DIVISION..], &rows, &times);
    Ok(ExchangeCosts(costs))
}

fn place(costs: &mut [f64], rows: &[Vec<f64>], times: &[f64]) {
    if !times.is_empty() {
        costs.copy_from_slice(&fit::costs(rows, times, &vec![1.0; times.len()]));
    }
}

/// Writes costs into a description. Costs of zero are omitted.
pub fn describe(costs: &ExchangeCosts, source: &str, machine: &mut Machine) {
    for (operation, &seconds) in OPERATIONS.into_iter().zip(&costs.0).filter(|c| *c.1 > 0.0) {
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
    fn costs_survive_a_description() {
        let mut machine = builtin("two-core-2026").unwrap().unwrap();
        OPERATIONS.iter().for_each(|o| drop(machine.costs.remove(o)));
        assert!(ExchangeCosts::of(&machine).unwrap_err().to_string().contains("costs.scanned-pixel"));
        let mut costs = ExchangeCosts(std::array::from_fn(|k| k as f64 * 1e-9));
        costs.0[9] = 1.5 * 1e-9;
        describe(&costs, "a test", &mut machine);
        let again = parse("this.toml", &machine.to_toml().unwrap()).unwrap();
        assert_eq!(ExchangeCosts::of(&again).unwrap(), costs);
    }
}
