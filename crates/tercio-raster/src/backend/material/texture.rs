//! Samples a texture at 16 points at a time.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16, mask32x16};
use tercio_scene::texture::MAX_LEVELS;
use tercio_scene::{Texture, TextureMap, Wrap};

use crate::conventions::MAX_ANISOTROPY;
use crate::settings::TextureFilter;
use crate::simd::{lookup_16, lookup_fours, part, splat, splat_i};

/// Points on surfaces in texture coordinates, v upwards, and how these change from pixel to pixel.
#[derive(Clone, Copy)]
pub struct TexturePoints<S: Simd> {
    /// The coordinates.
    pub uv: [f32x16<S>; 2],
    /// Their change by one pixel to the right.
    pub right: [f32x16<S>; 2],
    /// Their change by one pixel downwards.
    pub down: [f32x16<S>; 2],
}

/// Colours of 16 points by channel, premultiplied if they are colours; 0 to 1.
pub type Colors<S> = [f32x16<S>; 4];

/// Where a texture is sampled: at `count` points along `axis`, in texture coordinates, in mipmap `level` and, with the
/// share `fraction`, the next one.
struct Probes<S: Simd> {
    count: i32x16<S>,
    axis: [f32x16<S>; 2],
    level: i32x16<S>,
    fraction: f32x16<S>,
}

/// Samples a texture at the points in the lanes of `lanes`; the others are undefined. Not inlined, so that it is compiled only
/// once per SIMD level.
#[inline(never)]
pub fn sample<S: Simd>(
    simd: S,
    texture: &Texture,
    map: &TextureMap,
    filter: TextureFilter,
    points: &TexturePoints<S>,
    lanes: u32,
) -> Colors<S> {
    simd.vectorize(
        #[inline(always)]
        || sample_inline(simd, texture, map, filter, points, lanes),
    )
}

#[inline(always)]
fn sample_inline<S: Simd>(
    simd: S,
    texture: &Texture,
    map: &TextureMap,
    filter: TextureFilter,
    points: &TexturePoints<S>,
    lanes: u32,
) -> Colors<S> {
    let uv = scaled(map, points.uv);
    let uv = [uv[0] + splat(simd, map.offset[0]), uv[1] + splat(simd, map.offset[1])];
    if filter == TextureFilter::Nearest {
        return over(nearest(simd, texture, map, uv), splat(simd, 65535.0));
    }
    let probes = probes(simd, texture, filter, scaled(map, points.right), scaled(map, points.down));
    let count: f32x16<S> = probes.count.to_float();
    let mut sums = [splat(simd, 0.0); 4];
    let (mut number, mut left) = (0, lanes);
    while left != 0 {
        let t = splat(simd, number as f32 + 0.5) / count - splat(simd, 0.5);
        let uv = [uv[0] + probes.axis[0] * t, uv[1] + probes.axis[1] * t];
        let found = bilinear(simd, texture, map, uv, &probes, left);
        let is_left = mask32x16::from_bitmask(simd, u64::from(left));
        for (sum, found) in sums.iter_mut().zip(found) {
            *sum = is_left.select(*sum + found, *sum);
        }
        number += 1;
        left &= probes.count.simd_gt(splat_i(simd, number)).to_bitmask() as u32;
    }
    over(sums, count * 65535.0)
}

/// All channels divided. Written out, because `map` of arrays would not be compiled at the kernel's SIMD level.
#[inline(always)]
fn over<S: Simd>([r, g, b, a]: [f32x16<S>; 4], by: f32x16<S>) -> [f32x16<S>; 4] {
    [r / by, g / by, b / by, a / by]
}

#[inline(always)]
fn scaled<S: Simd>(map: &TextureMap, d: [f32x16<S>; 2]) -> [f32x16<S>; 2] {
    [d[0] * map.scale[0], d[1] * map.scale[1]]
}

