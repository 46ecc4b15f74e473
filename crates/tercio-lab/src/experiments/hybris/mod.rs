//! Figures and tables of document 001.

pub mod counted;
pub mod culling;
pub mod engines;
pub mod heap;
pub mod overlap;
pub mod parallel;
pub mod performance;
pub mod sampling;
mod scenes;
pub mod sorting;
