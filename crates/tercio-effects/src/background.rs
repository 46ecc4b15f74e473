//! The background, behind a picture that was drawn without one.

use rayon::prelude::*;
use tercio_raster::frame::{Pixel, Planes};
use tercio_raster::{color8, color16};
use tercio_scene::Background;

/// Puts a background behind the colours of a picture of this width that was drawn on a transparent one
/// (`Background::Solid([0.0; 4])`), in linear light: in its linear plane, and in the 8-bit and 16-bit planes if it has them.
/// Effects on such a picture take no light from the background's share of a pixel.
///
/// # Panics
/// If the picture has no linear plane of whole rows, or its other planes of colours have other sizes.
pub fn add_background(planes: &mut Planes, width: usize, background: &Background) {
    let Planes { color, color16: wide, linear, .. } = planes;
    let pixels = linear.len();
    assert!(width > 0 && pixels.is_multiple_of(width), "whole rows");
    assert!([color.len(), wide.len()].iter().all(|&n| n == 0 || n == pixels), "a colour for each pixel");
    let height = (pixels / width) as u32;
    let row = |y: usize| Pixel::of_background(background, y as u32, height);
    // Only what is not opaque changes.
    let rows = color.par_chunks_mut(width).zip(linear.par_chunks(width)).enumerate();
    rows.for_each(|(y, (to, linear))| {
        let behind = row(y);
        for (to, linear) in to.iter_mut().zip(linear).filter(|(_, linear)| linear[3] < 1.0) {
            *to = if linear[3] > 0.0 { color8(over(*linear, behind.linear)) } else { behind.color };
        }
    });
    let rows = wide.par_chunks_mut(width).zip(linear.par_chunks(width)).enumerate();
    rows.for_each(|(y, (to, linear))| {
        let behind = row(y);
        for (to, linear) in to.iter_mut().zip(linear).filter(|(_, linear)| linear[3] < 1.0) {
            *to = if linear[3] > 0.0 { color16(over(*linear, behind.linear)) } else { behind.color16 };
        }
    });
    linear.par_chunks_mut(width).enumerate().for_each(|(y, row_of_linear)| {
        let behind = row(y).linear;
        for linear in row_of_linear.iter_mut().filter(|linear| linear[3] < 1.0) {
            *linear = over(*linear, behind);
        }
    });
}

/// A premultiplied colour before another one.
fn over(front: [f32; 4], behind: [f32; 4]) -> [f32; 4] {
    let left = 1.0 - front[3];
    std::array::from_fn(|k| front[k] + behind[k] * left)
}
