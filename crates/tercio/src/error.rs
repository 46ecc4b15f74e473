//! One error type for programs that need not distinguish the errors of the parts.

use std::io;

use tercio_mesh::ReadError;
use tercio_mesh::builtin::BuiltinError;
use tercio_parallel::ParallelError;
use tercio_parallel::comm::CommError;
use tercio_raster::RenderError;
use tercio_scene::camera::CameraError;

use crate::camera_path::CameraPathFileError;
use crate::data::DataError;
use crate::image::ImageError;
use crate::scene_file::SceneFileError;
use crate::{LoadError, PanoramaFileError, SessionError, TextureError};

/// Any error between a model file and its picture.
///
/// Functions return the error of their own part ([`LoadError`], [`RenderError`], [`ImageError`], [`ParallelError`]);
/// `?` converts each to this one. The text is that of the part, and so is [`source`](std::error::Error::source).
///
/// ```
/// fn triangles(model: &str) -> tercio::Result<u64> {
///     Ok(tercio::load(model)?.report.mesh.triangles)
/// }
///
/// let error = triangles("missing.ply").unwrap_err();
/// assert!(matches!(error, tercio::Error::Load(_)));
/// assert!(error.to_string().starts_with("missing.ply: "));
/// ```
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A model could not be loaded.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// A picture could not be drawn.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// A picture could not be drawn by several ranks.
    #[error(transparent)]
    Parallel(#[from] ParallelError),
    /// A session could not do something.
    #[error(transparent)]
    Session(#[from] SessionError),
    /// A picture could not be written, read or compared.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// A picture file makes no texture.
    #[error(transparent)]
    Texture(#[from] TextureError),
    /// A picture file makes no environment.
    #[error(transparent)]
    Panorama(#[from] PanoramaFileError),
    /// Data could not become colours.
    #[error(transparent)]
    Data(#[from] DataError),
    /// A file makes no camera path.
    #[error(transparent)]
    CameraPath(#[from] CameraPathFileError),
    /// A scene file or a configuration could not be read.
    #[error(transparent)]
    SceneFile(#[from] SceneFileError),
    /// A file could not be written or read.
    #[error(transparent)]
    Io(#[from] io::Error),
}

/// A result with [`Error`] as its default error.
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl From<ReadError> for Error {
    fn from(error: ReadError) -> Self {
        Self::Load(error.into())
    }
}

impl From<BuiltinError> for Error {
    fn from(error: BuiltinError) -> Self {
        Self::Load(error.into())
    }
}

impl From<CommError> for Error {
    fn from(error: CommError) -> Self {
        Self::Parallel(error.into())
    }
}

impl From<CameraError> for Error {
    fn from(error: CameraError) -> Self {
        Self::Render(error.into())
    }
}

#[cfg(test)]
mod tests {
    use std::error::Error as _;

    use tercio_scene::texture::Encoding;

    use super::*;

    #[test]
    fn text_and_source_are_those_of_the_part() {
        fn assert_can_be_sent<T: Send + Sync + 'static>(_: &T) {}

        let missing = crate::load("missing.ply").unwrap_err();
        let (text, reason) =
            (missing.to_string(), missing.source().expect("the system's reason").to_string());
        let error = Error::from(missing);
        assert_can_be_sent(&error);
        assert_eq!(error.to_string(), text);
        assert_eq!(error.source().map(ToString::to_string), Some(reason));
        assert!(error.source().is_some_and(|source| source.is::<io::Error>()));
    }

    #[test]
    fn every_part_becomes_the_one_error() {
        let frame = |width, height| tercio_raster::Settings::new(width, height).check();
        let render = || frame(0, 1).unwrap_err();
        let unknown = || ImageError::UnknownExtension;
        assert!(matches!(Error::from(render()), Error::Render(RenderError::Setting { .. })));
        assert!(matches!(Error::from(ParallelError::from(render())), Error::Parallel(_)));
        assert!(matches!(Error::from(unknown()), Error::Image(ImageError::UnknownExtension)));
        assert!(matches!(Error::from(io::Error::other("full")), Error::Io(_)));
        let name = tercio_mesh::builtin::make("builtin:cow").unwrap_err();
        assert!(matches!(Error::from(name), Error::Load(LoadError::Builtin(_))));
        let camera = tercio_scene::Camera {
            target: glam::DVec3::NAN,
            ..tercio_raster::Settings::new(1, 1).framing().camera_for_scene(&Default::default())
        };
        let camera = camera.basis().unwrap_err();
        assert!(matches!(Error::from(camera), Error::Render(RenderError::Camera(_))));
        let texture = || crate::texture_from_bytes(b"no picture", Encoding::Srgb, None).unwrap_err();
        assert!(matches!(Error::from(texture()), Error::Texture(TextureError::Format { .. })));
        let panorama = PanoramaFileError::from(texture());
        assert!(matches!(Error::from(panorama), Error::Panorama(PanoramaFileError::Picture(_))));
        let path = crate::camera_path::read(b"{").unwrap_err();
        assert!(matches!(Error::from(path), Error::CameraPath(_)));
    }
}
