//! One command a file.

pub mod compare;
pub mod info;
pub mod render;
