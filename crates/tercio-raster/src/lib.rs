//! The tile renderer.

pub mod frame;
pub mod settings;
pub mod stats;

pub use frame::Frame;
pub use settings::{Binning, Cull, Outputs, Settings, Shading, SimdLevel};
pub use stats::FrameStats;

use tercio_scene::camera::CameraError;
use tercio_scene::{Camera, Scene};

/// Why a picture could not be drawn.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
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
        "the scene holds {triangles} triangles in {clusters} clusters; at most 2^25 - 1 clusters can be numbered"
    )]
    TooLarge {
        /// Triangles of all instances.
        triangles: u64,
        /// Clusters of all instances.
        clusters: u64,
    },
}

/// Draws scenes; keeps its memory from frame to frame. Runs in the rayon pool it is called in.
#[derive(Debug, Default)]
pub struct Renderer {}

impl Renderer {
    /// A renderer that holds no memory yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Draws one picture.
    ///
    /// # Errors
    /// A camera or setting that makes no picture, or a scene too large to be numbered.
    pub fn render(
        &mut self,
        _scene: &Scene,
        _camera: &Camera,
        _settings: &Settings,
    ) -> Result<Frame, RenderError> {
        Ok(Frame::default())
    }
}
