//! The finished picture.

pub mod fragments;
mod planes;
mod shared;

pub use fragments::{
    FinishedPart, FragmentError, FragmentLayout, FragmentMerger, FragmentsOfTile, TileFragments,
};
pub use planes::{Canvas, CanvasTile, Outputs, Pixel, Planes};

use crate::stats::FrameStats;

/// The id of a pixel where nothing was drawn.
pub const NO_PRIMITIVE: u32 = u32::MAX;

/// Visibility as one number: the sample with the larger key is visible. The key compares by depth first (depths are
/// above 0, so their bits are ordered as the numbers are), then by primitive number, of which the lower gives the
/// larger key. Primitive numbers are below [`NO_PRIMITIVE`] here, and count through the instances. Keys are above 0.
#[inline(always)]
pub fn visibility_key(depth: f32, primitive: u32) -> u64 {
    u64::from(depth.to_bits()) << 32 | u64::from(NO_PRIMITIVE - primitive)
}

/// [`visibility_key`] for primitive numbers of 64 bits.
#[inline(always)]
pub fn wide_key(depth: f32, primitive: u64) -> u128 {
    u128::from(depth.to_bits()) << 64 | u128::from(u64::MAX - primitive)
}

/// A [`wide_key`] as a frame stores it: in the plane of keys, and in that of ties. Keys compare first, then ties. Where no primitive
/// number needs more than 32 bits, `is_wide` is not set: the key is the [`visibility_key`], and all ties are 0. Of 0, where nothing
/// was drawn, both are 0.
#[inline(always)]
pub fn key_and_tie(key: u128, is_wide: bool) -> (u64, u32) {
    match is_wide {
        true => ((key >> 32) as u64, key as u32),
        false => ((key >> 64 << 32) as u64 | u64::from(key as u32), 0),
    }
}

/// A finished picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Frame {
    /// Width in pixels; of a frame that keeps samples, in samples.
    pub width: u32,
    /// Height in pixels: that of the picture, or of a band of it.
    pub height: u32,
    /// Its planes, row by row, the upper left pixel first; those that were not requested are empty.
    pub planes: Planes,
    /// The fragments of its tiles, in the order of the tiles, if they are kept instead of planes
    /// ([`Settings::keep_fragments`](crate::Settings::keep_fragments)); tiles of which nothing is kept or finished are left out.
    pub fragments: Vec<TileFragments>,
    /// Counts and times.
    pub stats: FrameStats,
}

impl Frame {
    /// Describes the first difference between this picture and an expected one; `None` if all planes are the same, bit
    /// for bit.
    pub fn difference(&self, expected: &Self) -> Option<String> {
        if (self.width, self.height) != (expected.width, expected.height) {
            let [own, other] = [self, expected].map(|f| format!("{} x {}", f.width, f.height));
            return Some(format!("{own} pixels, not {other}"));
        }
        let (found, index) = self.planes.first_difference(&expected.planes)?;
        let width = self.width.max(1) as usize;
        Some(format!("{found}, at ({}, {})", index % width, index / width))
    }
}
