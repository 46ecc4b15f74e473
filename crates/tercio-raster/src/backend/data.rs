//! The colours of data at 16 points: values are interpolated, then mapped.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16, mask32x16};

use super::corners::Corners;
use super::interpolate::Interpolation;
use super::light::Vec3x16;
use crate::context::FrameContext;
use crate::conventions::SUBPIXELS;
use crate::data::{LINEAR_PART, LOG2_SERIES, Mapping, Spread};
use crate::simd::{LANES, each3, load_interleaved, part, splat, splat_i};

/// The linear colour and the alpha of the data of an instance. Not inlined, so that it is compiled only once per SIMD level, and
/// kernels of pictures without data stay small.
#[inline(never)]
pub fn colors<S: Simd>(
    simd: S,
    context: &FrameContext,
    instance: usize,
    sample: [i32x16<S>; 2],
    at: &Interpolation<S>,
    corners: &Corners<S>,
) -> (Vec3x16<S>, f32x16<S>) {
    simd.vectorize(
        #[inline(always)]
        || {
            let zero = splat(simd, 0.0);
            let Some(data) = &context.data[instance] else { return ([zero; 3], splat(simd, 1.0)) };
            let mapping = &data.mapping;
            let (value, is_number) = interpolated(simd, &at.weight, &corners.values());
            let index = if mapping.categories.is_empty() {
                index(simd, mapping, value, is_number)
            } else {
                category(simd, mapping, &at.weight, &corners.values())
            };
            let [r, g, b, alpha] = entries(simd, mapping, index);
            if mapping.isolines.is_empty() {
                return ([r, g, b], alpha);
            }
            let object = &context.objects[instance];
            let gradients = at.gradients(simd, context, object, sample, corners);
            let to_pixels = context.shading_distance / SUBPIXELS as f32;
            let cover = line_cover(simd, mapping, value, gradients, corners, to_pixels);
            let cover = is_number.select(cover, zero);
            let whole = alpha + (splat(simd, 1.0) - alpha) * cover;
            let share = whole.simd_gt(zero).select(cover / whole, zero);
            let color = [r, g, b];
            (each3!(C => color[C] + (splat(simd, mapping.line[C]) - color[C]) * share), whole)
        },
    )
}

/// [`colors`] of an instance without lines of equal value, without their alpha, for values of corners with these weights.
#[inline(never)]
pub fn without_lines<S: Simd>(
    simd: S,
    context: &FrameContext,
    instance: usize,
    weight: &Vec3x16<S>,
    values: &[f32x16<S>; 3],
) -> Vec3x16<S> {
    simd.vectorize(
        #[inline(always)]
        || {
            let Some(data) = &context.data[instance] else { return [splat(simd, 0.0); 3] };
            let mapping = &data.mapping;
            let index = if mapping.categories.is_empty() {
                let (value, is_number) = interpolated(simd, weight, values);
                index(simd, mapping, value, is_number)
            } else {
                category(simd, mapping, weight, values)
            };
            let [r, g, b, _] = entries(simd, mapping, index);
            [r, g, b]
        },
    )
}

/// Entries of a mapping, by their numbers: red, green, blue, alpha.
#[inline(always)]
fn entries<S: Simd>(simd: S, mapping: &Mapping, numbers: i32x16<S>) -> [f32x16<S>; 4] {
    let numbers = numbers.to_array();
    let mut found = [[0.0; 4]; LANES];
    for lane in 0..LANES {
        if let Some(entry) = mapping.entries.get(numbers[lane] as usize) {
            found[lane] = *entry;
        }
    }
    load_interleaved(simd, &found)
}

/// The values at the points, not beyond those of the corners and exactly theirs if they have the same, and the lanes where all
/// corners have a number; others have 0.
#[inline(always)]
fn interpolated<S: Simd>(simd: S, weight: &Vec3x16<S>, values: &[f32x16<S>; 3]) -> (f32x16<S>, mask32x16<S>) {
    part(
        simd,
        #[inline(always)]
        || {
            let [a, b, c] = *values;
            let v = (a + weight[1] * (b - a)) + weight[2] * (c - a);
            let low = b.simd_lt(a).select(b, a);
            let low = c.simd_lt(low).select(c, low);
            let high = b.simd_gt(a).select(b, a);
            let high = c.simd_gt(high).select(c, high);
            let v = v.simd_lt(low).select(low, v);
            let v = v.simd_gt(high).select(high, v);
            // Infinity less infinity is not a number.
            let v = (a.simd_eq(b) & b.simd_eq(c)).select(a, v);
            let is_number = v.simd_eq(v) & (a.simd_eq(a) & (b.simd_eq(b) & c.simd_eq(c)));
            (is_number.select(v, splat(simd, 0.0)), is_number)
        },
    )
}

