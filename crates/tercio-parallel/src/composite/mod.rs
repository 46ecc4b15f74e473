//! Transfer of pixels between ranks.

mod encoding;
pub mod exchange;
pub mod packet;
pub mod strategy;
mod touched;

pub use encoding::Encoding;
pub use strategy::{Composition, Radices, Round, Shared};
pub use touched::Touched;
