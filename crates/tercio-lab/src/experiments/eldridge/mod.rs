//! Figures and tables of document 000.

pub mod accounting;
pub mod communication;
pub mod composition;
