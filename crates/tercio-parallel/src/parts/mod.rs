//! Models of which each rank has a part.
//!
//! | module | what |
//! |---|---|
//! | [`seam`] | the triangles of other ranks around a part, so that normals come out as those of the whole model |
//! | `ghosts` | these triangles as messages |

mod ghosts;
pub mod seam;

use crate::ParallelError;
use crate::comm::CommError;

/// The error for a message that is not valid.
fn malformed(from: usize, reason: impl Into<String>) -> ParallelError {
    CommError::Transport { rank: from, reason: reason.into() }.into()
}
