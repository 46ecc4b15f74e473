//! The finished picture.

pub mod planes;

use crate::{FrameStats, Settings};

/// The id of a pixel where nothing was drawn.
pub const NO_PRIMITIVE: u32 = u32::MAX;

/// The rule of visibility as a number: what has the larger key is seen. A larger depth (it is above 0, so that its bits
/// are in order) comes before a lower primitive number, which is below [`NO_PRIMITIVE`] and counts through the
/// instances. Keys are above 0.
#[inline(always)]
pub fn visibility_key(depth: f32, primitive: u32) -> u64 {
    u64::from(depth.to_bits()) << 32 | u64::from(NO_PRIMITIVE - primitive)
}

/// A finished picture. Every plane is row-major, the upper left pixel first, and empty if it was not asked
/// for.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Frame {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// sRGB colour, alpha not multiplied in.
    pub color: Vec<[u8; 4]>,
    /// sRGB colour, 16 bits.
    pub color16: Vec<[u16; 4]>,
    /// Distance from the eye along the line of sight in world units; infinite where nothing was drawn.
    pub depth: Vec<f32>,
    /// Number of the input face (polygon) that is seen, counted through the instances in order;
    /// [`NO_PRIMITIVE`] where nothing was drawn.
    pub ids: Vec<u32>,
    /// What is seen, as [`visibility_key`]s; 0 where nothing was drawn.
    pub keys: Vec<u64>,
    /// Unit normals in world space, those that the picture is lit by: see [`crate::conventions`]. None points away from the
    /// viewer but for rounding; zero where nothing was drawn.
    pub normals: Vec<[f32; 3]>,
    /// What was counted and timed.
    pub stats: FrameStats,
}

impl Frame {
    /// Gives the planes that the settings ask for their size.
    pub(crate) fn resize(&mut self, settings: &Settings) {
        fn fit<T: Clone + Default>(plane: &mut Vec<T>, wanted: bool, pixels: usize) {
            plane.resize(if wanted { pixels } else { 0 }, T::default());
        }
        self.width = settings.width;
        self.height = settings.height;
        let pixels = settings.width as usize * settings.height as usize;
        let outputs = &settings.outputs;
        fit(&mut self.color, outputs.color, pixels);
        fit(&mut self.color16, outputs.color16, pixels);
        fit(&mut self.depth, outputs.depth, pixels);
        fit(&mut self.ids, outputs.ids, pixels);
        fit(&mut self.normals, outputs.normals, pixels);
        fit(&mut self.keys, outputs.keys, pixels);
    }
}
