//! Exact simulators of the published machines.

pub mod hybris;
pub mod sorting;
