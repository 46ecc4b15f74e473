//! Document 002: J. K. Parks, A Comparison of Two Multiprocessor Graphics Machine Designs, 1982.
//!
//! Times are memory cycles: `N` polygons, `V` vertices, `S` segments (runs of pixels on a scan line), `P` pixels, with
//! `Gt`, `Vt`, `St`, `Pt` cycles each. The machines divide 512 by 512 pixels among 1, 4 or 16 processors by chunks
//! (splitter), by remainder of the coordinates (interlace), or by both (hybrid); the slowest processor counts.

pub mod costs;
pub mod distributions;
pub(crate) mod glossary;
pub mod scenes;
