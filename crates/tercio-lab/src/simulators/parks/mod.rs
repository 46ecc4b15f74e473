//! Scan conversion by many microprocessors with a z-buffer each (document 002: Parks 1982).
//!
//! The screen is divided in two ways. A *splitter* (Parke) divides it into chunks, one per processor; polygons are
//! clipped at the chunks' borders. An *interlace* (Fuchs) assigns neighbouring pixels to different processors, which
//! all work on all polygons. A *hybrid* divides into chunks and interlaces inside each.
//!
//! [`polygon`] scan-converts a polygon, [`split`] clips it at a chunk, [`machine`] assigns pixels to processors,
//! [`costs`] are the document's costs, [`statistics`] are those that its appendix C lists for every processor, and
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
