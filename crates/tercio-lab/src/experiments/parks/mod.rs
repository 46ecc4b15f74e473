//! Figures and tables of document 002.

pub mod costs;
pub mod tables;
