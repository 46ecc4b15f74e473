//! The tile renderer: a scene and a camera become a picture.
//!
//! The data passes through the modules in this order. [`view`] holds the camera's transforms, [`projection`] projects
//! vertices to the screen; `frontend` culls the clusters that cover no sample; [`binning`] sorts the others into tiles;
//! `backend` resolves visibility in each tile and shades it; [`frame`] is the finished picture. [`mod@reference`] does
//! all of this in one plain loop, and every other path must equal it, bit for bit.
//!
//! [`screen`] is the screen-space geometry that all of them share, [`conventions`] lists their conventions, `simd`
//! holds the code that depends on the SIMD level. [`stats`] are the counts that come with every picture; [`tally`]
//! makes finer ones, for performance predictions, and [`survey`] is what is known of a frame before it is drawn.
//!
//! # Example
//!
//! ```
//! use tercio_mesh::builtin;
//! use tercio_mesh::cluster::{PartitionOptions, partition};
//! use tercio_raster::frame::NO_PRIMITIVE;
//! use tercio_raster::{Outputs, Renderer, Settings};
//! use tercio_scene::Scene;
//!
//! let mesh = builtin::make("builtin:teapot@1k")?;
//! let scene = Scene::from_mesh(partition(mesh, &PartitionOptions::default()));
//! let outputs = Outputs { depth: true, ids: true, ..Outputs::default() };
//! let settings = Settings { outputs, ..Settings::new(64, 48) };
//! let camera = settings.framing().camera_for_scene(&scene);
//! let frame = Renderer::new().render(&scene, &camera, &settings)?;
//!
//! let (ids, depth) = (&frame.planes.ids, &frame.planes.depth);
//! let seen = ids.iter().filter(|id| **id != NO_PRIMITIVE).count();
//! assert_eq!(seen as u64, frame.stats.backend.pixels_visible);
//! assert!(ids.iter().zip(depth).all(|(id, depth)| (*id == NO_PRIMITIVE) == depth.is_infinite()));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod backend;
pub mod binning;
mod cluster_set;
pub mod color;
pub mod context;
pub mod conventions;
mod data;
pub mod depth_bounds;
mod error;
pub mod frame;
mod frontend;
mod lighting;
pub mod projection;
pub mod reference;
mod renderer;
mod resolve;
pub mod sampling;
pub mod screen;
pub mod settings;
mod shadow_map;
mod shadow_window;
mod shadows;
mod simd;
pub mod stats;
mod surface_edges;
pub mod survey;
pub mod tally;
pub mod tone;
pub mod view;

pub use backend::encode::color8_lanes;
pub use cluster_set::ClusterSet;
pub use error::RenderError;
pub use frame::{Frame, Outputs};
pub use renderer::Renderer;
pub use resolve::{color8, color16};
pub use sampling::{Filter, SamplePattern, SampleShading, Sampling};
pub use screen::TileSet;
pub use settings::{Binning, Cull, LastStage, Part, Settings, Shading, SimdLevel, Sorting, TextureFilter};
pub use shadow_map::{ShadowArea, ShadowMaps};
#[doc(hidden)]
pub use simd::dispatch as dispatching;
pub use stats::FrameStats;
pub use tone::{Tone, ToneCurve};
