//! The reference formulas for the filter: from samples to pixels.

use tercio_scene::Scene;

use crate::color::{encode8, encode16};
use crate::conventions::{SAMPLE, SUBPIXELS};
use crate::frame::Pixel;
use crate::sampling::{Filter, SampleCells};
use crate::settings::Settings;

/// The pixels of a picture, row by row, from the samples of all pixels.
pub fn pixels(samples: &[Pixel], scene: &Scene, settings: &Settings) -> Vec<Pixel> {
    let cells = settings.sampling.pattern.cells();
    let n = cells.count;
    if n == 1 {
        return samples.to_vec();
    }
    let (width, height) = (settings.width as usize, settings.height as usize);
    let mut pixels = Vec::new();
    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
        let own = &samples[(y * width + x) * n..][..n];
        let mut contributing = Vec::new();
        match settings.sampling.filter {
            Filter::Box => contributing.extend(own.iter().map(|sample| (sample, 1.0))),
            Filter::Tent => {
                for (column, row) in around(y, height).flat_map(|r| around(x, width).map(move |c| (c, r))) {
                    for number in 0..n {
                        let weight = tent(&cells, number, [column, row], [x, y]);
                        if weight > 0.0 {
                            contributing.push((&samples[(row * width + column) * n + number], weight));
                        }
                    }
                }
            }
        }
        let mut pixel = Pixel::of_background(&scene.background, y as u32, settings.height);
        let key = |sample: &Pixel| (sample.keys, sample.ties);
        let keys = contributing.iter().map(|(sample, _)| key(sample));
        (pixel.keys, pixel.ties) = keys.max().unwrap_or_default();
        if pixel.keys > 0 {
            let linear = match settings.sampling.filter {
                Filter::Box if own.iter().all(|s| s.linear == own[0].linear) => own[0].linear,
                Filter::Box => sum(own).map(|c| c / n as f32),
                Filter::Tent => {
                    let mut sum = [0.0; 4];
                    for (sample, weight) in &contributing {
                        (0..4).for_each(|k| sum[k] += sample.linear[k] * weight);
                    }
                    let total: f32 = contributing.iter().map(|(_, weight)| weight).sum();
                    sum.map(|c| c / total)
                }
            };
            set_colors(&mut pixel, linear);
        }
        let nearest = own.iter().fold(&own[0], |best, s| if key(s) > key(best) { s } else { best });
        if nearest.keys > 0 {
            (pixel.depth, pixel.ids, pixel.normals) = (nearest.depth, nearest.ids, nearest.normals);
        }
        pixels.push(pixel);
    }
    pixels
}

/// Sets the colours of a pixel, from a premultiplied linear colour.
pub fn set_colors(pixel: &mut Pixel, linear: [f32; 4]) {
    pixel.linear = linear;
    let [r, g, b, alpha] = linear;
    let straight = |c: f32| match alpha {
        0.0 => 0.0,
        alpha if alpha < 1.0 => c / alpha,
        _ => c,
    };
    let level = |most: f32| alpha.clamp(0.0, 1.0) * most + 0.5;
    let rgb = [straight(r), straight(g), straight(b)];
    pixel.color = [encode8(rgb[0]), encode8(rgb[1]), encode8(rgb[2]), level(255.0) as u8];
    pixel.color16 = [encode16(rgb[0]), encode16(rgb[1]), encode16(rgb[2]), level(65535.0) as u16];
}

/// A column or row and those beside it, inside the picture.
fn around(at: usize, size: usize) -> std::ops::Range<usize> {
    at.saturating_sub(1)..(at + 2).min(size)
}

/// The sum of the samples' colours: of the first half and of the second.
fn sum(samples: &[Pixel]) -> [f32; 4] {
    if let [only] = samples {
        return only.linear;
    }
    let (first, second) = samples.split_at(samples.len() / 2);
    let (a, b) = (sum(first), sum(second));
    [a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]]
}

/// The weight of sample `number` of pixel `of` in pixel `at`.
fn tent(cells: &SampleCells, number: usize, of: [usize; 2], at: [usize; 2]) -> f32 {
    let along = |k: usize| {
        let apart = (of[k] as i32 - at[k] as i32) * SUBPIXELS + cells.offset(number)[k] - SAMPLE;
        (SUBPIXELS - apart.abs()).max(0)
    };
    (along(0) * along(1)) as f32
}
