//! Hybris: the tile renderer of document 001, part by part.
//!
//! | module | part | place in document 001 |
//! |---|---|---|
//! | [`triangle`] | rounding rules, spans | 3.2.6, 3.2.7 |
//! | [`planes`] | planes of triangles in 32 bits, and culling by them | 3.2.4, 3.2.5 |
//! | [`partition`] | objects divided into partitions of 500 triangles | 3.3.3 |
//! | [`front_end`] | culling, bucket sorting | 3.2.4, 3.2.5, 3.4, 3.5 |
//! | [`heap`] | buffers of 63 nodes in SDRAM pages | 3.5, 4.4 |
//! | [`tile_engine`] | four stages with FIFOs, cycle by cycle; interleaved rows and pixels | 3.6.1, 3.6.2, 3.6.5 |
//! | [`samples`] | ordered and sparse samples of a pixel | 3.6.6 |
//! | [`back_end`] | tiles on several engines, image composition | 3.6.3, 3.6.4 |
//! | [`transfer`] | the bus to the board | 4.5.1 |
//! | [`software`] | one and two processors with their barrier | 4.3.1, 4.3.2 |
//! | [`scene`] | a model under a camera | |
//! | [`frame`] | a whole frame on one of the machines | 4.3 to 4.6 |
//!
//! All of it is a pure function of a [`Scene`] and of a machine's description. Screen coordinates are whole sub-pixels,
//! 256 to a pixel, y downwards; nothing is rounded twice.

pub mod back_end;
pub mod frame;
pub mod front_end;
pub mod heap;
pub mod partition;
pub mod planes;
pub mod samples;
pub mod scene;
pub mod software;
pub mod tile_engine;
pub mod transfer;
pub mod triangle;

pub use back_end::Sharing;
pub use frame::{HybrisFrame, simulate};
pub use front_end::{FrontEnd, FrontEndCounts};
pub use triangle::Triangle;

/// The input of Hybris: an object in partitions, already projected.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// The partitions in the order in which they are drawn.
    pub partitions: Vec<Partition>,
}

/// A group of triangles of an object that share vertices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Partition {
    /// Number of vertices, each shared one counted once.
    pub vertices: u32,
    /// Triangles that cannot be drawn because they reach behind the eye.
    pub outside: u32,
    /// The triangles on the screen, both facings.
    pub triangles: Vec<Triangle>,
}

impl Scene {
    /// Triangles of all partitions.
    pub fn triangles(&self) -> u64 {
        self.partitions.iter().map(|p| p.triangles.len() as u64 + u64::from(p.outside)).sum()
    }
}
