//! The sorting classes on a SIMD ring, by the rules of document 000: [`crate::simulators::ring`] runs them.
//!
//! A pass moves the slots of all processors at once, so time follows from the number of passes, not from the busiest
//! link. In sort-first, which the document does not have on its ring, primitives travel like descriptors, and the
//! owners of the regions do the geometry work.

use serde::Serialize;

use super::network::Traffic;
use super::organisation::{Computing, Organisation, Setting, SortReport};
use crate::machines::{Control, Delivery, Machine, MachineError, ScreenDivision, Topology};
use crate::simulators::ring::{self, Algorithm, AlgorithmError, RingRun};
use crate::workloads::{BoxScene, PixelBox, ScreenMap};

/// The rules of a ring.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Simd {
    /// Its costs in instructions.
    pub ring: ring::Machine,
    /// Seconds of an instruction.
    pub instruction: f64,
    /// Whether the regions, if no size is given, are columns of the screen.
    pub columns: bool,
}

impl Simd {
    /// The rules of a machine; `None` if its processors have programs of their own.
    ///
    /// # Errors
    /// [`MachineError::Missing`], as [`ring::Machine::of`]; [`MachineError::NoRules`] for another network than a ring.
    pub fn of(machine: &Machine, topology: Topology) -> Result<Option<Self>, MachineError> {
        if machine.processors.control != Control::Simd {
            return Ok(None);
        }
        if topology != Topology::Ring {
            return Err(MachineError::NoRules { machine: machine.name.clone(), found: topology.name() });
        }
        let columns = machine.sorting.screen == ScreenDivision::Columns;
        let instruction = 1.0 / machine.clock()?;
        Ok(Some(Self { ring: ring::Machine::of(machine)?, instruction, columns }))
    }
}

/// Simulates a frame of groups that divide the ring.
///
/// # Errors
/// [`AlgorithmError`] if they do not.
pub fn simulate(
    scene: &BoxScene,
    organisation: Organisation,
    group: usize,
    s: &Setting,
    simd: &Simd,
) -> Result<SortReport, AlgorithmError> {
    let first = organisation == Organisation::SortFirst;
    let processors = u32::try_from(s.processors).unwrap_or(u32::MAX);
    let mut machine = ring::Machine { processors, ..simd.ring };
    if first {
        // A descriptor of A words has A / descriptor words, a primitive in proportion.
        let words = machine.descriptor_words * s.costs.primitive;
        machine.descriptor_words = words.div_ceil(s.costs.descriptor.max(1));
    }
    let algorithm = Algorithm { group: group as u32, ..Algorithm::sort_middle(&machine) };
    algorithm.check(&machine, 0)?;
    let map = map(s, group, simd.columns);
    let run = ring::simulate(&machine, &algorithm, &map, scene)?;
    let seconds = |instructions: u64| instructions as f64 * simd.instruction;
    let n = s.processors as f64;
    let screen = PixelBox::screen(s.width, s.height);
    let visible = scene.boxes.iter().filter(|b| b.visible);
    let pixels: u64 = visible.filter_map(|b| b.pixels.intersection(&screen)).map(|b| b.area()).sum();
    let geometry = geometry(&machine, &run, first);
    let passes: u64 = run.passes();
    let redistribution = Traffic {
        messages: run.stages.iter().map(|stage| stage.descriptors).sum(),
        bytes: run.stages.iter().map(|stage| stage.occupied).sum::<u64>() * sent(s, first),
        busiest_link: (passes * sent(s, first)) as f64,
        most_hops: u32::try_from(passes).unwrap_or(u32::MAX),
        ..Traffic::default()
    };
    let of_pixels = run.composite_passes * s.costs.sample;
    let composition = Traffic {
        messages: run.composite_passes * s.processors as u64,
        bytes: of_pixels * s.processors as u64,
        // A pass moves a pixel over as many links as a group has processors, and each link carries as many.
        busiest_link: (of_pixels * group as u64) as f64,
        most_hops: u32::try_from(run.composite_passes * group as u64).unwrap_or(u32::MAX),
        ..Traffic::default()
    };
    let delivered = delivery(&machine, s);
    let most_received = u64::from(run.received.iter().copied().max().unwrap_or(0));
    let own = u64::from(s.width) * u64::from(s.height) / group as u64;
    Ok(SortReport {
        organisation,
        processors: s.processors,
        geometry: Computing { seconds: seconds(geometry.0), mean: seconds(geometry.1) / n },
        redistribution,
        redistribution_seconds: seconds(run.stages.iter().map(|stage| stage.instructions).sum()),
        raster: Computing {
            seconds: seconds(run.raster.instructions),
            mean: seconds(pixels * machine.raster_pixel) / n,
        },
        composition,
        composition_seconds: seconds(run.composite_instructions),
        delivery: delivered.0,
        delivery_seconds: seconds(delivered.1),
        overlap: run.copies as f64 / run.visible.max(1) as f64,
        most_bytes_kept: most_received * s.costs.descriptor + own * s.costs.sample,
    })
}

/// Traffic of the finished picture, and instructions: processor 0 takes a pixel from its neighbour in every pass.
fn delivery(machine: &ring::Machine, s: &Setting) -> (Traffic, u64) {
    if s.network.delivery == Delivery::Display {
        return (Traffic::default(), 0);
    }
    let pixels = u64::from(s.width) * u64::from(s.height);
    let passes = pixels - pixels / u64::from(machine.processors.max(1));
    let bytes = passes * s.costs.delivered;
    let most_hops = machine.processors.saturating_sub(1);
    let traffic =
        Traffic { messages: passes, bytes, busiest_link: bytes as f64, most_hops, ..Traffic::default() };
    (traffic, passes * machine.pixel_pass(1))
}

