//! Arrays of pixel processors that step through the regions of a screen (document 003: McManus and Beckmann).
//!
//! The screen is divided into regions of A x A pixels, and an array of A x A pixel processors draws one region after
//! another. A polygon goes into the bin of every region that its bounding box meets, and costs one raster cycle in
//! each, whatever its size. [`cycles`] counts them; [`silicon`] relates them to the area of the machine.
//!
//! Pixels of bounding boxes are inclusive, so that a box of w pixels meets (w + A - 1)/A regions along an axis on
//! average: the document's equation 6.

pub mod cycles;
pub mod silicon;

pub use cycles::{RasterCycles, raster_cycles};
pub use silicon::{AreaModel, Renderer, renderers};
