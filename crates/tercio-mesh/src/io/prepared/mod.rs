//! Prepared models: a clustered mesh in a file, laid out as in memory, so that it can be mapped and drawn
//! immediately.
//!
//! All numbers are little-endian. The file begins with a [`Header`](format::Header), followed by its parts, each from
//! a multiple of [`format::ALIGNMENT`] bytes on, in the order of [`format::Kind`]. Every part has a checksum, which
//! is verified before anything of the part is used ([`crate::checksum`]); then [`check`] verifies the properties of the
//! clusters that a renderer relies on. The most that a forged file with correct checksums can do is to show a wrong
//! picture: bounds and normal cones are not recomputed.

mod check;
mod format;
mod read;
mod write;

pub use read::{Parts, Prepared, is_prepared, read};
pub use write::write;

#[cfg(test)]
mod tests;
