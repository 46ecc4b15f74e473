//! From samples to pixels: averages colours in linear light, and selects the nearest sample for everything else.

use tercio_scene::Scene;

use crate::color::{encode8, encode16};
use crate::frame::{Frame, Outputs, Pixel};
use crate::sampling::{FilterWeights, MAX_SAMPLES, Tap};
use crate::settings::Settings;

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

/// Resolves a frame of samples ([`Settings::unresolved`]) into the picture that the settings request. The frame has keys;
/// linear colours if the settings request any colour; and depth, ids and normals as the settings request them.
///
/// # Panics
/// If the frame does not have the size of these settings or one of these planes, or the settings request samples or a band.
pub fn resolve_into(samples: &Frame, scene: &Scene, settings: &Settings, frame: &mut Frame) {
    let weights = FilterWeights::new(&settings.sampling);
    let count = settings.sampling.pattern.count();
    assert!(!settings.unresolved && settings.band.is_none(), "the settings of a whole picture");
    assert_eq!([samples.width, samples.height], [settings.width * count as u32, settings.height]);
    let Outputs { color, color16, linear, depth, ids, normals, .. } = settings.outputs;
    let planes = &samples.planes;
    let all = samples.width as usize * samples.height as usize;
    let has = |wanted: bool, length: usize| !wanted || length == all;
    let is_complete = has(true, planes.keys.len())
        && has(color || color16 || linear, planes.linear.len())
        && has(depth, planes.depth.len())
        && has(ids, planes.ids.len())
        && has(normals, planes.normals.len());
    assert!(is_complete, "the frame has the planes that the picture needs");
    frame.resize(settings);
    let outputs = &settings.outputs;
    let size = [settings.width, settings.height].map(|n| n as i32);
    let source = Source { samples, count, size };
    for y in 0..size[1] {
        let background = Pixel::of_background(&scene.background, y as u32, settings.height);
        for x in 0..size[0] {
            let pixel = source.pixel([x, y], &weights.taps, &background, outputs);
            frame.planes.put(y as usize * size[0] as usize + x as usize, &pixel);
        }
    }
}

/// A frame of samples.
struct Source<'a> {
    samples: &'a Frame,
    count: usize,
    /// Pixels across and down.
    size: [i32; 2],
}

impl Source<'_> {
    /// The index of a sample; `None` if its pixel is outside the picture.
    fn index(&self, [x, y]: [i32; 2], sample: usize) -> Option<usize> {
        let inside = (0..self.size[0]).contains(&x) && (0..self.size[1]).contains(&y);
        inside.then(|| (y as usize * self.size[0] as usize + x as usize) * self.count + sample)
    }

    fn pixel(&self, at: [i32; 2], taps: &[Tap], background: &Pixel, outputs: &Outputs) -> Pixel {
        let planes = &self.samples.planes;
        let first = (at[1] as usize * self.size[0] as usize + at[0] as usize) * self.count;
        let own = first..first + self.count;
        let tap_index = |tap: &Tap| self.index([at[0] + tap.pixel[0], at[1] + tap.pixel[1]], tap.sample);
        let key = match taps {
            [] => planes.keys[own.clone()].iter().copied().max(),
            _ => taps.iter().filter_map(tap_index).map(|i| planes.keys[i]).max(),
        };
        let key = key.unwrap_or(0);
        if key == 0 {
            return *background;
        }
        let mut pixel = Pixel { keys: key, ..*background };
        let needs_color = outputs.color || outputs.color16 || outputs.linear;
        if needs_color {
            let linear = match taps {
                [] => {
                    let mut colors = [[0.0; 4]; MAX_SAMPLES];
                    let colors = &mut colors[..self.count];
                    colors.copy_from_slice(&planes.linear[own.clone()]);
                    mean(colors)
                }
                _ => {
                    let inside = taps.iter().filter_map(|tap| Some((tap_index(tap)?, tap.weight)));
                    weighted_mean(inside.map(|(i, weight)| (planes.linear[i], weight)))
                }
            };
            set_colors(&mut pixel, linear, outputs);
        }
        // The first of the nearest samples.
        let nearest = own.rev().max_by_key(|&i| planes.keys[i]).filter(|&i| planes.keys[i] > 0);
        if let Some(nearest) = nearest {
            let value = |plane: &[f32]| plane.get(nearest).copied();
            pixel.depth = value(&planes.depth).unwrap_or(pixel.depth);
            pixel.ids = planes.ids.get(nearest).copied().unwrap_or(pixel.ids);
            pixel.normals = planes.normals.get(nearest).copied().unwrap_or(pixel.normals);
        }
        pixel
    }
}
