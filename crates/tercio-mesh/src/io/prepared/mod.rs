//! Prepared models: a clustered mesh in a file, as it lies in memory, so that it is mapped and drawn at once.
//!
//! All numbers are little-endian. The file begins with a [`Header`](format::Header), then follow its parts, each from a
//! multiple of [`format::ALIGNMENT`] bytes on, in the order of [`format::Kind`]. Every part has a checksum, which is
//! verified before anything of the part is used ([`checksum`]); [`check`] then finds out whether the clusters are what a
//! renderer relies on. What a file that was made on purpose with right checksums can do is show a wrong picture: bounds
//! and normal cones are not computed again.

mod check;
mod checksum;
mod format;
mod read;
mod write;

pub use read::{Prepared, is_prepared, read};
pub use write::write;

#[cfg(test)]
mod tests;
