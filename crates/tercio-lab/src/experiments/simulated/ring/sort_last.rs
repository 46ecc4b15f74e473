//! Sparse sort-last, which chapter 4 has as a formula only: every rasterized pixel travels on the ring to its owner.

use super::super::super::facts::Facts;
use super::super::super::sweep::sweep;
use super::super::super::{Axis, Comparison, ExperimentError, Findings, Plot, Series, Table};
use super::{SCREEN, crossover};
use crate::models::eldridge::comparison::sort_last_sparse;
use crate::published::ToleranceSource;
use crate::simulators::ring::{Algorithm, Machine, RingRun, simulate};
use crate::units::{Instructions, Pixels, Polygons, Processors};
use crate::workloads::synthetic::{Distribution, Spread};
use crate::workloads::{BoundingBox, BoxScene, PixelBox, ScreenMap};

/// Pixels along the side of a polygon: A = 100 (table 4.3).
const SIDE: u32 = 10;
const PROCESSORS: u32 = 1024;

/// Polygons all over the screen.
fn polygons(count: u32) -> BoxScene {
    Distribution {
        width: SCREEN.0,
        height: SCREEN.1,
        polygons: count,
        visible: 1.0,
        size: [f64::from(SIDE); 2],
        spread: [Spread::Uniform; 2],
        seed: 1995,
    }
    .boxes()
}

/// The pixels of polygons as descriptors of their own. Polygon i is rasterized on processor i mod n, which a ring of n gives
/// every n-th descriptor; where a processor has none left, its place holds one that is not visible.
fn pixels(scene: &BoxScene, processors: u32) -> BoxScene {
    let n = processors as usize;
    let mut of_processor = vec![Vec::new(); n];
    for (number, polygon) in scene.boxes.iter().enumerate() {
        let PixelBox { x0, y0, x1, y1 } = polygon.pixels;
        let all = (y0..=y1).flat_map(|y| (x0..=x1).map(move |x| PixelBox { x0: x, y0: y, x1: x, y1: y }));
        of_processor[number % n].extend(all.map(|pixels| BoundingBox { visible: true, pixels }));
    }
    let most = of_processor.iter().map(Vec::len).max().unwrap_or(0);
    let none = BoundingBox { visible: false, pixels: PixelBox { x0: 0, y0: 0, x1: 0, y1: 0 } };
    let turn = |turn: usize| of_processor.iter().map(move |own| own.get(turn).copied().unwrap_or(none));
    BoxScene { boxes: (0..most).flat_map(turn).collect() }
}

/// The ring with pixels for descriptors, those of table 4.2: a and b.
fn machine(processors: u32, [a, b]: [f64; 2]) -> Machine {
    Machine { processors, descriptor_words: a as u64, pass_overhead: b as u64, ..Machine::princeton_engine() }
}

/// Sends pixels to the owners of their columns. Slots are freed after every `test_period` passes.
fn send(scene: &BoxScene, machine: &Machine, test_period: u32) -> Result<RingRun, ExperimentError> {
    let algorithm = Algorithm { test_period, ..Algorithm::sort_middle(machine) };
    let map = ScreenMap::columns(SCREEN.0, SCREEN.1, machine.processors);
    let run = simulate(machine, &algorithm, &map, &pixels(scene, machine.processors))?;
    if run.checks.passed() { Ok(run) } else { Err(format!("a pixel is lost: {:?}", run.checks).into()) }
}

/// Where a rising curve reaches `level`.
fn reaches(points: &[(f64, f64)], level: f64) -> Option<f64> {
    crossover(&points.iter().map(|&(x, y)| (x, y, level)).collect::<Vec<_>>())
}

/// As many polygons on every processor, and the document's number, which is two or three.
const POLYGONS: [u32; 7] = [1024, 2048, 2534, 3072, 4096, 5120, 6144];