/// The ellipse that a pixel covers has the axes of the matrix of derivatives, as `major` and `minor`.
#[inline(always)]
fn probes<S: Simd>(
    simd: S,
    texture: &Texture,
    filter: TextureFilter,
    right: [f32x16<S>; 2],
    down: [f32x16<S>; 2],
) -> Probes<S> {
    let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
    if filter == TextureFilter::Bilinear {
        return Probes { count: splat_i(simd, 1), axis: [zero; 2], level: splat_i(simd, 0), fraction: zero };
    }
    let largest = texture.level(0);
    let last = texture.level_count() as i32 - 1;
    let size = [largest.width as f32, largest.height as f32];
    part(
        simd,
        #[inline(always)]
        || {
            // In texels.
            let a = [right[0] * size[0], right[1] * size[1]];
            let b = [down[0] * size[0], down[1] * size[1]];
            let e = a[0] * a[0] + b[0] * b[0];
            let f = a[0] * a[1] + b[0] * b[1];
            let g = a[1] * a[1] + b[1] * b[1];
            let half = (e - g) * 0.5;
            let square = (e + g) * 0.5 + (half * half + f * f).sqrt();
            let is_finite = square.simd_lt(splat(simd, 1e30));
            // What is not finite continues as 1, so that all numbers are in range.
            let square = is_finite.select(square, one);
            let major = square.sqrt();
            let is_minified = major.simd_gt(one);
            let (mut count, mut width) = (splat_i(simd, 1), major);
            let mut axis = [zero; 2];
            if filter == TextureFilter::Anisotropic {
                let minor = (a[0] * b[1] - a[1] * b[0]).abs() / major;
                let ratio = major / minor.simd_gt(one).select(minor, one);
                // Never more than the limit, which makes the conversion exact.
                let most = splat(simd, MAX_ANISOTROPY as f32);
                let rounded = ratio + splat(simd, 0.5);
                let rounded = rounded.simd_lt(most).select(rounded, most).to_int::<i32x16<S>>();
                let is_long = rounded.simd_gt(splat_i(simd, 1)) & is_minified;
                count = is_long.select(rounded, count);
                width = major / count.to_float::<f32x16<S>>();
                if is_long.any_true() {
                    let is_wide = e.simd_ge(g);
                    let x = is_wide.select(square - g, f);
                    let y = is_wide.select(f, square - e);
                    let unit = major / (x * x + y * y).sqrt();
                    axis = [x * unit / splat(simd, size[0]), y * unit / splat(simd, size[1])];
                    axis = [is_long.select(axis[0], zero), is_long.select(axis[1], zero)];
                }
            }
            // log2 of the width, linear between powers of two.
            let bits = width.bitcast::<i32x16<S>>();
            let exponent = (bits >> 23) - 127;
            let mantissa = ((bits & 0x7f_ffff) | (127 << 23)).bitcast::<f32x16<S>>() - one;
            let has_mipmaps = width.simd_gt(one) & is_minified;
            let mut level = has_mipmaps.select(exponent, splat_i(simd, 0));
            let mut fraction = has_mipmaps.select(mantissa, zero);
            let is_last = level.simd_ge(splat_i(simd, last)) | !is_finite;
            level = is_last.select(splat_i(simd, last), level);
            fraction = is_last.select(zero, fraction);
            Probes { count, axis, level, fraction }
        },
    )
}

/// Texture coordinates along one axis, brought into the range from 0 to 1.
#[inline(always)]
fn wrapped<S: Simd>(simd: S, wrap: Wrap, c: f32x16<S>) -> f32x16<S> {
    let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
    let c = c.abs().simd_lt(splat(simd, f32::INFINITY)).select(c, zero);
    match wrap {
        Wrap::Repeat => c - c.floor(),
        Wrap::Mirror => {
            let c = c - (c * 0.5).floor() * 2.0;
            c.simd_gt(one).select(splat(simd, 2.0) - c, c)
        }
        Wrap::Clamp => {
            let c = c.simd_gt(zero).select(c, zero);
            c.simd_lt(one).select(c, one)
        }
    }
}

/// Indices of texels along an axis that may be one outside the picture.
#[inline(always)]
fn index<S: Simd>(simd: S, wrap: Wrap, i: i32x16<S>, size: i32x16<S>) -> i32x16<S> {
    let (zero, last) = (splat_i(simd, 0), size - 1);
    let (is_before, is_after) = (i.simd_lt(zero), i.simd_gt(last));
    match wrap {
        Wrap::Repeat => is_before.select(i + size, is_after.select(i - size, i)),
        Wrap::Mirror | Wrap::Clamp => is_before.select(zero, is_after.select(last, i)),
    }
}

/// The texels around 16 points along one axis, the first of which is at or before the point, and the share of the second.
#[inline(always)]
fn around<S: Simd>(simd: S, wrap: Wrap, at: f32x16<S>, size: i32x16<S>) -> ([i32x16<S>; 2], f32x16<S>) {
    let at = at * size.to_float::<f32x16<S>>() - splat(simd, 0.5);
    let first = at.floor();
    let number = first.to_int::<i32x16<S>>();
    ([index(simd, wrap, number, size), index(simd, wrap, number + 1, size)], at - first)
}

