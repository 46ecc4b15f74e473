//! Models in parts: every rank holds a share of a model's triangles, and all of them draw the picture of the whole model.
//!
//! | module | what |
//! |---|---|
//! | [`common`] | what ranks find out about their parts before they have clusters |
//! | [`seam`] | the triangles of other ranks around a part, so that normals come out as those of the whole model |
//! | `ghosts` | these triangles as messages |
//! | [`numbering`] | what the parts of a model have to know of the whole |
//! | [`check`] | do the parts of a scene make whole models? |
//! | [`camera`] | the camera that frames all parts |
//! | [`shadows`] | the shadow maps of all parts |
//!
//! A scene in parts has the same instances, lights, materials and textures on every rank; only the meshes hold other triangles
//! ([`tercio_scene::Share`]). Sort-last draws each part where it is. In the other organisations the clusters that reach the tiles
//! of another rank of the group are sent to it ([`crate::organisation`]).

pub mod camera;
pub mod check;
pub mod common;
mod ghosts;
pub mod numbering;
pub mod seam;
pub mod shadows;

pub use camera::camera_for_scene;
pub use common::{agree, bounds_of_all};
pub use numbering::{number, share_materials};
pub use shadows::shadow_maps;

use crate::ParallelError;
use crate::comm::CommError;

/// The error for a message that is not valid.
fn malformed(from: usize, reason: impl Into<String>) -> ParallelError {
    CommError::Transport { rank: from, reason: reason.into() }.into()
}

/// Why parts do not make a model.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PartsError {
    /// A rank's part does not belong to that of rank 0.
    #[error("rank {rank} has a part of a model with {what} than that of rank 0")]
    Differs {
        /// The first rank that differs.
        rank: usize,
        /// What differs.
        what: &'static str,
    },
    /// A rank could not make its part; it has the reason.
    #[error("rank {rank} could not make its part of a model")]
    Failed {
        /// The first rank that failed.
        rank: usize,
    },
    /// The model has more triangles or faces than can be numbered.
    #[error(
        "the parts have {triangles} triangles and {faces} faces together: at most {} of each can be numbered",
        tercio_raster::conventions::MAX_NUMBERS
    )]
    TooLarge {
        /// Triangles of all parts.
        triangles: u64,
        /// Faces of all parts.
        faces: u64,
    },
    /// An instance is whole in a scene with instances in parts.
    #[error("instance {instance} is whole, but others of the scene are in parts")]
    Whole {
        /// Its number.
        instance: usize,
    },
    /// A rank's share does not follow that of the rank before, or the shares are not all triangles of the model.
    #[error(
        "instance {instance}: {triangles} triangles from number {first} on are not what rank {rank} has of a model of {of}"
    )]
    Share {
        /// Number of the instance.
        instance: usize,
        /// The rank.
        rank: usize,
        /// Number of the share's first triangle.
        first: u64,
        /// Triangles of the part.
        triangles: u64,
        /// Triangles of the model.
        of: u64,
    },
    /// An instance has edges along some of the sides of its triangles.
    #[error(
        "instance {instance} is a part of a model: edges along chosen sides of its triangles cannot be drawn"
    )]
    Edges {
        /// Number of the instance.
        instance: usize,
    },
    /// Ranks do not agree on whether an instance may be less than opaque.
    #[error("instance {instance}: its materials were not made for a part of a model on rank {rank}")]
    Translucency {
        /// Number of the instance.
        instance: usize,
        /// The rank.
        rank: usize,
    },
}
