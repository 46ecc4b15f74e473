//! Why ranks could not draw a picture.

use tercio_raster::RenderError;

use crate::comm::CommError;
use crate::composite::packet::PacketError;

/// Why ranks could not draw a picture.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ParallelError {
    /// A rank cannot draw.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// A message did not arrive.
    #[error(transparent)]
    Comm(#[from] CommError),
    /// A message does not hold pixels.
    #[error("pixels from rank {from}: {source}")]
    Packet {
        /// Who sent them.
        from: usize,
        /// What is wrong.
        source: PacketError,
    },
    /// What a rank did for a frame cannot be written, or was not understood by rank 0.
    #[error("the report of rank {rank}: {source}")]
    Report {
        /// Whose it is.
        rank: usize,
        /// What is wrong.
        source: serde_json::Error,
    },
    /// A rank panicked.
    #[error("rank {rank} panicked: {message}")]
    Panicked {
        /// Which.
        rank: usize,
        /// What it said.
        message: String,
    },
    /// The system gave no thread for a rank.
    #[error("rank {rank} has no thread: {source}")]
    Thread {
        /// Which.
        rank: usize,
        /// Why not.
        source: std::io::Error,
    },
    /// A rank's threads could not be had.
    #[error("a rank's {threads} threads: {source}")]
    Threads {
        /// How many were asked for.
        threads: usize,
        /// Why not.
        source: rayon::ThreadPoolBuildError,
    },
}

impl ParallelError {
    /// True if it only tells that another rank failed, which then has the reason.
    pub(crate) fn is_consequence(&self) -> bool {
        matches!(self, Self::Comm(CommError::Gone { .. }))
    }
}
