//! The two loops.

use serde::Serialize;

use super::scan::{Segment, lines, segments};
use crate::workloads::PolygonScene;

/// A data-parallel machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Machine {
    /// Processors.
    pub processors: u64,
    /// Segments that are collected before they are split into pixels. The buffer is checked after each pass over scan
    /// lines, and may contain more by then.
    pub buffer: u64,
}

/// Counts of the loops.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Run {
    /// Polygons.
    pub polygons: u64,
    /// Passes over scan lines: the lines of the tallest polygon.
    pub line_passes: u64,
    /// Steps of these passes, each of at most one polygon a processor.
    pub line_steps: u64,
    /// Lines of all polygons: how often a polygon had work in a pass.
    pub lines: u64,
    /// Segments.
    pub segments: u64,
    /// How often the buffer was emptied.
    pub flushes: u64,
    /// Passes over pixels: the longest segment of every buffer.
    pub pixel_passes: u64,
    /// Steps of these passes, each of at most one segment a processor.
    pub pixel_steps: u64,
    /// Pixels sent to the picture.
    pub pixels: u64,
    /// Pixels outside the picture.
    pub clipped: u64,
    /// Pixels that collided with another one of the same pass at their destination.
    pub collisions: u64,
}

impl Run {
    /// The share of polygons that had work, over all passes over lines; 0 without passes.
    pub fn line_utilization(&self) -> f64 {
        self.lines as f64 / (self.line_passes * self.polygons).max(1) as f64
    }

    /// The share of steps over segments in which a processor had a pixel.
    pub fn pixel_utilization(&self, machine: &Machine) -> f64 {
        (self.pixels + self.clipped) as f64 / (self.pixel_steps * machine.processors).max(1) as f64
    }
}

/// The picture: of each pixel the nearest polygon, the last one in the scene among equals.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Pixels, row by row: depth and number of the polygon, `None` where there is none.
    pub pixels: Vec<Option<(f64, u32)>>,
}

/// Draws a scene; polygons show both sides.
///
/// # Panics
/// If the machine has no processor.
pub fn simulate(machine: &Machine, scene: &PolygonScene) -> (Run, Picture) {
    assert!(machine.processors > 0, "a machine has processors");
    let spans: Vec<(i32, u32)> = scene.polygons.iter().map(lines).collect();
    let mut run = Run { polygons: scene.polygons.len() as u64, ..Run::default() };
    run.line_passes = spans.iter().map(|s| u64::from(s.1)).max().unwrap_or(0);
    run.line_steps = run.line_passes * run.polygons.div_ceil(machine.processors);
    run.lines = spans.iter().map(|s| u64::from(s.1)).sum();

    let mut picture = Picture { pixels: vec![None; scene.width as usize * scene.height as usize] };
    let mut buffer = Vec::new();
    // Tallest polygons last, so that those with lines left are at the end of the list.
    let mut order: Vec<u32> = (0..scene.polygons.len() as u32).collect();
    order.sort_by_key(|&p| spans[p as usize].1);
    let mut begin = 0;
    for pass in 0..run.line_passes {
        while u64::from(spans[order[begin] as usize].1) <= pass {
            begin += 1;
        }
        for &polygon in &order[begin..] {
            let line = spans[polygon as usize].0 + pass as i32;
            segments(&scene.polygons[polygon as usize], polygon, line, &mut buffer);
        }
        if buffer.len() as u64 >= machine.buffer.max(1) || pass + 1 == run.line_passes {
            flush(machine, scene, &mut buffer, &mut run, &mut picture);
        }
    }
    (run, picture)
}

/// Splits the segments of the buffer into pixels.
fn flush(
    machine: &Machine,
    scene: &PolygonScene,
    buffer: &mut Vec<Segment>,
    run: &mut Run,
    picture: &mut Picture,
) {
    if buffer.is_empty() {
        return;
    }
    let count = buffer.len() as u64;
    let longest = buffer.iter().map(|s| u64::from(s.length)).max().unwrap_or(0);
    run.flushes += 1;
    run.segments += count;
    run.pixel_passes += longest;
    run.pixel_steps += longest * count.div_ceil(machine.processors);

    // Segments send their pixels in lockstep, so two collide only if they begin at the same pixel of a line: then all
    // pixels of the shorter one collide.
    buffer.sort_unstable_by_key(|s| (s.y, s.first, s.length));
    for (number, segment) in buffer.iter().enumerate() {
        let seen = draw(scene, segment, picture);
        run.pixels += seen;
        run.clipped += u64::from(segment.length) - seen;
        let shorter = buffer.get(number + 1).is_some_and(|s| (s.y, s.first) == (segment.y, segment.first));
        run.collisions += if shorter { seen } else { 0 };
    }
    buffer.clear();
}

/// Sends a segment's pixels; returns how many are in the picture.
fn draw(scene: &PolygonScene, segment: &Segment, picture: &mut Picture) -> u64 {
    if segment.y < 0 || segment.y >= scene.height as i32 {
        return 0;
    }
    let end = (i64::from(segment.first) + i64::from(segment.length)).min(i64::from(scene.width));
    let first = segment.first.max(0);
    let row = segment.y as usize * scene.width as usize;
    for x in first..end as i32 {
        let depth = segment.depth + segment.depth_step * f64::from(x - segment.first);
        let place = &mut picture.pixels[row + x as usize];
        // The larger depth, then the larger colour: the maximum of depth in the high and colour in the low bits.
        let nearer = place.is_none_or(|(d, polygon)| depth > d || (depth == d && segment.polygon > polygon));
        if nearer {
            *place = Some((depth, segment.polygon));
        }
    }
    (end - i64::from(first)).max(0) as u64
}
