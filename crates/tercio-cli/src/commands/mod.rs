//! One command a file.

pub mod bench;
pub mod compare;
pub mod definition;
pub mod info;
pub mod lab;
pub mod prepare;
mod reference;
pub mod render;