/// Section 4.4.2.
pub fn sparse_and_dense() -> Result<Findings, ExperimentError> {
    let facts = Facts::load()?;
    let id = "E4.2-sl-sparse";
    let ring = machine(PROCESSORS, [facts.given(id, "a")?, facts.given(id, "b")?]);
    let runs = sweep(&POLYGONS, |&count| {
        let scene = polygons(count);
        let turn = send(&scene, &ring, PROCESSORS)?;
        let freed = send(&scene, &ring, 1)?;
        let columns = Algorithm::sort_middle(&Machine::princeton_engine());
        let map = ScreenMap::columns(SCREEN.0, SCREEN.1, PROCESSORS);
        let middle = simulate(&Machine::princeton_engine(), &columns, &map, &scene)?;
        Ok((f64::from(count), turn, freed, middle))
    })?;
    // Dense sort-last is sort-twice with groups of one.
    let alone = Algorithm { group: 1, ..Algorithm::sort_middle(&ring) };
    let dense_passes = alone.composite_passes(&ring, u64::from(SCREEN.0 * SCREEN.1)) as f64;
    let printed_pass = facts.printed("E4.2-sl-dense")?;
    let [dense, dense_printed] = [ring.pixel_pass(1) as f64, printed_pass].map(|pass| pass * dense_passes);

    let mut table = Table::new(
        "instructions",
        &[
            ("polygons", ""),
            ("freed after a turn", "instr"),
            ("freed at the owner", "instr"),
            ("equation 4.5 without work", "instr"),
            ("dense", "instr"),
            ("most pixels rasterized, sort-last", ""),
            ("most pixels rasterized, sort-middle", ""),
        ],
    );
    let mut comparison = Comparison::new();
    let (mut whole, mut after_turn, mut at_owner, mut formula) =
        (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let (mut even, mut half) = (true, Vec::new());
    for (p, turn, freed, middle) in &runs {
        let equation = sort_last_sparse(
            Polygons::new(*p),
            Processors::new(f64::from(PROCESSORS)),
            Instructions::new(0.0),
            Pixels::new(f64::from(SIDE * SIDE)),
            Instructions::new(0.0),
            Instructions::new(ring.pass(1) as f64),
        )
        .get();
        let [turn, freed] =
            [turn, freed].map(|run| (run.communication() as f64, run.sent.iter().copied().max()));
        let most = f64::from(turn.1.unwrap_or(0));
        table.push([
            (*p).into(),
            turn.0.into(),
            freed.0.into(),
            equation.into(),
            dense.into(),
            most.into(),
            (middle.raster.pixels as f64).into(),
        ]);
        even &= most < middle.raster.pixels as f64;
        half.push(freed.0 / turn.0);
        after_turn.push((*p, turn.0));
        at_owner.push((*p, freed.0));
        formula.push((*p, equation));
        if p % f64::from(PROCESSORS) == 0.0 {
            whole.push((*p, turn.0));
            let name = format!("communication of {p} polygons over equation 4.5");
            // The equation's distance of n is what a slot that is held for a whole turn has.
            comparison.add_constructed(name, turn.0 / equation, 1.0, 0.0, ToleranceSource::Exact);
        }
    }
    let printed = facts.printed("E4.11")?;
    let crossing = |level| reaches(&whole, level).ok_or("the curves cross");
    // A picture passes n - 1 of n processors, where equation 4.4 counts n ("pessimistically").
    let tolerance = printed / f64::from(PROCESSORS) + 0.5;
    let name = "polygons from which dense is cheaper, a pass of it taken as 29";
    comparison.add_constructed(name, crossing(dense_printed)?, printed, tolerance, ToleranceSource::Bound);
    let corrected = crossing(dense)?;
    comparison.claim("sort-last rasterizes evenly, sort-middle does not", even);
    let uneven = after_turn.iter().zip(&formula).find(|(p, _)| p.0 % f64::from(PROCESSORS) != 0.0);
    let uneven = uneven.map_or(f64::NAN, |(ours, equation)| 100.0 * (ours.1 / equation.1 - 1.0));
    let freed = reaches(&at_owner, dense)
        .map_or("beyond the scenes that are tried".to_owned(), |p| format!("from about {p:.0} polygons on"));
    let (least, most) = half.iter().fold((f64::MAX, 0.0f64), |(l, m), &h| (l.min(h), m.max(h)));
    let plot = Plot::new(
        "instructions",
        "Communication of sort-last on 1024 processors",
        Axis::linear("polygons of 100 pixels"),
        Axis::linear("instructions"),
    )
    .with(Series::line_points("sparse, slots freed after a turn", after_turn))
    .with(Series::line_points("sparse, slots freed at the owner", at_owner))
    .with(Series::line("dense", formula.iter().map(|p| (p.0, dense)).collect()))
    .with(Series::line("equation 4.5", formula).like("sparse, slots freed after a turn"))
    .with(Series::printed_places("crossing in print", [printed]));
    Ok(Findings {
        tables: vec![table],
        plots: vec![plot],
        remarks: vec![
            "Random polygons of 10 x 10 pixels are dealt out to the processors, and each of their pixels is sent to the owner \
             of its column by the ring's simulator, as descriptors of five words. The document's distance of n is that of \
             slots that are freed after a whole turn."
                .into(),
            format!(
                "Table 4.2 prints 29 for a pass of dense sort-last, where 3 * 3 + 15 is 24; with 24 the curves cross at \
                 {corrected:.0} polygons, not at 2,534."
            ),
            format!(
                "Equation 4.5 holds where all processors have as many polygons. With 2,534, two or three on each, the ring \
                 needs {uneven:.1} % more passes."
            ),
            format!(
                "A ring that frees a slot at the pixel's owner needs {:.0} to {:.0} % of these passes; dense sort-last is then \
                 cheaper {freed}.",
                100.0 * least,
                100.0 * most
            ),
        ],
        verdict: comparison.qualitative(
            "The equation counts a whole turn for each pixel, and so does the run that is compared with it; dense sort-last is the \
             document's formula.",
        ),
    })
}

#[cfg(test)]
mod tests {
    use std::collections::VecDeque;

    use super::*;

    /// Passes of a ring whose slots are looked at one by one: a list of distances to go per processor.
    fn passes(queues: &[Vec<usize>], test_period: usize) -> u64 {
        let n = queues.len();
        let mut queues: Vec<VecDeque<usize>> = queues.iter().map(|q| q.iter().copied().collect()).collect();
        let mut ring: Vec<Option<usize>> = vec![None; n];
        for pass in 1.. {
            for (slot, queue) in ring.iter_mut().zip(&mut queues) {
                *slot = slot.or_else(|| queue.pop_front());
            }
            if ring.iter().all(Option::is_none) {
                return pass - 1;
            }
            ring.rotate_right(1);
            for slot in &mut ring {
                *slot = slot.map(|left| left.saturating_sub(1));
                if *slot == Some(0) && (pass as usize).is_multiple_of(test_period) {
                    *slot = None;
                }
            }
        }
        0
    }

    #[test]
    fn pixels_travel_as_counted_slot_by_slot() {
        const N: u32 = 12;
        let scene = polygons(31);
        let map = ScreenMap::columns(SCREEN.0, SCREEN.1, N);
        let mut queues = vec![Vec::new(); N as usize];
        for (number, polygon) in scene.boxes.iter().enumerate() {
            let from = number % N as usize;
            let PixelBox { x0, y0, x1, y1 } = polygon.pixels;
            for x in (y0..=y1).flat_map(|_| x0..=x1) {
                // Columns in blocks of 64.
                let owner = x as usize / 64;
                let distance = (owner + N as usize - from) % N as usize;
                if distance > 0 {
                    queues[from].push(distance);
                }
            }
        }
        assert_eq!(map.processors(), N);
        let ring = machine(N, [5.0, 30.0]);
        for period in [1, N] {
            let run = send(&scene, &ring, period).unwrap();
            assert_eq!(run.passes(), passes(&queues, period as usize), "{period}");
            assert_eq!(run.communication(), 45 * run.passes());
            assert_eq!(run.received.iter().map(|&r| u64::from(r)).sum::<u64>(), 31 * 100);
        }
        // A turn of the ring carries a pixel a slot.
        let sent: usize = queues.iter().map(Vec::len).sum();
        assert!(send(&scene, &ring, N).unwrap().passes() >= sent as u64);
    }

    #[test]
    fn every_pixel_starts_where_its_polygon_is() {
        let scene = polygons(5);
        let all = pixels(&scene, 3);
        assert_eq!((all.boxes.len(), all.visible()), (600, 500));
        for (k, b) in all.boxes.iter().enumerate().filter(|(_, b)| b.visible) {
            let own = scene.boxes.iter().enumerate().filter(|(i, _)| i % 3 == k % 3);
            assert!(own.into_iter().any(|(_, o)| o.pixels.intersection(&b.pixels).is_some()), "{k}");
        }
    }

    #[test]
    fn a_level_is_reached_between_two_points() {
        assert_eq!(reaches(&[(0.0, 0.0), (10.0, 20.0), (20.0, 60.0)], 30.0), Some(12.5));
        assert_eq!(reaches(&[(0.0, 0.0), (10.0, 20.0)], 30.0), None);
    }
}
