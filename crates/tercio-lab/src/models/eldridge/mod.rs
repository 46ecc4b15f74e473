//! Document 000: M. W. Eldridge, SIMD Column-Parallel Polygon Rendering, 1995.
//!
//! Symbols: `n` processors, `p` polygons, `G` instructions of geometry per polygon (`Gi` to transform and test it,
//! `Gf` to finish it), `A` pixels per polygon, `R` instructions per rasterized pixel, `f` polygons in the fullest
//! region over the mean (asymmetry), `o` regions that a polygon meets, `Q` (also `P`) pixels of the screen, `a` words
//! of a datum, `b` instructions of overhead per pass, `d` distance of a pass, `m` copies of the database, `g`
//! processors per group, `C` instructions to hand a datum to the neighbour.
//!
//! The document counts `p` differently from chapter to chapter: all polygons in chapter 5 (halved for visibility
//! from equation 5.8 on), visible ones only from equation 6.5 on. Each function says which.

pub mod comparison;
pub mod distribution;
pub mod geometry;
pub(crate) mod glossary;
pub mod placement;
pub mod planes;
pub mod ring;
pub mod sort_twice;
pub mod throughput;

/// Processors of the Princeton Engine (table 4.3).
pub(crate) const PROCESSORS: f64 = 1024.0;
/// Clock of the Princeton Engine as the document uses it, Hz (2.1); the actual clock is 14.318 MHz.
pub(crate) const CLOCK: f64 = 14e6;
/// Scan lines a second (7.6).
pub(crate) const LINE_RATE: f64 = 15_750.0;
/// Instructions per scan line (8.1); 910 of them need 14.33 MHz, so neither is derived from the other.
pub(crate) const LINE_BUDGET: f64 = 910.0;
/// Instructions of geometry per polygon (table 4.3).
pub(crate) const GEOMETRY: f64 = 5000.0;
/// Pixels per polygon (table 4.3).
pub(crate) const AREA: f64 = 100.0;
/// Instructions per pixel (table 4.3).
pub(crate) const RASTER: f64 = 100.0;
/// Pixels of the screen, 768 by 512 (table 4.3).
pub(crate) const SCREEN: f64 = 393_216.0;
/// Asymmetry factor as table 4.3 prints it; figure 4-1 gives 16.9 by the definition of table 4.1.
pub(crate) const ASYMMETRY: f64 = 4.4;
/// Overlap factor of the teapot (table 4.3).
pub(crate) const OVERLAP: f64 = 3.8;
/// Words and overhead of a polygon descriptor, the datum of sort-middle (table 4.2).
pub(crate) const DESCRIPTOR: (f64, f64) = (42.0, 30.0);
/// Words and overhead of a pixel of dense sort-last (table 4.2).
pub(crate) const PIXEL: (f64, f64) = (3.0, 15.0);
/// Instructions to pass a descriptor to the neighbour: 3 * 42 + 30.
pub(crate) const DESCRIPTOR_PASS: f64 = 156.0;
