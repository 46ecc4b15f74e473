//! The background, behind a picture that was drawn without one.

use std::ops::Range;

use rayon::prelude::*;
use tercio_raster::frame::{Pixel, Planes};
use tercio_raster::{color8, color16};
use tercio_scene::Background;

use crate::darken::{Colors, bands};

/// Puts a background behind the colours of a picture of this width that was drawn on a transparent one
/// (`Background::Solid([0.0; 4])`), in linear light: in its linear plane, and in the 8-bit and 16-bit planes if it has them.
/// Effects on such a picture take no light from the background's share of a pixel.
///
/// # Panics
/// If the picture has no linear plane of whole rows, or its other planes of colours have other sizes.
pub fn add_background(planes: &mut Planes, width: usize, background: &Background) {
    let pixels = planes.linear.len();
    assert!(width > 0 && pixels.is_multiple_of(width), "whole rows");
    let height = (pixels / width) as u32;
    bands(planes, width, BAND).into_par_iter().enumerate().for_each(|(number, mut colors)| {
        for row in 0..colors.linear.len() / width {
            let y = number * BAND + row;
            let behind = Pixel::of_background(background, y as u32, height);
            behind_row(&mut colors, row * width..(row + 1) * width, &behind);
        }
    });
}

/// Rows that one thread works on at a time.
const BAND: usize = 32;

/// Puts a colour behind some pixels. Most of them are opaque, or show nothing, beside others of the same kind.
fn behind_row(colors: &mut Colors, pixels: Range<usize>, behind: &Pixel) {
    let mut first = pixels.start;
    while first < pixels.end {
        let rest = &mut colors.linear[first..pixels.end];
        let alpha = rest[0][3];
        let run = |differs: fn(f32) -> bool| rest.iter().position(|c| differs(c[3])).unwrap_or(rest.len());
        if !(alpha < 1.0) {
            first += run(|alpha| alpha < 1.0);
        } else if alpha > 0.0 {
            let mixed = over(rest[0], behind.linear);
            rest[0] = mixed;
            if let Some(narrow) = colors.narrow.get_mut(first) {
                *narrow = color8(mixed);
            }
            if let Some(wide) = colors.wide.get_mut(first) {
                *wide = color16(mixed);
            }
            first += 1;
        } else {
            let end = first + run(|alpha| !(alpha <= 0.0));
            colors.linear[first..end].fill(behind.linear);
            colors.narrow.get_mut(first..end).unwrap_or_default().fill(behind.color);
            colors.wide.get_mut(first..end).unwrap_or_default().fill(behind.color16);
            first = end;
        }
    }
}

/// A premultiplied colour before another one.
fn over(front: [f32; 4], behind: [f32; 4]) -> [f32; 4] {
    let left = 1.0 - front[3];
    std::array::from_fn(|k| front[k] + behind[k] * left)
}
