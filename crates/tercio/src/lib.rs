//! Draws very large polygon models without a GPU: on one core or on all of them, from one static binary or
//! from this library, with the same bytes everywhere.
//!
//! # A picture in ten lines
//!
//! ```
//! use tercio::image::Picture;
//! use tercio::raster::{Renderer, Settings};
//! use tercio::scene::{Framing, Scene};
//!
//! # let folder = tempfile::tempdir()?;
//! # let png = folder.path().join("teapot.png");
//! let model = tercio::load("builtin:teapot@10k".as_ref(), &tercio::LoadOptions::default())?;
//! let scene = Scene::of_mesh(model.mesh);
//! let camera = Framing::for_size(320, 240).camera_for_scene(&scene);
//! let frame = Renderer::new().render(&scene, &camera, &Settings::new(320, 240))?;
//! Picture::of_frame(&frame).save(&png)?;
//! # assert_eq!(std::fs::read(&png)?[..4], *b"\x89PNG");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # The way through the library
//!
//! - [`load`] reads a model (PLY, OBJ, STL, OFF, each also gzip-compressed, or a built-in one), repairs it,
//!   makes the normals it lacks and cuts it into clusters, which is what a renderer draws. [`load_mesh`]
//!   stops before the cutting, for programs that want the [`mesh::Mesh`] itself. [`load_input`] reads from memory.
//! - [`scene`] places meshes in the world, lights them and frames them with a camera.
//! - [`raster`] draws. A [`raster::Renderer`] keeps its memory from frame to frame.
//! - [`parallel`] draws with several ranks, which share a frame and send each other messages.
//! - [`image`] writes pictures (PNG, PPM, WebP) and arrays (NPY), reads and compares pictures.
//!
//! Everything runs in the rayon pool of its caller: wrap the calls in `ThreadPool::install` to choose the
//! number of threads. The picture does not depend on it.

pub mod image;
mod load;
mod summary;

pub use load::{
    LoadError, LoadOptions, LoadReport, LoadTimes, Loaded, LoadedMesh, Normals, load, load_if, load_input,
    load_mesh, load_mesh_input,
};
pub use summary::{AttributeSummary, MeshSummary};

pub use tercio_mesh as mesh;
pub use tercio_parallel as parallel;
pub use tercio_raster as raster;
pub use tercio_scene as scene;

pub use glam;
