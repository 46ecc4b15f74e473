//! The field's terms: where a machine sorts, how it divides the screen, how its processors are connected.

use serde::{Deserialize, Serialize};

/// Where work is redistributed between processors.
///
/// Source: document 001, 2.3, after Molnar and others; sort-twice: document 000, chapter 6.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SortingClass {
    /// Nowhere: one processor does everything, or processors draw whole frames in turn.
    None,
    /// Before the geometry work.
    SortFirst,
    /// Between geometry work and rasterization.
    SortMiddle,
    /// After rasterization: pixels.
    SortLast,
    /// Triangles inside groups, pixels between them.
    SortTwice,
    /// At several points, each sort completing the others.
    Hybrid,
}

impl SortingClass {
    /// The name in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::SortFirst => "sort-first",
            Self::SortMiddle => "sort-middle",
            Self::SortLast => "sort-last",
            Self::SortTwice => "sort-twice",
            Self::Hybrid => "hybrid",
        }
    }
}

/// How the screen is divided among the processors that rasterize.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ScreenDivision {
    /// Every rasterizer has the whole screen.
    Whole,
    /// Whole frames in turn.
    AlternateFrames,
    /// One contiguous part a rasterizer, such as an upper and a lower half.
    Contiguous,
    /// Rectangular chunks, one a rasterizer.
    Chunks,
    /// Small square tiles, many a rasterizer.
    Tiles,
    /// Columns of pixels.
    Columns,
    /// Scan lines in turn.
    InterleavedLines,
    /// Strips of several scan lines in turn.
    InterleavedStrips,
    /// Pixels in turn, in both directions.
    InterleavedPixels,
}

impl ScreenDivision {
    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Whole => "whole",
            Self::AlternateFrames => "alternate-frames",
            Self::Contiguous => "contiguous",
            Self::Chunks => "chunks",
            Self::Tiles => "tiles",
            Self::Columns => "columns",
            Self::InterleavedLines => "interleaved-lines",
            Self::InterleavedStrips => "interleaved-strips",
            Self::InterleavedPixels => "interleaved-pixels",
        }
    }
}

/// How processors are connected.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Topology {
    /// Neighbour to neighbour in a ring, in both directions.
    Ring,
    /// Neighbour to neighbour on a square grid without wrap-around.
    Mesh,
    /// Neighbour to neighbour on a grid of three dimensions, each a ring: as near to a cube as the number of ends can be divided.
    Torus,
    /// A binary tree whose links double towards the root: full bisection bandwidth.
    FatTree,
    /// All to all; each port carries one link's bandwidth.
    Crossbar,
    /// One shared medium.
    Bus,
    /// Shared memory.
    Memory,
}

impl Topology {
    /// The name in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ring => "ring",
            Self::Mesh => "mesh",
            Self::Torus => "torus",
            Self::FatTree => "fat-tree",
            Self::Crossbar => "crossbar",
            Self::Bus => "bus",
            Self::Memory => "memory",
        }
    }
}

/// How the units of a stage are arranged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Arrangement {
    /// Side by side.
    #[default]
    Parallel,
    /// Each hands on to the next. A single unit before them feeds the first, a single one after them takes from the last.
    Pipeline,
    /// A binary tree. What comes in enters at the root, what goes out leaves at the leaves.
    Tree,
}

/// Who decides what the processors do next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Control {
    /// Every processor runs a program of its own.
    #[default]
    Mimd,
    /// All processors execute the same instruction: a pass of a ring moves all slots at once.
    Simd,
}

/// How polygons are packed into messages.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Packing {
    /// One message for every destination, with all of its polygons.
    #[default]
    OneADestination,
    /// One message for every polygon and destination.
    OneAPolygon,
}

/// Where the finished picture goes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Delivery {
    /// Processor 0 receives it from all others.
    #[default]
    FirstProcessor,
    /// Every processor writes its part to the display, at no cost to the network.
    Display,
}
