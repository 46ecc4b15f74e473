//! Samples a texture at 16 points.
//!
//! Where and how the texture is sampled is computed for 16 points at a time; texels are fetched and interpolated point by
//! point, four channels at a time.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x4, f32x16, i32x16};
use tercio_scene::texture::Level;
use tercio_scene::{Texture, TextureMap, Wrap};

use crate::conventions::MAX_ANISOTROPY;
use crate::settings::TextureFilter;
use crate::simd::{LANES, load, part, splat, splat_i};

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
pub type Colors = [[f32; LANES]; 4];

/// Where a texture is sampled: at `count` points along `axis`, in texture coordinates, in mipmap `level` and, with the
/// share `fraction`, the next one.
struct Probes<S: Simd> {
    count: [i32; LANES],
    axis: [f32x16<S>; 2],
    level: [i32; LANES],
    fraction: [f32; LANES],
}

/// Samples a texture at the points in the lanes of `lanes`. Not inlined, so that it is compiled only once per SIMD level.
#[inline(never)]
pub fn sample<S: Simd>(
    simd: S,
    texture: &Texture,
    map: &TextureMap,
    filter: TextureFilter,
    points: &TexturePoints<S>,
    lanes: u32,
    into: &mut Colors,
) {
    simd.vectorize(
        #[inline(always)]
        || sample_inline(simd, texture, map, filter, points, lanes, into),
    );
}

#[inline(always)]
fn sample_inline<S: Simd>(
    simd: S,
    texture: &Texture,
    map: &TextureMap,
    filter: TextureFilter,
    points: &TexturePoints<S>,
    lanes: u32,
    into: &mut Colors,
) {
    let scaled = |d: [f32x16<S>; 2]| [d[0] * map.scale[0], d[1] * map.scale[1]];
    let uv = scaled(points.uv);
    let uv = [uv[0] + splat(simd, map.offset[0]), uv[1] + splat(simd, map.offset[1])];
    let mut sums = [[0.0; 4]; LANES];
    let mut counts = [1.0; LANES];
    if filter == TextureFilter::Nearest {
        nearest(simd, &texture.levels()[0], map, uv, lanes, &mut sums);
    } else {
        let probes = probes(simd, texture, filter, scaled(points.right), scaled(points.down));
        let most = each_lane(lanes).map(|lane| probes.count[lane]).max().unwrap_or(0);
        counts = probes.count.map(|count| count as f32);
        let count = load(simd, &counts);
        let blends = each_lane(lanes).any(|lane| probes.fraction[lane] > 0.0);
        for i in 0..most {
            let t = splat(simd, i as f32 + 0.5) / count - splat(simd, 0.5);
            let uv = [uv[0] + probes.axis[0] * t, uv[1] + probes.axis[1] * t];
            let mut left = 0;
            each_lane(lanes).for_each(|lane| left |= u32::from(probes.count[lane] > i) << lane);
            bilinear(simd, texture, map, uv, &probes, left, blends, &mut sums);
        }
    }
    for lane in each_lane(lanes) {
        let sum = f32x4::load_array(simd, sums[lane]) / (65535.0 * counts[lane]);
        for k in 0..4 {
            into[k][lane] = sum[k];
        }
    }
}

/// The numbers of the bits that are set.
#[inline(always)]
fn each_lane(lanes: u32) -> impl Iterator<Item = usize> {
    (0..LANES).filter(move |lane| lanes >> lane & 1 == 1)
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
        return Probes { count: [1; LANES], axis: [zero; 2], level: [0; LANES], fraction: [0.0; LANES] };
    }
    let largest = &texture.levels()[0];
    let last = texture.levels().len() as i32 - 1;
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
                    axis = axis.map(
                        #[inline(always)]
                        |c| is_long.select(c, zero),
                    );
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
            Probes { count: count.to_array(), axis, level: level.to_array(), fraction: fraction.to_array() }
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
fn around<S: Simd>(simd: S, wrap: Wrap, at: f32x16<S>, size: i32x16<S>) -> ([[i32; LANES]; 2], [f32; LANES]) {
    let at = at * size.to_float::<f32x16<S>>() - splat(simd, 0.5);
    let first = at.floor();
    let number = first.to_int::<i32x16<S>>();
    let both = [index(simd, wrap, number, size), index(simd, wrap, number + 1, size)];
    (both.map(|i| i.to_array()), (at - first).to_array())
}

