//! Hybris in software: every processor runs the whole pipeline, with a barrier in the middle.
//!
//! The first processor takes the first half of the partitions, the second the other; after the barrier the tiles are
//! divided like a checkerboard (document 001, 4.3.2). The part that runs on one processor only, the output of the
//! picture and the user's input, is the cost of an empty frame (4.6).

use serde::Serialize;

use super::front_end::{FrontEndCounts, Tiles};
use super::{FrontEnd, back_end};
use crate::machines::{Machine, Operation};

/// A frame in software, in seconds.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SoftwareFrame {
    /// Front end of each processor.
    pub front: Vec<f64>,
    /// Back end of each processor.
    pub back: Vec<f64>,
    /// The serial part.
    pub serial: f64,
}

impl SoftwareFrame {
    /// The whole frame: slowest front end, barrier, slowest back end.
    pub fn seconds(&self) -> f64 {
        let most = |times: &[f64]| times.iter().copied().fold(0.0, f64::max);
        self.serial + most(&self.front) + most(&self.back)
    }

    /// Seconds that processors wait at the barrier and at the end, summed.
    pub fn waiting(&self) -> f64 {
        let waits = |times: &[f64]| {
            let most = times.iter().copied().fold(0.0, f64::max);
            times.iter().map(|t| most - t).sum::<f64>()
        };
        waits(&self.front) + waits(&self.back)
    }
}

/// Counts of the back end of one processor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct BackCounts {
    /// Tiles with at least one triangle.
    pub tiles: u64,
    /// Nodes read.
    pub entries: u64,
    /// Rows.
    pub rows: u64,
    /// Pixels drawn, hidden or not.
    pub pixels: u64,
}

/// Counts of the back ends, with tiles assigned like a checkerboard.
pub fn back_counts(front_ends: &[FrontEnd], tiles: Tiles, processors: usize) -> Vec<BackCounts> {
    let mut counts = vec![BackCounts::default(); processors];
    for tile in 0..tiles.count() {
        let work = back_end::tile_work(front_ends, tiles, tile);
        let (column, row) = tiles.place(tile);
        let own = &mut counts[(column + row) as usize % processors];
        own.tiles += u64::from(!work.is_empty());
        own.entries += work.len() as u64;
        own.rows += work.iter().map(super::tile_engine::TileWork::rows).sum::<u64>();
        own.pixels += work.iter().map(super::tile_engine::TileWork::pixels).sum::<u64>();
    }
    counts
}

/// Seconds of a frame by the costs of a description.
pub fn frame(machine: &Machine, front: &[FrontEndCounts], back: &[BackCounts]) -> SoftwareFrame {
    let cost = |o| machine.seconds_or_0(o);
    let of_front = |c: &FrontEndCounts| {
        c.partitions as f64 * cost(Operation::Cluster)
            + c.triangles as f64 * cost(Operation::Polygon)
            + c.vertices as f64 * cost(Operation::Vertex)
            + c.nodes as f64 * cost(Operation::PolygonSetUp)
    };
    let of_back = |c: &BackCounts| {
        c.tiles as f64 * cost(Operation::Tile)
            + c.entries as f64 * cost(Operation::Entry)
            + c.rows as f64 * cost(Operation::Segment)
            + c.pixels as f64 * cost(Operation::Pixel)
    };
    SoftwareFrame {
        front: front.iter().map(of_front).collect(),
        back: back.iter().map(of_back).collect(),
        serial: cost(Operation::Frame),
    }
}
