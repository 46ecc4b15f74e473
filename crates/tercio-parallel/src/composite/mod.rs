//! Transfer of pixels between ranks.

pub mod exchange;
pub mod packet;
pub mod strategy;
mod touched;

pub use strategy::{Composition, Radices, Round, Shared};
pub use touched::Touched;
