//! Draws very large polygon models without a GPU: on one core or on all of them, from one static binary or from this
//! library, with the same bytes everywhere.
//!
//! # A picture in eight lines
//!
//! ```
//! fn main() -> tercio::Result<()> {
//! #   let folder = tempfile::tempdir()?;
//! #   std::env::set_current_dir(&folder)?;
//!     let scene = tercio::Scene::from_mesh(tercio::load("builtin:teapot@10k")?.mesh);
//!     let settings = tercio::Settings::new(320, 240);
//!     let camera = settings.framing().camera_for_scene(&scene);
//!     let frame = tercio::Renderer::new().render(&scene, &camera, &settings)?;
//!     tercio::Picture::from_frame(&frame).save("teapot.png")?;
//! #   assert!(frame.stats.backend.pixels_visible > 5_000);
//! #   assert_eq!(tercio::Picture::from_file("teapot.png")?, tercio::Picture::from_frame(&frame));
//!     Ok(())
//! }
//! ```
//!
//! The size is given once, in the [`Settings`]; the camera frames the model for it. Paths are of any type that
//! implements `AsRef<Path>`, and `?` converts all errors to [`Error`].
//!
//! # Overview of the library
//!
//! - [`load`] reads a model (PLY, OBJ, STL, OFF, VTK, PCD, LAS, LAZ, point clouds as text, each also gzip-compressed, or a built-in one), repairs it, makes
//!   missing normals and splits it into clusters, which is what a renderer draws. A model that was prepared by
//!   [`Loaded::write_prepared`] is mapped instead. [`LoadOptions`] has the limits, the progress and the choice of
//!   normals, and loads from memory or only up to the [`Mesh`] itself.
//! - [`TextureOptions::load`] gives a scene the materials that a model names, with their textures.
//! - [`scene`] places meshes in the world, lights them and frames them with a camera.
//! - [`raster`] draws. A [`Renderer`] keeps its memory from frame to frame.
//! - [`parallel`] draws with several ranks, which share a frame and send each other messages; [`LoadOptions::load_part`] loads
//!   for each of them a part of a model.
//! - [`Session`] draws what a program computes, alone or with other processes that have parts of it.
//! - [`write_png_in_bands`] draws pictures that are larger than memory.
//! - [`camera_path`] reads the keyframes of a moving camera, [`CameraPath`] interpolates them.
//! - [`scene_file`] reads and writes files of settings for several models, and configuration files.
//! - [`stereo`] makes one picture of those of two eyes, whose cameras [`Stereo`] places.
//! - [`strokes`] makes lines, edges and points a part of a scene; [`vector`] makes them drawings (SVG, PDF), cut where the surface
//!   hides them.
//! - [`image`] writes pictures (PNG, PPM, WebP, JPEG), films ([`image::film`]: GIF, APNG, WebP, Y4M) and arrays (NPY), reads and compares
//!   pictures.
//!
//! The types that most programs use are also exported here at the root.
//!
//! Everything runs in the rayon pool of its caller: wrap the calls in `ThreadPool::install` to choose the number of
//! threads. The picture does not depend on it.
//!
//! # What may be extended
//!
//! Error enums, and reports that only the library makes, are `#[non_exhaustive]`: match with a last arm `_`, and do
//! not destructure them completely. Options and settings are built by their callers: take the fields that are not
//! given from the constructor or default (`..Settings::new(320, 240)`), and a new field changes nothing.

#![forbid(unsafe_code)]

mod bands;
pub mod camera_path;
mod clipping;
pub mod data;
mod error;
pub mod glyphs;
pub mod image;
mod load;
pub mod parts;
mod prepared;
pub mod scene_file;
pub mod session;
pub mod stereo;
pub mod strokes;
mod summary;
mod textures;
pub mod vector;

pub use bands::{MAX_PIXELS_IN_MEMORY, band_bytes, write_png_in_bands, write_png_in_bands_with};
pub use clipping::{ClipReport, Clipping};
pub use error::{Error, Result};
pub use image::{ImageError, Picture};
pub use load::{
    Inspection, LoadError, LoadOptions, LoadReport, LoadTimes, Loaded, LoadedMesh, Model, Normals, load,
};
pub use parts::LoadedPart;
pub use prepared::Origin;
pub use session::{PartId, Session, SessionError};
pub use summary::{AttributeSummary, MeshSummary, StrokesSummary};
pub use textures::{
    PanoramaFileError, TextureError, TextureOptions, TextureReport, panorama_from_file, texture_folders,
    texture_from_bytes,
};

pub use tercio_mesh::{ClusteredMesh, Mesh};
pub use tercio_parallel::ParallelError;
pub use tercio_raster::{Frame, RenderError, Renderer, Settings};
pub use tercio_scene::{Camera, CameraPath, Framing, Instance, Scene, Stereo};

pub use tercio_annotate as annotate;
pub use tercio_effects as effects;
pub use tercio_mesh as mesh;
pub use tercio_parallel as parallel;
pub use tercio_raster as raster;
pub use tercio_scene as scene;

pub use glam;