/// What is between four texels at 16 points, and between two mipmaps; 0 to 65535.
#[inline(always)]
fn bilinear<S: Simd>(
    simd: S,
    texture: &Texture,
    map: &TextureMap,
    [u, v]: [f32x16<S>; 2],
    probes: &Probes<S>,
    lanes: u32,
) -> [f32x16<S>; 4] {
    let u = wrapped(simd, map.wrap[0], u);
    let v = splat(simd, 1.0) - wrapped(simd, map.wrap[1], v);
    let found = between_texels(simd, texture, map, [u, v], probes.level);
    let blends = probes.fraction.simd_gt(splat(simd, 0.0));
    if blends.to_bitmask() as u32 & lanes == 0 {
        return found;
    }
    let next = (probes.level + 1).min(splat_i(simd, MAX_LEVELS as i32 - 1));
    let smaller = between_texels(simd, texture, map, [u, v], next);
    let mut blended = found;
    for (blended, (found, smaller)) in blended.iter_mut().zip(found.into_iter().zip(smaller)) {
        *blended = blends.select(lerp(found, smaller, probes.fraction), found);
    }
    blended
}

/// What is between four texels of a mipmap at 16 points, in coordinates from 0 to 1, v downwards. Not inlined, because it is
/// long and called twice.
#[inline(never)]
fn between_texels<S: Simd>(
    simd: S,
    texture: &Texture,
    map: &TextureMap,
    [u, v]: [f32x16<S>; 2],
    level: i32x16<S>,
) -> [f32x16<S>; 4] {
    simd.vectorize(
        #[inline(always)]
        || {
            let table = texture.table();
            let width = lookup_16(simd, i32x16::load_array_ref(simd, &table.width), level);
            let height = lookup_16(simd, i32x16::load_array_ref(simd, &table.height), level);
            let first = lookup_16(simd, i32x16::load_array_ref(simd, &table.first), level);
            let ([left, right], x) = around(simd, map.wrap[0], u, width);
            let ([top, bottom], y) = around(simd, map.wrap[1], v, height);
            let [top, bottom] = [top * width + first, bottom * width + first];
            let all = texture.texels();
            let upper = [texels(simd, all, top + left), texels(simd, all, top + right)];
            let lower = [texels(simd, all, bottom + left), texels(simd, all, bottom + right)];
            let mut found = upper[0];
            for (k, found) in found.iter_mut().enumerate() {
                let upper = lerp(upper[0][k], upper[1][k], x);
                let lower = lerp(lower[0][k], lower[1][k], x);
                *found = lerp(upper, lower, y);
            }
            found
        },
    )
}

/// The texels with 16 numbers, by channel; 0 to 65535.
#[inline(always)]
fn texels<S: Simd>(simd: S, texels: &[[u16; 4]], numbers: i32x16<S>) -> [f32x16<S>; 4] {
    let [low, high] = lookup_fours(simd, texels, numbers);
    part(
        simd,
        #[inline(always)]
        || {
            let sixteen_bits = splat_i(simd, 0xffff);
            let [r, g] = [low & sixteen_bits, (low >> 16) & sixteen_bits];
            let [b, a] = [high & sixteen_bits, (high >> 16) & sixteen_bits];
            [r.to_float(), g.to_float(), b.to_float(), a.to_float()]
        },
    )
}

#[inline(always)]
fn lerp<S: Simd>(a: f32x16<S>, b: f32x16<S>, t: f32x16<S>) -> f32x16<S> {
    a + (b - a) * t
}

/// The nearest texel of each point; 0 to 65535.
#[inline(always)]
fn nearest<S: Simd>(simd: S, texture: &Texture, map: &TextureMap, [u, v]: [f32x16<S>; 2]) -> [f32x16<S>; 4] {
    let level = texture.level(0);
    let [width, height] = [level.width as i32, level.height as i32];
    let x = wrapped(simd, map.wrap[0], u) * width as f32;
    let y = (splat(simd, 1.0) - wrapped(simd, map.wrap[1], v)) * height as f32;
    let x = x.to_int::<i32x16<S>>().min(splat_i(simd, width - 1));
    let y = y.to_int::<i32x16<S>>().min(splat_i(simd, height - 1));
    texels(simd, level.texels, y * width + x)
}
