//! Takes light away from a finished picture.

use fearless_simd::prelude::*;
use fearless_simd::{Level, Simd, i32x16, u8x64};
use tercio_raster::frame::Planes;
use tercio_raster::{color8_lanes, color16};

use crate::lanes::{LANES, load, load_interleaved, splat, store_interleaved};

/// The planes of colours of some rows of a picture; those of 8 and 16 bits are empty if the picture has none.
pub struct Colors<'a> {
    /// Premultiplied.
    pub linear: &'a mut [[f32; 4]],
    /// Of 8 bits.
    pub narrow: &'a mut [[u8; 4]],
    /// Of 16 bits.
    pub wide: &'a mut [[u16; 4]],
}

/// All colours of a picture of this width, in bands of so many rows, the last of which may have fewer.
///
/// # Panics
/// If the picture has no linear plane, or other planes of colours with other sizes.
pub fn bands(planes: &mut Planes, width: usize, rows: usize) -> Vec<Colors<'_>> {
    let Planes { color, color16, linear, .. } = planes;
    let pixels = linear.len();
    assert!(pixels > 0, "a linear colour for each pixel");
    assert!([color.len(), color16.len()].iter().all(|&n| n == 0 || n == pixels), "a colour for each pixel");
    let (mut narrow, mut wide) = (color.chunks_mut(width * rows), color16.chunks_mut(width * rows));
    let of_band = |linear| Colors {
        linear,
        narrow: narrow.next().unwrap_or_default(),
        wide: wide.next().unwrap_or_default(),
    };
    linear.chunks_mut(width * rows).map(of_band).collect()
}

impl Colors<'_> {
    /// Multiplies the premultiplied linear colours from index `first` on with the light that is left of each of these pixels,
    /// from 0 to 1; and makes the 8-bit and 16-bit colours anew. What keeps its light keeps its bytes.
    pub fn darken(&mut self, first: usize, light: &[f32], level: Level) {
        let range = first..first + light.len();
        let linear = &mut self.linear[range.clone()];
        let narrow = self.narrow.get_mut(range.clone()).unwrap_or_default();
        tercio_raster::dispatch!(level, simd => darken(simd, light, linear, narrow));
        let wide = self.wide.get_mut(range).unwrap_or_default();
        for ((wide, linear), _) in wide.iter_mut().zip(linear).zip(light).filter(|(_, light)| **light < 1.0) {
            *wide = color16(*linear);
        }
    }
}

#[inline(always)]
fn darken<S: Simd>(simd: S, light: &[f32], linear: &mut [[f32; 4]], narrow: &mut [[u8; 4]]) {
    let (lights, rest_of_light) = light.as_chunks::<LANES>();
    let (linears, rest_of_linear) = linear.as_chunks_mut::<LANES>();
    let (narrows, rest_of_narrow) = narrow.as_chunks_mut::<LANES>();
    let mut narrows = narrows.iter_mut();
    for (light, linear) in lights.iter().zip(linears) {
        darken_16(simd, light, linear, narrows.next());
    }
    if !rest_of_light.is_empty() {
        let (mut light, mut linear, mut narrow) = ([1.0; LANES], [[0.0; 4]; LANES], [[0; 4]; LANES]);
        let count = rest_of_light.len();
        light[..count].copy_from_slice(rest_of_light);
        linear[..count].copy_from_slice(rest_of_linear);
        narrow[..rest_of_narrow.len()].copy_from_slice(rest_of_narrow);
        darken_16(simd, &light, &mut linear, Some(&mut narrow));
        rest_of_linear.copy_from_slice(&linear[..count]);
        rest_of_narrow.copy_from_slice(&narrow[..rest_of_narrow.len()]);
    }
}

#[inline(always)]
fn darken_16<S: Simd>(
    simd: S,
    light: &[f32; LANES],
    linear: &mut [[f32; 4]; LANES],
    narrow: Option<&mut [[u8; 4]; LANES]>,
) {
    let light = load(simd, light);
    let loses = light.simd_lt(splat(simd, 1.0));
    // Most of a picture is background, or not occluded.
    if loses.all_false() {
        return;
    }
    let light = loses.select(light, splat(simd, 1.0));
    let [r, g, b, alpha] = load_interleaved(simd, linear);
    let darkened = [r * light, g * light, b * light, alpha];
    store_interleaved(darkened, linear);
    if let Some(narrow) = narrow {
        let bytes = narrow.as_flattened_mut();
        let before: i32x16<S> = u8x64::from_slice(simd, bytes).bitcast();
        let after: u8x64<S> = loses.select(color8_lanes(simd, darkened), before).bitcast();
        after.store_slice(bytes);
    }
}

#[cfg(test)]
mod tests {
    use tercio_raster::{SimdLevel, color8};

    use super::*;

    /// Every level of 8 bits of `color8` depends on the upper 20 bits of a number alone: all of them, at both ends.
    #[test]
    fn colors_of_all_numbers_are_those_of_single_pixels() {
        let ends = |upper: u32| [upper << 12, upper << 12 | 0xfff].map(f32::from_bits);
        let numbers: Vec<f32> = (0..1 << 20).flat_map(ends).collect();
        // Half of the light keeps every bit of a number; the last pixels are the rest of a row.
        let before: Vec<_> =
            numbers.chunks(3).map(|c| [2.0 * c[0], 2.0 * c[c.len() / 2], 0.5, 1.0]).collect();
        let (count, light) = (before.len(), vec![0.5; before.len()]);
        assert!(!count.is_multiple_of(LANES));
        for level in SimdLevel::available() {
            let mut planes =
                Planes { linear: before.clone(), color: vec![[1; 4]; count], ..Planes::default() };
            bands(&mut planes, count, 1)[0].darken(0, &light, level.level().expect("available"));
            for (index, [r, g, b, a]) in before.iter().enumerate() {
                let expected = [r * 0.5, g * 0.5, b * 0.5, *a];
                assert_eq!(planes.color[index], color8(expected), "{level}: {expected:?}");
            }
        }
    }

    #[test]
    fn all_planes_are_darkened_and_what_keeps_its_light_keeps_its_bytes() {
        let (width, rows) = (37, 3);
        let number = |index: usize| (index * 29 % 101) as f32 / 101.0;
        let linear: Vec<_> =
            (0..width * rows).map(|i| [number(i), number(i + 1), 2.0, number(i + 2)]).collect();
        let light: Vec<_> = (0..width * rows).map(|i| (number(7 * i) * 2.0).min(1.0)).collect();
        let pixels = width * rows;
        for level in SimdLevel::available() {
            let level = level.level().expect("available");
            let mut planes = Planes {
                linear: linear.clone(),
                color: vec![[7; 4]; pixels],
                color16: vec![[9; 4]; pixels],
                ..Planes::default()
            };
            for (band, mut colors) in bands(&mut planes, width, 2).into_iter().enumerate() {
                let light = &light[band * 2 * width..];
                light.chunks(width).take(2).enumerate().for_each(|(y, light)| {
                    if y * width < colors.linear.len() {
                        colors.darken(y * width, light, level);
                    }
                });
            }
            for i in 0..pixels {
                let [r, g, b, a] = linear[i];
                let darkened = [r * light[i], g * light[i], b * light[i], a];
                assert_eq!(planes.linear[i], darkened);
                let is_darker = light[i] < 1.0;
                assert_eq!(planes.color[i], if is_darker { color8(darkened) } else { [7; 4] });
                assert_eq!(planes.color16[i], if is_darker { color16(darkened) } else { [9; 4] });
            }
        }
    }
}
