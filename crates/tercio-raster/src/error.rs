//! What can go wrong on the way to a picture.

use tercio_scene::camera::CameraError;

/// Why a picture could not be drawn.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// The camera is not one.
    #[error(transparent)]
    Camera(#[from] CameraError),
    /// A setting is out of its range.
    #[error("{what} must be {range}, is {value}")]
    Setting {
        /// Which setting.
        what: &'static str,
        /// What it may be.
        range: String,
        /// What it is.
        value: String,
    },
    /// More triangles than can be numbered.
    #[error(
        "the scene holds {triangles} triangles in {clusters} clusters; 32 bits do not suffice to number them"
    )]
    TooLarge {
        /// Triangles of all instances.
        triangles: u64,
        /// Clusters of all instances.
        clusters: u64,
    },
    /// A mesh whose coordinates leave `f32` no room to calculate with.
    #[error(
        "the coordinates of instance {instance} reach {largest:e}, and 32-bit floating-point numbers can calculate with \
         2^-60 to 2^60 only: choose another unit of the mesh (clean or Mesh::bring_into_range)"
    )]
    OutOfRange {
        /// Number of the instance.
        instance: usize,
        /// Largest absolute value of a coordinate, in units of the mesh.
        largest: f64,
    },
    /// Distances were asked for that `f32` does not hold.
    #[error(
        "distances up to {farthest:e} do not fit into 32-bit floating-point numbers: scale the model, or ask for no depth"
    )]
    Distances {
        /// The largest distance, world units.
        farthest: f64,
    },
}
