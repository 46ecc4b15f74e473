//! Takes light away from a finished picture.

use rayon::prelude::*;
use tercio_raster::frame::Planes;
use tercio_raster::{color8, color16};

use crate::lanes::LANES;

/// Pixels that are darkened together.
const CHUNK: usize = 1 << 12;

/// Multiplies the premultiplied linear colours of a picture with the light that is left of each pixel, from 0 to 1; and
/// makes the 8-bit and 16-bit colours anew, where the picture has them. What keeps its light keeps its bytes.
///
/// # Panics
/// If the picture has no linear plane of one colour for each light, or other planes of colours with other sizes.
pub fn darken(planes: &mut Planes, light: &[f32]) {
    let Planes { color, color16: wide, linear, .. } = planes;
    assert!(linear.len() == light.len(), "a linear colour for each pixel");
    assert!([color.len(), wide.len()].iter().all(|&n| n == 0 || n == light.len()), "a colour for each pixel");
    for_each_darker(linear, linear_of, light);
    let linear = &*linear;
    for_each_darker(color, |color, index, _| *color = color8(linear[index]), light);
    for_each_darker(wide, |color, index, _| *color = color16(linear[index]), light);
}

fn linear_of(color: &mut [f32; 4], _: usize, light: f32) {
    (0..3).for_each(|k| color[k] *= light);
}

/// Changes the pixels that lost light, given with their index and light.
fn for_each_darker<T: Send>(pixels: &mut [T], change: impl Fn(&mut T, usize, f32) + Sync, light: &[f32]) {
    let chunks = pixels.par_chunks_mut(CHUNK).zip(light.par_chunks(CHUNK)).enumerate();
    chunks.for_each(|(number, (pixels, light))| {
        for (part, (pixels, light)) in pixels.chunks_mut(LANES).zip(light.chunks(LANES)).enumerate() {
            // Most of a picture is background.
            if light.iter().fold(true, |all, &light| all & (light >= 1.0)) {
                continue;
            }
            for (i, (pixel, &light)) in pixels.iter_mut().zip(light).enumerate() {
                if light < 1.0 {
                    change(pixel, number * CHUNK + part * LANES + i, light);
                }
            }
        }
    });
}