fn sent(s: &Setting, first: bool) -> u64 {
    if first { s.costs.primitive } else { s.costs.descriptor }
}

/// Instructions of the geometry stage, and those of all processors together.
fn geometry(machine: &ring::Machine, run: &RingRun, first: bool) -> (u64, u64) {
    if !first {
        let all = run.polygons * machine.examine_polygon + run.visible * machine.finish_polygon;
        return (run.geometry.instructions, all);
    }
    // Every owner examines and finishes what it receives; what is not visible is examined where it starts.
    let rejected = run.polygons - run.visible;
    let of_one = machine.examine_polygon + machine.finish_polygon;
    let most = u64::from(run.received.iter().copied().max().unwrap_or(0));
    let at_home = rejected.div_ceil(u64::from(machine.processors).max(1)) * machine.examine_polygon;
    (at_home + most * of_one, rejected * machine.examine_polygon + run.copies * of_one)
}

/// Who owns which pixels: columns, or regions.
fn map(s: &Setting, group: usize, columns: bool) -> ScreenMap {
    let by_columns = || ScreenMap::columns(s.width, s.height, group as u32);
    if columns && s.region.is_none() {
        return by_columns();
    }
    let regions = s.regions(group);
    let rectangles = (0..regions.count()).map(|k| (regions.owner(k) as u32, regions.pixels(k)));
    // Regions cover the screen without overlap.
    ScreenMap::of_rectangles(&rectangles.collect::<Vec<_>>()).unwrap_or_else(|_| by_columns())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machines::builtin;
    use crate::simulators::sorting;
    use crate::workloads::synthetic::{Distribution, Spread};

    fn scene() -> BoxScene {
        let spread = [Spread::Normal { deviation: 60.0 }, Spread::Uniform];
        let (width, height, polygons) = (768, 512, 20_000);
        Distribution { width, height, polygons, visible: 0.67, size: [3.8, 12.0], spread, seed: 1 }.boxes()
    }

    /// What the description says is what the document's tables say, so both simulators take the same time.
    #[test]
    fn both_simulators_agree_on_the_princeton_engine() {
        let description = builtin("princeton-engine").unwrap().unwrap();
        let machine = ring::Machine::princeton_engine();
        assert_eq!(ring::Machine::of(&description).unwrap(), machine);
        let (scene, clock) = (scene(), 14e6);
        let all = [Organisation::SortMiddle, Organisation::SortLast];
        let setting = Setting::of(&description, 1024, (768, 512), None, &all).unwrap();
        for (organisation, group) in [
            (Organisation::SortMiddle, 1024),
            (Organisation::SortTwice(64), 64),
            (Organisation::SortTwice(16), 16),
            (Organisation::SortLast, 1),
        ] {
            let algorithm = Algorithm { group, ..Algorithm::sort_middle(&machine) };
            let map = ScreenMap::columns(768, 512, group);
            let run = ring::simulate(&machine, &algorithm, &map, &scene).unwrap();
            let class = sorting::simulate(&scene, organisation, &setting).unwrap();
            let near = |ours: f64, instructions: u64| {
                assert!(
                    (ours - instructions as f64 / clock).abs() < 1e-9,
                    "{organisation:?}: {ours} {instructions}"
                );
            };
            near(class.geometry.seconds, run.geometry.instructions);
            near(class.redistribution_seconds + class.composition_seconds, run.communication());
            near(class.raster.seconds, run.raster.instructions);
            near(class.seconds(), run.instructions());
        }
    }

    #[test]
    fn the_successor_has_the_same_words_and_instructions() {
        let magic = ring::Machine::of(&builtin("magic-1").unwrap().unwrap()).unwrap();
        // 32 bits a cycle: half as many words, rounded up for a pixel of 6 bytes.
        let words =
            ring::Machine { descriptor_words: 21, pixel_words: 2, ..ring::Machine::princeton_engine() };
        assert_eq!(magic, words);
    }

    #[test]
    fn a_picture_for_processor_0_passes_its_neighbour() {
        let description = builtin("princeton-engine").unwrap().unwrap();
        let mut setting = Setting::of(&description, 4, (64, 32), None, &[Organisation::SortMiddle]).unwrap();
        let delivered = |setting: &Setting| {
            sorting::simulate(&scene(), Organisation::SortMiddle, setting).unwrap().delivery_seconds
        };
        assert_eq!(delivered(&setting), 0.0, "it writes to the display");
        setting.network.delivery = Delivery::FirstProcessor;
        // Three quarters of 2,048 pixels, 24 instructions a pass.
        assert!((delivered(&setting) - 1536.0 * 24.0 / 14e6).abs() < 1e-12);
    }

    #[test]
    fn groups_that_do_not_divide_the_ring_are_refused() {
        let description = builtin("princeton-engine").unwrap().unwrap();
        let setting = Setting::of(&description, 10, (768, 512), None, &[Organisation::SortTwice(4)]).unwrap();
        let error = sorting::simulate(&scene(), Organisation::SortTwice(4), &setting).unwrap_err();
        assert!(error.to_string().contains("a group that divides the 10 processors, found 4"), "{error}");
    }
}
