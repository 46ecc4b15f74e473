//! The input of the machines.
//!
//! | module | what |
//! |---|---|
//! | [`boxes`] | bounding boxes of polygons: the input of documents 000 (appendix A) and 003 |
//! | [`polygons`] | whole screen polygons: the input of documents 002 and 004 |
//! | [`screen_map`] | which processor rasterizes which pixel |
//! | [`synthetic`] | scenes made from stated distributions, the same on every machine |
//! | [`projection`] | boxes and polygons of a real model under a real camera |
//!
//! **Screen space** everywhere here: pixel (0, 0) is the upper left one, x points to the right, y downwards. Pixel
//! boxes are inclusive on both sides.

pub mod boxes;
mod error;
mod pixel_box;
pub mod polygons;
pub mod projection;
pub mod screen_map;
pub mod synthetic;
mod text;

pub use boxes::{BoundingBox, BoxScene};
pub use error::{ReadError, SyntaxError};
pub use pixel_box::PixelBox;
pub use polygons::{PolygonScene, ScreenPoint, ScreenPolygon};
pub use screen_map::ScreenMap;

/// Maximum number of pixels of a screen: the simulators' data for each pixel has to fit into memory.
pub const MAX_SCREEN_PIXELS: u64 = 1 << 26;
