//! Seconds of the work of ranks, by what is known of a frame before it is drawn.

use tercio_raster::Settings;
use tercio_raster::frame::FragmentLayout;

use crate::machines::{Machine, Operation};

/// Fitted to the frames of docs/performance/parallel.md, drawn by one thread: a triangle that is not hidden, a drawn pixel with
/// one sample, and a fragment (with several samples, overdraw included).
const TRIANGLE: f64 = 3.5e-9;
const PIXEL: f64 = 9e-9;
const FRAGMENT: f64 = 45e-9;
/// Fitted to the frames of sort-last there: keeping a fragment, and merging it into the owner's tile.
const KEPT_FRAGMENT: f64 = 40e-9;
const MERGED_FRAGMENT: f64 = 50e-9;
/// Merging a fragment, as bytes, with those that are handed on with it: 9 ns where one rank alone has a pixel, 30 ns where two have.
const JOINED_FRAGMENT: f64 = 20e-9;
/// The share of the fragments of opaque surfaces in tiles that several ranks have that is kept and sent: the others are in blocks that
/// one of them finishes. Bytes of two and of eight ranks that draw teapot, gyroid and terrain of a million triangles, with finished
/// blocks and without, have ratios of 0.2 to 0.4.
const UNFINISHED: f64 = 0.3;
/// Copying a byte into a message, or out of it.
const COPIED_BYTE: f64 = 0.25e-9;
/// Seconds of looking at a cluster for the estimate of the work in each tile, at a tile that it may reach, and of giving a tile to a
/// rank.
pub const SURVEYED: f64 = 60e-9;
const VISITED: f64 = 15e-9;
/// Seconds of giving a tile to a rank.
pub const DIVIDED: f64 = 60e-9;
/// Pixels of a span, about: closed surfaces are seen in long runs, cut by the edges of tiles.
const SPAN: f64 = 24.0;

/// Bytes of a binned cluster.
pub const BIN_CLUSTER: f64 = 16.0;
/// Bytes of a binned triangle, with its entry.
pub const BIN_TRIANGLE: f64 = 44.0;
/// Bytes before the bins of a tile.
pub const BIN_TILE: f64 = 12.0;
/// Bytes before those of all tiles.
pub const BIN_HEAD: f64 = 36.0;
/// Bytes before the content of a composited tile.
pub const TILE_HEAD: f64 = tercio_parallel::composite::exchange::TILE_HEAD as f64;
const SPAN_HEAD: f64 = tercio_parallel::composite::packet::SPAN_HEAD as f64;
const KEY: f64 = 8.0;

/// Costs in seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rates {
    /// Testing a cluster.
    pub cluster: f64,
    /// Sorting a cluster into a tile.
    pub entry: f64,
    /// Sorting a triangle into a tile.
    pub triangle_entry: f64,
    /// Looking at a cluster, visiting a tile, and giving one to a rank, for the estimate that a division needs.
    pub survey: [f64; 3],
    /// Drawing a triangle.
    pub triangle: f64,
    /// Drawing a pixel, or a fragment of several samples.
    pub shown: f64,
    /// Keeping what is drawn for compositing: of a pixel its key, or a fragment; including packing.
    pub kept: f64,
    /// Merging a pixel that another rank sent with one that a rank has, or any fragment with others.
    pub merged: f64,
    /// Merging a fragment with others that are handed on.
    pub joined: f64,
    /// Packing and unpacking a finished pixel.
    pub collected: [f64; 2],
    /// Clearing a pixel.
    pub cleared: f64,
    /// Copying a byte.
    pub byte: f64,
    /// Bytes of a finished pixel, and of a pixel or fragment that is composited.
    pub finished_bytes: f64,
    /// See above; of a fragment times the share that is not finished before.
    pub composited_bytes: f64,
    /// Samples per pixel.
    pub samples: f64,
    /// Whether fragments are composited.
    pub fragments: bool,
    /// Whether something may not be opaque: then nothing hides anything.
    pub translucent: bool,
    /// Whether ranks tell each other, before they draw the tiles that several of them have, how near they may draw, and then which blocks
    /// are finished.
    pub finishes_blocks: bool,
}

impl Rates {
    /// The costs of a picture with these settings on a machine; `translucent` if something may not be opaque.
    pub fn of(machine: &Machine, settings: &Settings, translucent: bool) -> Self {
        let cost = |operation| machine.seconds_or_0(operation);
        let count = settings.sampling.pattern.count();
        let fragments = count > 1 || translucent;
        // As `FrameContext::has_blocks`.
        let finishes_blocks = fragments && !translucent && settings.sampling.halo() == 0;
        let unfinished = if finishes_blocks { UNFINISHED } else { 1.0 };
        let colors = settings.outputs.pixel_bytes() as f64;
        let of_spans = cost(Operation::UnpackedSpan) / SPAN;
        let finished_bytes = colors + SPAN_HEAD / SPAN;
        // As for counted ranks: of a description without this cost a sample unpacked. A pixel that is received is merged with one that a
        // rank has.
        let merged = 2.0 * machine.seconds(Operation::MergedPixel).unwrap_or(cost(Operation::UnpackedSample));
        Self {
            cluster: cost(Operation::Cluster),
            entry: cost(Operation::ClusterEntry),
            triangle_entry: cost(Operation::Entry),
            survey: [SURVEYED, VISITED, DIVIDED],
            triangle: TRIANGLE,
            shown: if fragments { FRAGMENT } else { PIXEL },
            kept: if fragments {
                unfinished * KEPT_FRAGMENT
            } else {
                cost(Operation::ShadedKey)
                    + cost(Operation::KeyLine) / 8.0
                    + 3.0 * cost(Operation::PackedSample)
            },
            merged: if fragments {
                unfinished * MERGED_FRAGMENT
            } else {
                of_spans + merged + cost(Operation::ExchangeLine) * 0.2
            },
            joined: unfinished * JOINED_FRAGMENT,
            collected: [
                cost(Operation::PackedSample) + cost(Operation::ScannedPixel),
                of_spans + cost(Operation::UnpackedSample) + cost(Operation::ExchangeLine) / 8.0,
            ],
            cleared: cost(Operation::ClearedPixel),
            byte: COPIED_BYTE,
            finished_bytes,
            composited_bytes: if fragments {
                unfinished * FragmentLayout::new(&settings.outputs, false).bytes(count) as f64
            } else {
                KEY + finished_bytes
            },
            samples: count as f64,
            fragments,
            translucent,
            finishes_blocks,
        }
    }

    /// The same on a machine that is so much slower than the one that the fitted constants are of; the costs of its description
    /// stay.
    pub fn slower(self, by: f64) -> Self {
        let of_fragments = if self.fragments { by } else { 1.0 };
        Self {
            survey: self.survey.map(|seconds| seconds * by),
            triangle: self.triangle * by,
            shown: self.shown * by,
            kept: self.kept * of_fragments,
            merged: self.merged * of_fragments,
            joined: self.joined * by,
            byte: self.byte * by,
            ..self
        }
    }

    /// The same where drawing triangles, pixels and fragments takes so many times as long.
    pub fn drawing(self, times: f64) -> Self {
        Self { triangle: self.triangle * times, shown: self.shown * times, ..self }
    }
}
