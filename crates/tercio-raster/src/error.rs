//! The errors of the renderer.

use tercio_scene::camera::CameraError;

/// Why a picture could not be drawn.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// The camera is invalid.
    #[error(transparent)]
    Camera(#[from] CameraError),
    /// A setting is out of range.
    #[error("{what} must be {range}, is {value}")]
    Setting {
        /// Which setting.
        what: &'static str,
        /// Its valid values.
        range: String,
        /// Its value.
        value: String,
    },
    /// More clusters than can be numbered.
    #[error(
        "the scene has {clusters} clusters, at most {} can be numbered: let more ranks have parts of it",
        crate::conventions::MAX_CLUSTERS
    )]
    TooLarge {
        /// Clusters of all instances.
        clusters: u64,
    },
    /// More triangles or input faces than can be numbered.
    #[error("the scene has {count} {what}, at most {} can be numbered", crate::conventions::MAX_NUMBERS)]
    TooMany {
        /// Triangles or faces.
        what: &'static str,
        /// Their number, of all instances.
        count: u64,
    },
    /// The plane of ids was requested, and a number of a face does not fit into it.
    #[error(
        "the scene has {faces} faces, and ids are numbers of faces in 32 bits, at most {}: do not request the ids \
         (--output-ids)",
        crate::frame::NO_PRIMITIVE
    )]
    Ids {
        /// Faces of all instances.
        faces: u64,
    },
    /// A mesh whose coordinates are too large or too small to calculate with in `f32`.
    #[error(
        "the coordinates of instance {instance} reach {largest:e}, and 32-bit floating-point numbers can calculate \
         with 2^-60 to 2^60 only: choose another unit of the mesh (clean or Mesh::bring_into_range)"
    )]
    OutOfRange {
        /// Number of the instance.
        instance: usize,
        /// Largest absolute value of a coordinate, in units of the mesh.
        largest: f64,
    },
    /// The depth plane was requested, and its distances are outside the range of `f32`.
    #[error(
        "distances up to {farthest:e} do not fit into 32-bit floating-point numbers: \
         scale the model, or do not request the depth"
    )]
    Distances {
        /// The largest distance, world units.
        farthest: f64,
    },
}
