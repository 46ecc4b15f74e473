//! Effects that are computed from a finished picture's planes: they darken what is visible.
//!
//! [`AmbientOcclusion`] darkens gaps and pockets, [`EyeDome`] outlines steps of depth. Each pixel is computed from the
//! finished depths and normals by operations that are the same at every SIMD level, so that the result does not depend on
//! tiles, threads, ranks or SIMD levels, and there are no seams. The whole picture must be there: a band is not enough.
//!
//! They take light from all of a pixel's colour. Pixels at the edge of a model show some background, too: it keeps its light
//! if the picture is drawn on a transparent background, and [`add_background`] puts the real one behind it afterwards.
//!
//! ```
//! use tercio_effects::AmbientOcclusion;
//! use tercio_mesh::builtin;
//! use tercio_mesh::cluster::{PartitionOptions, partition};
//! use tercio_raster::{Renderer, Settings};
//! use tercio_scene::Scene;
//!
//! let mesh = builtin::make("builtin:teapot@5k")?;
//! let scene = Scene::from_mesh(partition(mesh, &PartitionOptions::default()));
//! let settings = Settings { outputs: AmbientOcclusion::NEEDED, ..Settings::new(160, 120) };
//! let camera = settings.framing().camera_for_scene(&scene);
//! let mut frame = Renderer::new().render(&scene, &camera, &settings)?;
//!
//! let light = |linear: &[[f32; 4]]| linear.iter().map(|[r, g, b, _]| r + g + b).sum::<f32>();
//! let before = light(&frame.planes.linear);
//! AmbientOcclusion::default().apply(&mut frame, &scene, &camera, &settings)?;
//! assert!(light(&frame.planes.linear) < before);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`surface`] says where the visible points are, in the camera's axes; [`darken`] takes light away from rows of colours.

#![forbid(unsafe_code)]

pub mod background;
pub mod darken;
pub mod eye_dome;
mod lanes;
pub mod occlusion;
pub mod surface;

pub use background::add_background;
pub use eye_dome::EyeDome;
pub use occlusion::AmbientOcclusion;
