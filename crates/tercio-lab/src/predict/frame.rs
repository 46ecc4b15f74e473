//! Counts and costs become times: one process on some threads.

use serde::Serialize;

use super::counters::Counters;
use crate::machines::{Machine, Operation};

/// What a frame is charged for, with how often it happens.
pub fn charges(c: &Counters) -> [(Operation, u64); 7] {
    [
        (Operation::Frame, 1),
        (Operation::Polygon, c.triangles),
        (Operation::PolygonSetUp, c.drawn),
        (Operation::Entry, c.entries),
        (Operation::Block, c.box_blocks),
        (Operation::ShadedPixel, c.pixels_shaded),
        (Operation::PicturePixel, c.pixels),
    ]
}

/// A predicted frame in seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct FrameTime {
    /// Triangles met, and set up.
    pub front_end: f64,
    /// Entries, coverage and depth.
    pub raster: f64,
    /// Shading.
    pub shading: f64,
    /// What every frame costs, and clearing and writing the picture.
    pub picture: f64,
}

impl FrameTime {
    /// On one thread.
    pub fn on_one_thread(machine: &Machine, c: &Counters) -> Self {
        let mut time = Self::default();
        for (operation, count) in charges(c) {
            let seconds = machine.seconds_or_0(operation) * count as f64;
            *match operation {
                Operation::Polygon | Operation::PolygonSetUp => &mut time.front_end,
                Operation::ShadedPixel => &mut time.shading,
                Operation::Frame | Operation::PicturePixel => &mut time.picture,
                _ => &mut time.raster,
            } += seconds;
        }
        time
    }

    /// On several threads: the serial share of the description stays, the rest is divided; the back end cannot be
    /// faster than its fullest tile, of which every other thread waits for the half on average.
    pub fn on_threads(machine: &Machine, c: &Counters, threads: usize) -> Self {
        let one = Self::on_one_thread(machine, c);
        let serial = machine.processors.serial.as_ref().map_or(0.0, |s| s.value);
        let scale = serial + (1.0 - serial) / threads.max(1) as f64;
        let share = if c.entries == 0 { 0.0 } else { c.largest_tile as f64 / c.entries as f64 };
        let waiting = one.raster * share * (1.0 - 1.0 / threads.max(1) as f64) / 2.0;
        Self {
            front_end: one.front_end * scale,
            raster: one.raster * scale + waiting,
            shading: one.shading * scale,
            picture: one.picture * scale,
        }
    }

    /// The whole frame.
    pub fn total(&self) -> f64 {
        self.front_end + self.raster + self.shading + self.picture
    }
}
