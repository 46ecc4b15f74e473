//! Takes light away from a finished picture.

use rayon::prelude::*;
use tercio_raster::frame::Planes;
use tercio_raster::{color8, color16};

/// Multiplies the premultiplied linear colours of a picture with the light that is left of each pixel, from 0 to 1; and
/// makes the 8-bit and 16-bit colours anew, where the picture has them. What keeps its light keeps its bytes.
///
/// # Panics
/// If there are fewer linear colours than lights, or fewer lights than colours.
pub fn darken(planes: &mut Planes, light: &[f32]) {
    const CHUNK: usize = 1 << 12;
    let Planes { color, color16: wide, linear, .. } = planes;
    assert!(linear.len() == light.len(), "a linear colour for each pixel");
    let chunks = linear.par_chunks_mut(CHUNK).zip(light.par_chunks(CHUNK));
    chunks.for_each(|(linear, light)| {
        for (linear, &light) in linear.iter_mut().zip(light) {
            let [r, g, b, alpha] = *linear;
            *linear = if light < 1.0 { [r * light, g * light, b * light, alpha] } else { *linear };
        }
    });
    encode(color, linear, light, color8);
    encode(wide, linear, light, color16);
}

/// Encodes the colours of those pixels that lost light.
fn encode<T: Send>(to: &mut [T], linear: &[[f32; 4]], light: &[f32], encoded: impl Fn([f32; 4]) -> T + Sync) {
    let pixels = to.par_iter_mut().zip(linear).zip(light).with_min_len(1 << 12);
    pixels.filter(|(_, light)| **light < 1.0).for_each(|((to, linear), _)| *to = encoded(*linear));
}
