//! One frame on a ring machine: geometry, communication, rasterization, compositing.

use serde::Serialize;

use super::destinations::{Destinations, Route};
use super::receipts::Receipts;
use super::stage::{Descriptor, Stage};
use super::{Algorithm, AlgorithmError, Checks, Machine};
use crate::workloads::{BoxScene, ScreenMap};

/// The geometry stage, limited by its busiest processor (A.2.1).
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct GeometryRun {
    /// Polygons that the busiest processor examines: ceil(p m / n).
    pub examined: u64,
    /// Visible polygons that the busiest processor finishes.
    pub finished: u64,
    /// Instructions.
    pub instructions: u64,
}

/// The passes of one stride.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct StageRun {
    /// Processors that a pass moves over.
    pub stride: u32,
    /// Passes.
    pub passes: u64,
    /// Descriptors that took a slot.
    pub descriptors: u64,
    /// Slots times passes in which they held a descriptor.
    pub occupied: u64,
    /// Instructions.
    pub instructions: u64,
}

/// The rasterization stage, limited by its busiest processor (A.2.3).
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct RasterRun {
    /// Pixels of bounding boxes that the busiest processor rasterizes.
    pub pixels: u64,
    /// Instructions.
    pub instructions: u64,
}

/// One frame.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct RingRun {
    /// Polygons of the model.
    pub polygons: u64,
    /// Those that are visible.
    pub visible: u64,
    /// Geometry.
    pub geometry: GeometryRun,
    /// Communication, one entry a stride.
    pub stages: Vec<StageRun>,
    /// Rasterization.
    pub raster: RasterRun,
    /// Passes of pixels, 0 with one group.
    pub composite_passes: u64,
    /// Instructions of compositing.
    pub composite_instructions: u64,
    /// Polygons that each processor sends.
    pub sent: Vec<u32>,
    /// Polygons that each processor rasterizes.
    pub received: Vec<u32>,
    /// Copies of polygons that were rasterized.
    pub copies: u64,
    /// The checks of appendix A.3.
    pub checks: Checks,
}

impl RingRun {
    /// Instructions of communication, compositing included.
    pub fn communication(&self) -> u64 {
        self.stages.iter().map(|s| s.instructions).sum::<u64>() + self.composite_instructions
    }

    /// Instructions of the frame.
    pub fn instructions(&self) -> u64 {
        self.geometry.instructions + self.communication() + self.raster.instructions
    }

    /// Passes of polygons, over all strides.
    pub fn passes(&self) -> u64 {
        self.stages.iter().map(|s| s.passes).sum()
    }

    /// o: processors that rasterize a visible polygon, on average.
    pub fn overlap(&self) -> f64 {
        self.copies as f64 / self.visible.max(1) as f64
    }

    /// f: polygons of the busiest processor over the mean.
    pub fn asymmetry(&self) -> f64 {
        let most = f64::from(self.received.iter().copied().max().unwrap_or(0));
        most * self.received.len() as f64 / self.copies.max(1) as f64
    }
}

/// Draws a frame.
///
/// Memory is about 40 bytes per visible polygon plus 16 per copy between two stages.
///
/// # Errors
/// [`AlgorithmError`] if algorithm, machine and screen map do not match.
pub fn simulate(
    machine: &Machine,
    algorithm: &Algorithm,
    map: &ScreenMap,
    scene: &BoxScene,
) -> Result<RingRun, AlgorithmError> {
    algorithm.check(machine, map.processors())?;
    let n = machine.processors;
    let pixels = u64::from(map.width()) * u64::from(map.height());
    let mut run = RingRun {
        polygons: scene.boxes.len() as u64,
        visible: scene.visible(),
        sent: vec![0; n as usize],
        received: vec![0; n as usize],
        composite_passes: algorithm.composite_passes(machine, pixels),
        ..RingRun::default()
    };
    run.composite_instructions = run.composite_passes * machine.pixel_pass(algorithm.group);

    let (destinations, raster_pixels) = place(machine, algorithm, map, scene, &mut run);
    let examined = (run.polygons * u64::from(algorithm.duplication)).div_ceil(u64::from(n));
    let finished = u64::from(run.sent.iter().copied().max().unwrap_or(0));
    run.geometry = GeometryRun {
        examined,
        finished,
        instructions: examined * machine.examine_polygon + finished * machine.finish_polygon,
    };
    let busiest = raster_pixels.into_iter().max().unwrap_or(0);
    run.raster = RasterRun { pixels: busiest, instructions: busiest * machine.raster_pixel };
    communicate(machine, algorithm, &destinations, &mut run);
    Ok(run)
}

/// Finds the route of every visible polygon, and the pixels that each processor will rasterize.
fn place(
    machine: &Machine,
    algorithm: &Algorithm,
    map: &ScreenMap,
    scene: &BoxScene,
    run: &mut RingRun,
) -> (Destinations, Vec<u64>) {
    let n = machine.processors;
    let mut destinations = Destinations::default();
    let mut raster_pixels = vec![0u64; n as usize];
    let mut route = Route::default();
    for (number, polygon) in scene.boxes.iter().enumerate().filter(|(_, b)| b.visible) {
        route.find(machine, algorithm, map, number as u64, &polygon.pixels);
        run.sent[route.source as usize] += 1;
        for &(offset, pixels) in &route.stops {
            raster_pixels[((route.source + offset) % n) as usize] += pixels;
        }
        if !route.stops.is_empty() {
            destinations.push(&route);
        }
    }
    (destinations, raster_pixels)
}

/// Runs the stages; the polygons received in one stage are sent in the next, in order of receipt.
fn communicate(machine: &Machine, algorithm: &Algorithm, destinations: &Destinations, run: &mut RingRun) {
    let n = machine.processors;
    let mut queues = vec![Vec::new(); n as usize];
    for polygon in 0..destinations.len() as u32 {
        let descriptor = Descriptor { polygon, base: 0, end: algorithm.group - 1 };
        queues[destinations.source(polygon) as usize].push(descriptor);
    }
    let mut receipts = Receipts::new(destinations);
    for (number, &stride) in algorithm.strides.iter().enumerate() {
        let stage = Stage { processors: n, stride, test_period: algorithm.test_period };
        let last = number + 1 == algorithm.strides.len();
        let mut received = Vec::new();
        let passes = stage.run(destinations, &queues, |pass, processor, copy| {
            if last {
                run.received[processor as usize] += 1;
                receipts.record(copy.polygon, copy.base);
            } else {
                received.push((pass, processor, copy));
            }
        });
        // A processor receives at most one copy per pass, so this is its order of receipt.
        received.sort_by_key(|&(pass, ..)| pass);
        for queue in &mut queues {
            queue.clear();
        }
        for (_, processor, copy) in received {
            queues[processor as usize].push(copy);
        }
        run.stages.push(StageRun {
            stride,
            passes: passes.passes,
            descriptors: passes.descriptors,
            occupied: passes.occupied,
            instructions: passes.passes * machine.pass(stride),
        });
    }
    (run.checks, run.copies) = receipts.finish();
}
