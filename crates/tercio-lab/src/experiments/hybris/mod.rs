//! Figures and tables of document 001.

pub mod overlap;
pub mod performance;
