//! Figures and tables of document 001.

pub mod counted;
pub mod engines;
pub mod heap;
pub mod overlap;
pub mod performance;
mod scenes;
pub mod sorting;