/// The entries of values.
#[inline(always)]
fn index<S: Simd>(simd: S, mapping: &Mapping, value: f32x16<S>, is_number: mask32x16<S>) -> i32x16<S> {
    part(
        simd,
        #[inline(always)]
        || {
            let [low, high] = [splat(simd, mapping.range[0]), splat(simd, mapping.range[1])];
            let (is_below, is_above) = (value.simd_lt(low), value.simd_gt(high));
            let v = is_above.select(high, is_below.select(low, value));
            let even = match mapping.spread {
                Spread::Linear => v,
                Spread::Log => log2(simd, v),
                Spread::SymmetricLog { threshold } => {
                    let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
                    let size = v.abs() / splat(simd, threshold);
                    let is_far = size.simd_gt(one);
                    let far = splat(simd, LINEAR_PART) + log2(simd, is_far.select(size, one));
                    let size = is_far.select(far, size * LINEAR_PART);
                    v.simd_lt(zero).select(-size, size)
                }
            };
            let position = (even - splat(simd, mapping.start)) / splat(simd, mapping.length);
            let place = position * mapping.index[0] + splat(simd, mapping.index[1]);
            let number = place.to_int::<i32x16<S>>();
            let (first, last) = (splat_i(simd, 0), splat_i(simd, mapping.last));
            let number = number.simd_lt(first).select(first, number);
            let number = number.simd_gt(last).select(last, number);
            let [nan, below, above] = mapping.special;
            let number = is_below.select(splat_i(simd, below), number);
            let number = is_above.select(splat_i(simd, above), number);
            is_number.select(number, splat_i(simd, nan))
        },
    )
}

/// [`crate::data::log2`], lane by lane.
#[inline(always)]
fn log2<S: Simd>(simd: S, x: f32x16<S>) -> f32x16<S> {
    part(
        simd,
        #[inline(always)]
        || {
            let one = splat(simd, 1.0);
            let bits = x.bitcast::<i32x16<S>>();
            let exponent = ((bits >> 23) - 127).to_float::<f32x16<S>>();
            let m = ((bits & 0x7f_ffff) | (127 << 23)).bitcast::<f32x16<S>>();
            let is_high = m.simd_gt(splat(simd, std::f32::consts::SQRT_2));
            let exponent = is_high.select(exponent + one, exponent);
            let m = is_high.select(m * 0.5, m);
            let s = (m - one) / (m + one);
            let s2 = s * s;
            let [first, third, fifth, seventh] = LOG2_SERIES;
            let sum = splat(simd, third) + s2 * (splat(simd, fifth) + s2 * seventh);
            exponent + (s * first) * (one + s2 * sum)
        },
    )
}

/// So many categories are compared with values one by one.
const FEW_CATEGORIES: usize = 32;

/// The entries of categories: those of the corners that are nearest by their weights.
#[inline(always)]
fn category<S: Simd>(
    simd: S,
    mapping: &Mapping,
    &[a, b, c]: &Vec3x16<S>,
    values: &[f32x16<S>; 3],
) -> i32x16<S> {
    let is_second = b.simd_gt(a);
    let (weight, value) = (is_second.select(b, a), is_second.select(values[1], values[0]));
    let value = c.simd_gt(weight).select(values[2], value);
    if mapping.categories.len() <= FEW_CATEGORIES {
        let mut found = splat_i(simd, mapping.special[0]);
        for (number, &category) in mapping.categories.iter().enumerate() {
            found = value.simd_eq(splat(simd, category)).select(splat_i(simd, number as i32), found);
        }
        return found;
    }
    let value = value.to_array();
    let mut found = [mapping.special[0]; LANES];
    for lane in 0..LANES {
        let number = mapping.categories.partition_point(|&category| category < value[lane]);
        if mapping.categories.get(number) == Some(&value[lane]) {
            found[lane] = number as i32;
        }
    }
    i32x16::load_array(simd, found)
}

/// How much of the points is covered by lines of equal value, as wide on the screen everywhere.
#[inline(always)]
fn line_cover<S: Simd>(
    simd: S,
    mapping: &Mapping,
    value: f32x16<S>,
    gradients: [Vec3x16<S>; 2],
    corners: &Corners<S>,
    to_pixels: f32,
) -> f32x16<S> {
    part(
        simd,
        #[inline(always)]
        || {
            let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
            let values = corners.values();
            let of: [f32x16<S>; 3] = each3!(K => values[K] - value);
            let [right, down] = gradients;
            let x = (right[0] * of[0] + right[1] * of[1]) + right[2] * of[2];
            let y = (down[0] * of[0] + down[1] * of[1]) + down[2] * of[2];
            let slope = (x * x + y * y).sqrt();
            let mut least = splat(simd, f32::INFINITY);
            for &line in &mapping.isolines {
                let distance = (value - splat(simd, line)).abs();
                least = distance.simd_lt(least).select(distance, least);
            }
            let distance = (least / slope) * to_pixels;
            let cover = splat(simd, mapping.half_width + 0.5) - distance;
            let cover = cover.simd_gt(zero).select(cover, zero);
            cover.simd_lt(one).select(cover, one) * mapping.line[3]
        },
    )
}