/// Adds what is between four texels at each point, and between two mipmaps if any point `blends`.
#[expect(clippy::too_many_arguments, reason = "one caller; a struct would only rename them")]
#[inline(always)]
fn bilinear<S: Simd>(
    simd: S,
    texture: &Texture,
    map: &TextureMap,
    [u, v]: [f32x16<S>; 2],
    probes: &Probes<S>,
    lanes: u32,
    blends: bool,
    sums: &mut [[f32; 4]; LANES],
) {
    let u = wrapped(simd, map.wrap[0], u);
    let v = splat(simd, 1.0) - wrapped(simd, map.wrap[1], v);
    let levels = texture.levels();
    let mut found = [[0.0; 4]; LANES];
    for smaller in 0..=usize::from(blends) {
        let of = probes.level.map(|level| &levels[(level as usize + smaller).min(levels.len() - 1)]);
        let [width, height] = [of.map(|level| level.width as i32), of.map(|level| level.height as i32)];
        let (columns, x) = around(simd, map.wrap[0], u, i32x16::load_array(simd, width));
        let (rows, y) = around(simd, map.wrap[1], v, i32x16::load_array(simd, height));
        for lane in each_lane(lanes) {
            let fraction = probes.fraction[lane];
            if smaller == 1 && !(fraction > 0.0) {
                continue;
            }
            let level = of[lane];
            let texel = |right: usize, down: usize| {
                texel(simd, level, columns[right][lane] as usize, rows[down][lane] as usize)
            };
            let upper = lerp(texel(0, 0), texel(1, 0), x[lane]);
            let lower = lerp(texel(0, 1), texel(1, 1), x[lane]);
            let mut color = lerp(upper, lower, y[lane]);
            if smaller == 1 {
                color = lerp(f32x4::load_array(simd, found[lane]), color, fraction);
            }
            found[lane] = color.to_array();
        }
    }
    for lane in each_lane(lanes) {
        let sum = f32x4::load_array(simd, sums[lane]) + f32x4::load_array(simd, found[lane]);
        sums[lane] = sum.to_array();
    }
}

#[inline(always)]
fn texel<S: Simd>(simd: S, level: &Level, x: usize, y: usize) -> f32x4<S> {
    let [r, g, b, a] = level.texels[y * level.width as usize + x];
    f32x4::load_array(simd, [f32::from(r), f32::from(g), f32::from(b), f32::from(a)])
}

#[inline(always)]
fn lerp<S: Simd>(a: f32x4<S>, b: f32x4<S>, t: f32) -> f32x4<S> {
    a + (b - a) * t
}

/// The nearest texel of each point.
#[inline(always)]
fn nearest<S: Simd>(
    simd: S,
    level: &Level,
    map: &TextureMap,
    [u, v]: [f32x16<S>; 2],
    lanes: u32,
    into: &mut [[f32; 4]; LANES],
) {
    let x = wrapped(simd, map.wrap[0], u) * level.width as f32;
    let y = (splat(simd, 1.0) - wrapped(simd, map.wrap[1], v)) * level.height as f32;
    let [x, y] = [x.to_int::<i32x16<S>>().to_array(), y.to_int::<i32x16<S>>().to_array()];
    for lane in each_lane(lanes) {
        let (x, y) = (
            (x[lane] as usize).min(level.width as usize - 1),
            (y[lane] as usize).min(level.height as usize - 1),
        );
        into[lane] = texel(simd, level, x, y).to_array();
    }
}
