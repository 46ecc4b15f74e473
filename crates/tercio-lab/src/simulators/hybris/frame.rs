//! A whole frame on one of the Hybris machines.

use serde::Serialize;

use super::back_end::{self, BackEnd, BackEndSettings, Sharing};
use super::front_end::{FrontEndCounts, Tiles};
use super::heap::{BankMapping, HeapLayout, PageCounts};
use super::software::{self, BackCounts, SoftwareFrame};
use super::tile_engine::EngineSettings;
use super::transfer::{Bus, Transferred};
use super::{FrontEnd, Scene};
use crate::machines::{Machine, MachineError};

/// Page misses of the SDRAM, by mapping of buffers to banks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Pages {
    /// Written with buffers assigned to banks in the order of allocation.
    pub written_in_order: PageCounts,
    /// Written with neighbouring tiles in different banks.
    pub written_by_tile: PageCounts,
    /// Read, bucket after bucket.
    pub read: PageCounts,
}

/// A frame.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HybrisFrame {
    /// Sum of the front ends.
    pub front_end: FrontEndCounts,
    /// Mean number of buckets per triangle.
    pub overlap: f64,
    /// Buffers of all heaps.
    pub buffers: u64,
    /// Their bytes.
    pub heap_bytes: u64,
    /// Tile engines; none in software.
    pub back_end: Option<BackEnd>,
    /// Seconds of the tile engines at their clock.
    pub back_end_seconds: Option<f64>,
    /// Memory pages, if the machine has SDRAM of its own.
    pub pages: Option<Pages>,
    /// The bus, if there is one.
    pub transfer: Option<Transferred>,
    /// Counts of each processor's back end.
    pub back_counts: Vec<BackCounts>,
    /// Processors, if the machine is charged for software.
    pub software: Option<SoftwareFrame>,
}

impl HybrisFrame {
    /// The tile engines, with their seconds; `None` in software.
    pub fn engines(&self) -> Option<(&BackEnd, f64)> {
        self.back_end.as_ref().zip(self.back_end_seconds)
    }

    /// Seconds of a frame: in software the front end, the barrier and the back end; on a board the longer of bus and
    /// tile engine, because they overlap (document 001, 4.5.1).
    pub fn seconds(&self) -> f64 {
        match &self.software {
            Some(software) => software.seconds(),
            None => {
                let bus = self.transfer.as_ref().map_or(0.0, |bus| bus.seconds);
                self.back_end_seconds.map_or(bus, |engines| engines.max(bus))
            }
        }
    }
}

/// Runs a frame.
///
/// # Errors
/// A machine without heap, tile engine or clock, or whose engines cannot share a frame so.
pub fn simulate(machine: &Machine, scene: &Scene, sharing: Sharing) -> Result<HybrisFrame, MachineError> {
    let heap = machine.need(machine.heap.as_ref(), "heap")?;
    let engine = machine.need(machine.tile_engine.as_ref(), "tile-engine")?;
    let clock = machine.clock()?;
    let tiles = Tiles { width: scene.width, height: scene.height, edge: engine.tile.whole() as u32 };
    let layout = HeapLayout::of(heap);
    let fronts = FrontEnd::run_parallel(scene, tiles, layout, heap.heaps.whole() as usize);
    let counts = fronts.iter().fold(FrontEndCounts::default(), |sum, f| sum.plus(f.counts));
    let settings = BackEndSettings {
        engine: EngineSettings::of(engine),
        engines: engine.engines.whole() as usize,
        sharing,
        output: engine.output.whole(),
    };
    let cannot = |what| MachineError::Sharing { machine: machine.name.clone(), what };
    let is_software = !machine.costs.is_empty();
    if is_software && sharing != Sharing::Tiles {
        return Err(cannot(
            "processors share tiles only: it has no tile engines, but costs of software".into(),
        ));
    }
    let back_end = if is_software {
        None
    } else {
        Some(back_end::run(&fronts, tiles, settings).ok_or_else(|| {
            let found = engine.engines.whole();
            cannot(format!("tile-engine.engines: expected an even number for hybrid sharing, found {found}"))
        })?)
    };
    let pages = machine.sdram.as_ref().map(|sdram| {
        let sum = |of: &dyn Fn(&FrontEnd) -> PageCounts| {
            fronts.iter().map(of).fold(PageCounts::default(), PageCounts::plus)
        };
        let columns = tiles.columns();
        Pages {
            written_in_order: sum(&|f| f.heap.write_pages(sdram, BankMapping::InOrder, columns)),
            written_by_tile: sum(&|f| f.heap.write_pages(sdram, BankMapping::ByTile, columns)),
            read: sum(&|f| f.heap.read_pages(sdram, BankMapping::ByTile, columns)),
        }
    });
    let transfer = machine
        .transfer
        .as_ref()
        .map(|t| Bus::of(t).heaps(&fronts, tiles.count(), layout.buffer, t.block.whole()));
    let back_counts = software::back_counts(&fronts, tiles, settings.engines);
    let fronts_counts: Vec<_> = fronts.iter().map(|f| f.counts).collect();
    let software = is_software.then(|| software::frame(machine, &fronts_counts, &back_counts));
    Ok(HybrisFrame {
        front_end: counts,
        overlap: counts.overlap(),
        buffers: fronts.iter().map(|f| f.heap.buffers()).sum(),
        heap_bytes: fronts.iter().map(|f| f.heap.bytes()).sum(),
        back_end_seconds: back_end.as_ref().map(|engines| engines.cycles as f64 / clock),
        back_end,
        pages,
        transfer,
        back_counts,
        software,
    })
}

