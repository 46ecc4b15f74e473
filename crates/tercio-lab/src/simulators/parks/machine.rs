//! Which processor has which pixels (document 002, chapter 3).

use crate::workloads::PixelBox;

/// A machine: the screen is divided into `chunks` x `chunks` parts, and the pixels of each are interlaced over
/// `interlace` x `interlace` processors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Machine {
    /// Chunks along a side of the screen.
    pub chunks: u32,
    /// Processors along a side of the interlace pattern.
    pub interlace: u32,
}

/// One processor's share of the screen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// Its chunk, y upwards.
    pub chunk: PixelBox,
    /// Column and row of its first pixel inside the chunk, below `interlace`.
    pub phase: [u32; 2],
}

/// Why a machine does not fit a screen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MachineError {
    /// The screen cannot be divided into equal parts.
    #[error("expected a screen of {parts} equal parts a side, found {width}x{height} pixels")]
    Parts {
        /// Chunks times interlace.
        parts: u64,
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
    },
    /// No processors, or more than a listing makes sense for.
    #[error(
        "expected 1 to {MAX_SIDE} chunks and an interlace of 1 to {MAX_SIDE} a side, found {chunks} and {interlace}"
    )]
    Size {
        /// Chunks a side.
        chunks: u32,
        /// Interlace a side.
        interlace: u32,
    },
}

/// Maximum number of chunks or interlaced processors along a side.
const MAX_SIDE: u32 = 64;

impl Machine {
    /// One processor.
    pub const UNIPROCESSOR: Self = Self { chunks: 1, interlace: 1 };

    /// The document's machines: uniprocessor, splitter and interlace of 4 and 16, hybrid of 16. Together they have 57
    /// processors.
    pub const PUBLISHED: [(&'static str, Self); 6] = [
        ("uniprocessor", Self::UNIPROCESSOR),
        ("interlace-4", Self { chunks: 1, interlace: 2 }),
        ("splitter-4", Self { chunks: 2, interlace: 1 }),
        ("interlace-16", Self { chunks: 1, interlace: 4 }),
        ("splitter-16", Self { chunks: 4, interlace: 1 }),
        ("hybrid-16", Self { chunks: 2, interlace: 2 }),
    ];

    /// Number of processors.
    pub fn processors(&self) -> u32 {
        (self.chunks * self.interlace).pow(2)
    }

    /// The chunks of a screen, left to right, bottom row first.
    ///
    /// # Errors
    /// [`MachineError`] if the screen is not a whole number of chunks and patterns.
    pub fn chunks(&self, width: u32, height: u32) -> Result<Vec<PixelBox>, MachineError> {
        let &Self { chunks, interlace } = self;
        if ![chunks, interlace].iter().all(|side| (1..=MAX_SIDE).contains(side)) {
            return Err(MachineError::Size { chunks, interlace });
        }
        let parts = chunks * interlace;
        if width == 0 || height == 0 || !width.is_multiple_of(parts) || !height.is_multiple_of(parts) {
            return Err(MachineError::Parts { parts: u64::from(parts), width, height });
        }
        let [across, up] = [width / chunks, height / chunks].map(|s| s as i32);
        let places = (0..chunks as i32).flat_map(|j| (0..chunks as i32).map(move |i| [i * across, j * up]));
        Ok(places.map(|[x, y]| PixelBox { x0: x, y0: y, x1: x + across - 1, y1: y + up - 1 }).collect())
    }

    /// The processors in the order of their numbers: chunk by chunk, in each left to right, bottom row first.
    ///
    /// # Errors
    /// As [`Machine::chunks`].
    pub fn places(&self, width: u32, height: u32) -> Result<Vec<Place>, MachineError> {
        let k = self.interlace;
        let phases = (0..k).flat_map(|j| (0..k).map(move |i| [i, j]));
        let chunks = self.chunks(width, height)?.into_iter();
        Ok(chunks.flat_map(|chunk| phases.clone().map(move |phase| Place { chunk, phase })).collect())
    }
}
