//! Document 001: H. Holten-Lund, Design for Scalability in 3D Computer Graphics Architectures (Hybris), 2001.
//!
//! Its overlap factors are in [`super::overlap`], its speed-ups with a serial part in [`super::amdahl`].

pub(crate) mod glossary;
pub mod rasterization;
pub mod rates;
pub mod records;

/// Bytes of a triangle node (figure 3.18).
pub(crate) const NODE: f64 = 64.0;
/// Side of a tile in pixels (4.3.1).
pub(crate) const TILE: f64 = 32.0;