#[cfg(test)]
mod tests {
    use tercio_mesh::builtin;

    use super::*;
    use crate::machines::builtin as machine;
    use crate::predict::views;
    use crate::simulators::hybris::scene::project;

    fn scene() -> Scene {
        let mesh = builtin::make("builtin:teapot@5k").unwrap();
        let camera = views::camera(&mesh.bounds(), (320, 256), 0, 1);
        project(&mesh, &camera, (320, 256)).unwrap()
    }

    fn frame(name: &str, sharing: Sharing) -> HybrisFrame {
        simulate(&machine(name).unwrap().unwrap(), &scene(), sharing).unwrap()
    }

    #[test]
    fn all_machines_draw_the_same() {
        let one = frame("hybris-asic", Sharing::Tiles);
        let c = one.front_end;
        assert_eq!(c.triangles, c.nodes + c.back_facing + c.sub_pixel + c.outside);
        let total = one.back_end.as_ref().unwrap().total();
        let pixels = total.pixels;
        assert_eq!(total.triangles, c.entries);
        for (name, sharing) in [
            ("hybris-asic-2x2", Sharing::Tiles),
            ("hybris-asic-two-engines", Sharing::Tiles),
            ("hybris-asic-two-engines", Sharing::Composition),
            ("hybris-asic-two-engines", Sharing::Hybrid),
            ("hybris-fpga", Sharing::Tiles),
            ("hybris-dual-cpu", Sharing::Tiles),
        ] {
            let other = frame(name, sharing);
            assert_eq!(other.front_end.nodes, c.nodes, "{name}");
            // In hardware and in software.
            let of_engines = other.back_end.as_ref().map(|engines| engines.total().pixels);
            let of_processors = other.back_counts.iter().map(|b| b.pixels).sum::<u64>();
            assert_eq!((of_engines.unwrap_or(pixels), of_processors), (pixels, pixels), "{name}");
            assert_eq!(other.back_counts.iter().map(|b| b.entries).sum::<u64>(), c.entries, "{name}");
        }
    }

    /// One engine has no pairs; four share tiles and triangles, and are faster than pairs that share triangles only.
    #[test]
    fn hybrid_sharing_needs_pairs() {
        let mut of = machine("hybris-asic-two-engines").unwrap().unwrap();
        let mut run = |engines: f64, sharing| {
            of.tile_engine.as_mut().unwrap().engines.value = engines;
            simulate(&of, &scene(), sharing)
        };
        let [two, four] = [2.0, 4.0].map(|n| run(n, Sharing::Hybrid).unwrap().back_end.unwrap());
        assert!(four.cycles < two.cycles && four.total().pixels == two.total().pixels);
        assert!(four.engines.iter().all(|engine| engine.pixels > 0), "{four:?}");
        for odd in [1.0, 3.0] {
            let error = run(odd, Sharing::Hybrid).unwrap_err().to_string();
            let expected = format!("expected an even number for hybrid sharing, found {odd}");
            assert!(error.contains(&expected), "{error}");
        }
    }

    /// What is drawn in software has no cycles of tile engines, and no other way to share.
    #[test]
    fn software_has_no_tile_engines() {
        let dual = machine("hybris-dual-cpu").unwrap().unwrap();
        for sharing in [Sharing::Composition, Sharing::Hybrid] {
            let error = simulate(&dual, &scene(), sharing).unwrap_err().to_string();
            assert!(error.contains("share tiles only"), "{error}");
        }
        let keys = |name: &str| serde_json::to_value(frame(name, Sharing::Tiles)).unwrap();
        let (software, hardware) = (keys("hybris-dual-cpu"), keys("hybris-asic"));
        for key in ["back_end", "back_end_seconds"] {
            assert!(software[key].is_null() && !hardware[key].is_null(), "{key}");
        }
    }

    #[test]
    fn parallel_engines_are_faster_but_at_most_by_their_number() {
        let one = frame("hybris-asic", Sharing::Tiles).back_end.unwrap().cycles;
        for (name, sharing, engines) in [
            ("hybris-asic-2x2", Sharing::Tiles, 4),
            ("hybris-asic-two-engines", Sharing::Tiles, 2),
            ("hybris-asic-two-engines", Sharing::Composition, 2),
        ] {
            let more = frame(name, sharing).back_end.unwrap().cycles;
            assert!(more < one && more * engines >= one, "{name}: {more} against {one}");
        }
    }

    #[test]
    fn two_processors_halve_all_but_the_serial_part() {
        let (one, two) =
            (frame("hybris-single-cpu", Sharing::Tiles), frame("hybris-dual-cpu", Sharing::Tiles));
        let (one, two) = (one.software.unwrap(), two.software.unwrap());
        assert_eq!(one.serial, two.serial);
        assert_eq!((one.front.len(), two.front.len()), (1, 2));
        let work = |f: &SoftwareFrame| f.front.iter().chain(&f.back).sum::<f64>();
        assert!((work(&one) - work(&two)).abs() < 1e-12 * work(&one));
        // The loss at the barrier is what is missing to half the time.
        assert!((two.seconds() - two.serial - (work(&two) + two.waiting()) / 2.0).abs() < 1e-12);
    }
}
