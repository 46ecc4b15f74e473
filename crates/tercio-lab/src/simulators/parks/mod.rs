//! Scan conversion by many microprocessors with a z-buffer each (document 002: Parks 1982).
//!
//! The screen is divided in two ways. A *splitter* (Parke) cuts it into chunks, one a processor; polygons are clipped
//! at the chunks' borders. An *interlace* (Fuchs) deals neighbouring pixels to different processors, which all work on
//! all polygons. A *hybrid* cuts into chunks and interlaces inside each.
//!
//! [`polygon`] scan-converts a polygon, [`split`] clips it at a chunk, [`machine`] says who has which pixels,
//! [`costs`] is the document's price list, [`statistics`] what its appendix C lists of every processor, and
//! [`simulate()`] runs a scene.
//!
//! Coordinates are whole pixels, x to the right and **y upwards** as in the document: line 0 is the lowest.

pub mod costs;
pub mod figure_15;
pub mod listing;
pub mod machine;
pub mod polygon;
mod simulate;
pub mod split;
pub mod statistics;
#[cfg(test)]
mod tests;

pub use costs::Costs;
pub use machine::{Machine, MachineError, Place};
pub use polygon::Polygon;
pub use simulate::{ProcessorRun, SceneRun, simulate};
pub use statistics::Distribution;
