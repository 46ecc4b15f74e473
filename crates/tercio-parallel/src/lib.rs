//! Several ranks draw one picture, with the bytes that one renderer gives.
//!
//! | module | what |
//! |---|---|
//! | [`comm`] | communication between ranks: the [`Communicator`] and its backend in one process |
//! | [`division`] | who draws which tiles |
//! | [`composite`] | what several ranks have drawn of the same tiles: [packed](composite::packet), [exchanged](composite::exchange) in the order of a [strategy](composite::strategy), merged |
//! | [`organisation`] | who draws what, and where work is redistributed: sort-first, sort-middle, sort-last, sort-twice |
//! | [`parts`] | models of which every rank holds a part |
//! | [`placement`] | threads on processors |
//! | [`numbers`] | properties of whole numbers |
//! | [`report`] | counts and times of every rank |
//! | [`trace`] | when each rank did what |
//! | [`in_process`] | all ranks in one process, a thread each |
//! | [`between_processes`] | the same where every rank is a process of its own |
//!
//! A rank draws with a [`tercio_raster::Renderer`] of its own. Clusters and tiles keep their numbers whichever rank
//! draws them ([`tercio_raster::ClusterSet`], [`tercio_raster::TileSet`]), and visibility is decided by [`tercio_raster::frame::visibility_key`]
//! (beyond 2^32 primitives [`tercio_raster::frame::wide_key`]) within a rank as between ranks; so the picture is that of one process.
//!
//! # Example
//!
//! ```
//! use tercio_mesh::builtin;
//! use tercio_mesh::cluster::{PartitionOptions, partition};
//! use tercio_parallel::{Organisation, Ranks, in_process};
//! use tercio_raster::{Renderer, Settings};
//! use tercio_scene::Scene;
//!
//! let mesh = builtin::make("builtin:teapot@10k")?;
//! let scene = Scene::from_mesh(partition(mesh, &PartitionOptions::default()));
//! let settings = Settings::new(160, 120);
//! let camera = settings.framing().camera_for_scene(&scene);
//!
//! let ranks = Ranks { count: 3, threads: 1, sharing: Organisation::SortLast.into() };
//! let (frame, report) = in_process::draw(ranks, &scene, &camera, &settings)?;
//! assert_eq!(report.ranks.len(), 3);
//! assert!(report.bytes > 0);
//!
//! let alone = Renderer::new().render(&scene, &camera, &settings)?;
//! assert_eq!(frame.planes.color, alone.planes.color);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![forbid(unsafe_code)]

mod agreement;
pub mod between_processes;
mod clock;
pub mod comm;
pub mod composite;
pub mod division;
mod error;
pub mod in_process;
pub mod numbers;
pub mod organisation;
pub mod parts;
pub mod placement;
pub mod report;
pub mod trace;

pub use agreement::Matter;
pub use comm::Communicator;
pub use composite::{Composition, Encoding, Radices};
pub use division::{ClusterDivision, Division};
pub use error::ParallelError;
pub use in_process::{Ranks, draw_frames};
pub use organisation::{Organisation, Sharing};
pub use parts::PartsError;
pub use report::{FrameReport, RankReport};
pub use trace::Trace;
