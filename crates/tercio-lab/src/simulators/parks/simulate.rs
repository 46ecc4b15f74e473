//! A scene on all processors of a machine.

use super::polygon::Polygon;
use super::split::clip;
use super::statistics::Distribution;
use super::{Costs, Machine, MachineError, Place};
use crate::workloads::PixelBox;

/// The statistics of one processor, in the terms of the document's appendix C.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ProcessorRun {
    /// Its share of the screen.
    pub place: Place,
    /// `v`: vertices per polygon.
    pub vertices_per_polygon: Distribution,
    /// `y`: lines on this processor per polygon, which are its segments.
    pub segments_per_polygon: Distribution,
    /// `l`: pixels on this processor per segment.
    pub pixels_per_segment: Distribution,
    /// `D`: polygons per pixel of this processor.
    pub polygons_per_pixel: Distribution,
    /// `area`: pixels on this processor per polygon.
    pub pixels_per_polygon: Distribution,
}

impl ProcessorRun {
    /// N: polygons that it receives.
    pub fn polygons(&self) -> u64 {
        self.vertices_per_polygon.points()
    }

    /// V: their vertices.
    pub fn vertices(&self) -> u64 {
        self.vertices_per_polygon.sum()
    }

    /// S: their lines on this processor.
    pub fn segments(&self) -> u64 {
        self.segments_per_polygon.sum()
    }

    /// Segments it pays for: at least one a polygon (see [`Costs::total`]).
    pub fn charged_segments(&self) -> u64 {
        self.segments_per_polygon.counts().map(|(lines, times)| lines.max(1) * times).sum()
    }

    /// P: their pixels on this processor.
    pub fn pixels(&self) -> u64 {
        self.pixels_per_segment.sum()
    }
}

/// A scene on a machine.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneRun {
    /// The processors, by number.
    pub processors: Vec<ProcessorRun>,
    /// Memory cycles of each.
    pub cycles: Vec<f64>,
}

impl SceneRun {
    /// Number and memory cycles of the slowest processor, the first of equal ones: the machine's time.
    ///
    /// # Panics
    /// Never: a machine has processors.
    pub fn slowest(&self) -> (usize, f64) {
        let numbered = self.cycles.iter().copied().enumerate();
        numbered.reduce(|a, b| if b.1 > a.1 { b } else { a }).expect("a machine has processors")
    }

    /// Number and memory cycles of the fastest processor, the first of equal ones.
    ///
    /// # Panics
    /// Never: a machine has processors.
    pub fn fastest(&self) -> (usize, f64) {
        let numbered = self.cycles.iter().copied().enumerate();
        numbered.reduce(|a, b| if b.1 < a.1 { b } else { a }).expect("a machine has processors")
    }
}

/// Draws a scene of polygons on a screen of these pixels; polygons may extend beyond it.
///
/// # Errors
/// [`MachineError`] if the screen cannot be divided so.
pub fn simulate(
    machine: &Machine,
    costs: &Costs,
    (width, height): (u32, u32),
    polygons: &[Polygon],
) -> Result<SceneRun, MachineError> {
    let k = machine.interlace as usize;
    let mut processors: Vec<ProcessorRun> = machine.places(width, height)?.into_iter().map(empty).collect();
    for (chunk, processors) in machine.chunks(width, height)?.iter().zip(processors.chunks_mut(k * k)) {
        // Number of polygons at each pixel of the chunk, row by row.
        let mut depth = vec![0u64; chunk.area() as usize];
        for piece in polygons.iter().filter_map(|p| clip(p, chunk)) {
            let (mut lines, mut area) = (vec![0u64; k], vec![0u64; k * k]);
            for span in &piece.spans {
                let row = (span.y - chunk.y0) as usize;
                let [first, last] = [span.first, span.last].map(|x| (x - chunk.x0) as usize);
                let start = row * chunk.width() as usize;
                depth[start + first..=start + last].iter_mut().for_each(|d| *d += 1);
                lines[row % k] += 1;
                for column in 0..k {
                    let pixels = own_pixels(last + 1, column, k) - own_pixels(first, column, k);
                    let number = row % k * k + column;
                    area[number] += pixels;
                    processors[number].pixels_per_segment.add(pixels, 1);
                }
            }
            for (number, run) in processors.iter_mut().enumerate() {
                run.vertices_per_polygon.add(u64::from(piece.vertices), 1);
                run.segments_per_polygon.add(lines[number / k], 1);
                run.pixels_per_polygon.add(area[number], 1);
            }
        }
        count_depth(chunk, k, &depth, processors);
    }
    let cycles = processors.iter().map(|run| costs.total(run)).collect();
    Ok(SceneRun { processors, cycles })
}

fn empty(place: Place) -> ProcessorRun {
    ProcessorRun {
        place,
        vertices_per_polygon: Distribution::default(),
        segments_per_polygon: Distribution::default(),
        pixels_per_segment: Distribution::default(),
        polygons_per_pixel: Distribution::default(),
        pixels_per_polygon: Distribution::default(),
    }
}

/// How many of the first `pixels` pixels of a line belong to one of `k` processors.
fn own_pixels(pixels: usize, processor: usize, k: usize) -> u64 {
    ((pixels + k - 1 - processor) / k) as u64
}

fn count_depth(chunk: &PixelBox, k: usize, depth: &[u64], processors: &mut [ProcessorRun]) {
    for (y, row) in depth.chunks(chunk.width() as usize).enumerate() {
        for (x, &polygons) in row.iter().enumerate() {
            processors[y % k * k + x % k].polygons_per_pixel.add(polygons, 1);
        }
    }
}
