//! The finished picture.

mod planes;
mod shared;

pub use planes::{Canvas, CanvasTile, Outputs, Pixel, Planes};

use crate::stats::FrameStats;

/// The id of a pixel where nothing was drawn.
pub const NO_PRIMITIVE: u32 = u32::MAX;

/// The rule of visibility as a number: what has the larger key is seen. A larger depth (it is above 0, so that its bits
/// are in order) comes before a lower primitive number, which is below [`NO_PRIMITIVE`] and counts through the
/// instances. Keys are above 0.
#[inline(always)]
pub fn visibility_key(depth: f32, primitive: u32) -> u64 {
    u64::from(depth.to_bits()) << 32 | u64::from(NO_PRIMITIVE - primitive)
}

/// A finished picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Frame {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Its planes, row by row, the upper left pixel first; those that were not asked for are empty.
    pub planes: Planes,
    /// What was counted and timed.
    pub stats: FrameStats,
}

impl Frame {
    /// In words, where this picture differs from an expected one; `None` if all planes are the same, bit for bit.
    pub fn difference(&self, expected: &Self) -> Option<String> {
        if (self.width, self.height) != (expected.width, expected.height) {
            let [own, other] = [self, expected].map(|f| format!("{} x {}", f.width, f.height));
            return Some(format!("{own} pixels, not {other}"));
        }
        let (found, place) = self.planes.first_difference(&expected.planes)?;
        let width = self.width.max(1) as usize;
        Some(format!("{found}, at ({}, {})", place % width, place / width))
    }
}
