//! From samples to pixels: means of colours in linear light, and their encoding.

use crate::color::{encode8, encode16};
use crate::frame::{Outputs, Pixel};

/// The mean of 1, 2, 4, 8 or 16 colours: sums of neighbours, then sums of these. The mean of equal colours is that
/// colour, also if their sum would overflow.
#[inline(always)]
pub fn mean(colors: &mut [[f32; 4]]) -> [f32; 4] {
    if colors.iter().all(|color| *color == colors[0]) {
        return colors[0];
    }
    let scale = 1.0 / colors.len() as f32;
    let mut count = colors.len();
    while count > 1 {
        count /= 2;
        for i in 0..count {
            let (a, b) = (colors[2 * i], colors[2 * i + 1]);
            colors[i] = [a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]];
        }
    }
    let [r, g, b, alpha] = colors[0];
    [r * scale, g * scale, b * scale, alpha * scale]
}

/// The weighted mean of colours, summed in their order.
#[inline(always)]
pub fn weighted_mean(colors: impl Iterator<Item = ([f32; 4], f32)>) -> [f32; 4] {
    let (mut sum, mut total) = ([0.0; 4], 0.0);
    for (color, weight) in colors {
        sum = std::array::from_fn(|k| sum[k] + color[k] * weight);
        total += weight;
    }
    sum.map(|c: f32| c / total)
}

/// 8-bit sRGB colour with straight alpha of a premultiplied linear colour.
pub fn color8(linear: [f32; 4]) -> [u8; 4] {
    let [r, g, b] = straight(linear).map(encode8);
    [r, g, b, (linear[3].clamp(0.0, 1.0) * 255.0 + 0.5) as u8]
}

/// 16-bit sRGB colour with straight alpha of a premultiplied linear colour.
pub fn color16(linear: [f32; 4]) -> [u16; 4] {
    let [r, g, b] = straight(linear).map(encode16);
    [r, g, b, (linear[3].clamp(0.0, 1.0) * 65535.0 + 0.5) as u16]
}

/// Black where nothing is opaque.
fn straight([r, g, b, alpha]: [f32; 4]) -> [f32; 3] {
    match alpha {
        opaque if opaque >= 1.0 => [r, g, b],
        alpha if alpha > 0.0 => [r / alpha, g / alpha, b / alpha],
        _ => [0.0; 3],
    }
}

/// Sets the colours of a pixel that are requested, from a premultiplied linear colour.
pub fn set_colors(pixel: &mut Pixel, linear: [f32; 4], outputs: &Outputs) {
    pixel.linear = linear;
    if outputs.color {
        pixel.color = color8(linear);
    }
    if outputs.color16 {
        pixel.color16 = color16(linear);
    }
}
