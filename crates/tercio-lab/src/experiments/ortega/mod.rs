//! Tables and figures of document 004.

pub mod speed;
pub mod time_model;
