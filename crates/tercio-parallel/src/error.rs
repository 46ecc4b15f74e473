//! Why ranks could not draw a picture.

use tercio_mesh::cluster::TransferError;
use tercio_raster::RenderError;
use tercio_raster::binning::SortedError;
use tercio_raster::frame::FragmentError;

use crate::agreement::Matter;
use crate::comm::CommError;
use crate::composite::packet::PacketError;
use crate::parts::PartsError;

/// Why ranks could not draw a picture.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ParallelError {
    /// A rank failed to draw.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// A rank is going to draw something else than rank 0.
    #[error("rank {rank} would draw {what} than rank 0: all ranks have to draw the same frame")]
    Differs {
        /// The first rank that differs.
        rank: usize,
        /// What differs.
        what: Matter,
    },
    /// The fragments of a rank are not valid.
    #[error(transparent)]
    Fragments(#[from] FragmentError),
    /// A message could not be sent or received.
    #[error(transparent)]
    Comm(#[from] CommError),
    /// A message does not hold valid pixels.
    #[error("a message from rank {from}: {source}")]
    Packet {
        /// The sender.
        from: usize,
        /// What is wrong.
        source: PacketError,
    },
    /// A message does not hold valid bins of the frame.
    #[error("a message from rank {from}: {source}")]
    Bins {
        /// The sender.
        from: usize,
        /// What is wrong.
        source: SortedError,
    },
    /// The meshes of the ranks are not parts of the same models.
    #[error(transparent)]
    Parts(#[from] PartsError),
    /// A message does not hold valid clusters, or they cannot be written.
    #[error("a message from rank {from}: {source}")]
    Clusters {
        /// The sender.
        from: usize,
        /// What is wrong.
        source: TransferError,
    },
    /// A rank's report of a frame cannot be written, or cannot be parsed by rank 0.
    #[error("the report of rank {rank}: {source}")]
    Report {
        /// The rank.
        rank: usize,
        /// What is wrong.
        source: serde_json::Error,
    },
    /// A rank panicked.
    #[error("rank {rank} panicked: {message}")]
    Panicked {
        /// The rank.
        rank: usize,
        /// The panic message.
        message: String,
    },
    /// The thread of a rank could not be created.
    #[error("rank {rank} has no thread: {source}")]
    Thread {
        /// The rank.
        rank: usize,
        /// The system's reason.
        source: std::io::Error,
    },
    /// The thread pool of a rank could not be created.
    #[error("a rank's {threads} threads: {source}")]
    Threads {
        /// The requested number of threads.
        threads: usize,
        /// The reason.
        source: rayon::ThreadPoolBuildError,
    },
}

impl ParallelError {
    /// True if it only reports that another rank failed, which has the actual reason.
    pub(crate) fn is_consequence(&self) -> bool {
        matches!(self, Self::Comm(CommError::Gone { .. }))
    }
}
