//! Sections that only some machines have: the parts of Hybris, buses, and how a machine was measured.

use serde::{Deserialize, Serialize};

use super::sourced::Sourced;
use crate::units::{Bytes, BytesPerSecond, Count, Cycles, Ratio, Seconds};

/// The bucket sorted triangle heap of document 001, 3.5.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Heap {
    /// Bytes of a triangle node.
    pub node: Sourced<Bytes>,
    /// Bytes of a buffer, header and nodes.
    pub buffer: Sourced<Bytes>,
    /// Bytes of a buffer's header.
    pub header: Sourced<Bytes>,
    /// Heaps that are filled independently, one per front end.
    pub heaps: Sourced<Count>,
}

/// The memory below the heap.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Sdram {
    /// Bytes of a page (row).
    pub page: Sourced<Bytes>,
    /// Banks, each with one open page.
    pub banks: Sourced<Count>,
    /// Cycles to close a page and open another.
    pub page_miss: Sourced<Cycles>,
    /// Bytes moved in a cycle.
    pub width: Sourced<Bytes>,
}

/// The tile engines of document 001, 3.6.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct TileEngine {
    /// Pixels along the edge of a tile.
    pub tile: Sourced<Count>,
    /// Engines that work at the same time.
    pub engines: Sourced<Count>,
    /// Spans (and pixels of a span) drawn at the same time: 1, or 2 for the 2x2 interleaved engine.
    pub interleave: Sourced<Count>,
    /// Entries of the FIFOs between stages, before a broadcast.
    pub fifo: Sourced<Count>,
    /// Entries of the FIFOs after a broadcast.
    pub fifo_after_broadcast: Sourced<Count>,
    /// Cycles of the set-up of a triangle in a tile.
    pub set_up_triangle: Sourced<Cycles>,
    /// Pixels read from a finished tile, and cleared, in a cycle.
    pub output: Sourced<Count>,
}

/// The transfer of triangle nodes from the host to the tile engines.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Transfer {
    /// Fixed cost of every transfer.
    pub overhead: Sourced<Seconds>,
    /// Bandwidth after that.
    pub bandwidth: Sourced<BytesPerSecond>,
    /// Bytes moved by one transfer.
    pub block: Sourced<Bytes>,
}

/// How far numbers of a machine that nobody measured on it may be off. What is left out is taken as it is.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Assumptions {
    /// The built-in machine whose costs these are: its calibration's residuals count for this machine, too.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub costs_of: Option<String>,
    /// Root mean square of the residuals of these costs, predicted over measured time minus 1, if that machine has no calibration.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub residual: Option<Sourced<Ratio>>,
    /// All costs may be that much higher, or lower by the same factor: 25 % is 1.25 times as long, or 1 / 1.25 times.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub costs: Option<Sourced<Ratio>>,
    /// The same for the bandwidth of memory.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub memory_bandwidth: Option<Sourced<Ratio>>,
    /// The same for the bandwidth of network, node and mpi.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub network_bandwidth: Option<Sourced<Ratio>>,
    /// The same for the times of messages and hops of network, node and mpi.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub message: Option<Sourced<Ratio>>,
    /// The same for the time in which other processors wake up, `processors.wake-up`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wake_up: Option<Sourced<Ratio>>,
    /// The largest share of a frame's work that may run on one processor only; the least is that of `processors`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub serial: Option<Sourced<Ratio>>,
}

/// How `tercio lab calibrate` measured a machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Calibration {
    /// The day, year first.
    pub date: String,
    /// The processor, as the operating system names it.
    pub processor: String,
    /// The version of tercio.
    pub version: String,
    /// Frames that the costs were fitted to, each the fastest of several.
    pub frames: Sourced<Count>,
    /// Root of the mean square of the residuals: fitted over measured time of a frame, minus 1.
    pub residual: Sourced<Ratio>,
    /// The largest of them, without its sign.
    pub worst_residual: Sourced<Ratio>,
    /// Median over the frames of the spread of their rounds: slowest over fastest, minus 1.
    pub spread: Sourced<Ratio>,
    /// What makes the measurement doubtful, if it was still so when it had been repeated: another program or guest may have used the
    /// machine.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub doubt: Option<String>,
}
