//! One command a file.

pub mod bench;
pub mod compare;
pub mod definition;
pub mod info;
pub mod lab;
pub mod prepare;
pub mod render;
