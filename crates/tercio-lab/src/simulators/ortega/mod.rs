//! Data-parallel polygon rendering on a SIMD machine (document 004: Ortega and Hansen 1993).
//!
//! All polygons take a step at once. The first loop runs over scan lines: in pass i every polygon finds the segments of
//! its i-th line, so there are as many passes as the tallest polygon has lines. Segments are collected in a buffer;
//! when it is full, the second loop runs over pixels: in pass j every segment sends its j-th pixel to the picture, so
//! there are as many passes as the longest segment has pixels. Of the pixels that collide at one destination the
//! network keeps the nearest. With more polygons or segments than processors, a pass takes several steps (virtual
//! processors).
//!
//! [`scan`] finds a polygon's segments; [`simulate()`] runs the loops. The document gives neither the size of the
//! buffer nor the time of a step: the first is a parameter, times are not computed.

pub mod scan;
mod simulate;
#[cfg(test)]
mod tests;

pub use scan::Segment;
pub use simulate::{Machine, Picture, Run, simulate};
