//! Where the shading kernel writes to: the pixels of the picture, or fragments that become pixels later.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16};

use super::features::Features;
use super::kernel::At;
use crate::backend::corners::Fragments;
use crate::backend::encode::opaque;
use crate::backend::light::Vec3x16;
use crate::color::encode16;
use crate::context::FrameContext;
use crate::frame::{Outputs, Planes};
use crate::simd::{LANES, each3, splat, store_interleaved};

/// Where shaded pixels are written to.
pub trait Target {
    /// Coordinates of the points that are shaded.
    fn samples<S: Simd>(simd: S, at: &At, fragments: &Fragments) -> [i32x16<S>; 2];

    /// Writes 16 shaded pixels: their linear colour, the alpha of the mesh's colours, and their normal.
    #[expect(clippy::too_many_arguments, reason = "one call site; a struct would only rename them")]
    fn write<S: Simd, F: Features>(
        &mut self,
        simd: S,
        context: &FrameContext,
        features: F,
        fragments: &Fragments,
        linear: Vec3x16<S>,
        alpha: f32x16<S>,
        normal: Vec3x16<S>,
    );
}

/// The pixels of a tile with one sample per pixel.
pub struct PixelTarget<'a> {
    /// The planes of the tile.
    pub pixels: &'a mut Planes,
    /// Those that are requested.
    pub outputs: &'a Outputs,
}

impl Target for PixelTarget<'_> {
    #[inline(always)]
    fn samples<S: Simd>(simd: S, at: &At, fragments: &Fragments) -> [i32x16<S>; 2] {
        at.middles(simd, &fragments.place)
    }

    #[inline(always)]
    fn write<S: Simd, F: Features>(
        &mut self,
        simd: S,
        context: &FrameContext,
        features: F,
        fragments: &Fragments,
        linear: Vec3x16<S>,
        _: f32x16<S>,
        normal: Vec3x16<S>,
    ) {
        let Self { pixels, outputs } = self;
        if features.color() {
            write_color(simd, fragments, linear, pixels);
        }
        if features.more() {
            write_linear(simd, fragments, linear, pixels, outputs);
            write_geometry(context, fragments, normal, pixels, outputs);
        }
    }
}

/// Shaded fragments of pixels with several samples.
pub struct FragmentTarget<'a> {
    /// Premultiplied linear colours.
    pub colors: &'a mut [[f32; 4]; LANES],
    /// Normals, likewise; empty if they are not requested.
    pub normals: &'a mut [[f32; 3]],
    /// Opacity of the surface.
    pub opacity: f32,
}

impl Target for FragmentTarget<'_> {
    #[inline(always)]
    fn samples<S: Simd>(simd: S, at: &At, fragments: &Fragments) -> [i32x16<S>; 2] {
        let [x, y] = at.middles(simd, &fragments.place);
        let [right, down] = &fragments.from_middle;
        [x + i32x16::load_array_ref(simd, right), y + i32x16::load_array_ref(simd, down)]
    }

    #[inline(always)]
    fn write<S: Simd, F: Features>(
        &mut self,
        simd: S,
        _: &FrameContext,
        features: F,
        _: &Fragments,
        linear: Vec3x16<S>,
        alpha: f32x16<S>,
        normal: Vec3x16<S>,
    ) {
        let mut linear = displayable(simd, linear);
        let mut opacity = splat(simd, 1.0);
        if features.alpha() || self.opacity < 1.0 {
            opacity = alpha * self.opacity;
            linear = each3!(C => linear[C] * opacity);
        }
        let [r, g, b] = linear;
        store_interleaved([r, g, b, opacity], self.colors);
        if !self.normals.is_empty() {
            let normal = each3!(A => normal[A].to_array());
            for (lane, to) in self.normals.iter_mut().enumerate().take(LANES) {
                *to = [normal[0][lane], normal[1][lane], normal[2][lane]];
            }
        }
    }
}

/// Linear light as a display shows it: clamped to the range from 0 to 1, NaN as 0. Samples are clamped before they are
/// averaged, so that the edges of surfaces that are too bright are smooth, too.
#[inline(always)]
pub fn displayable<S: Simd>(simd: S, linear: Vec3x16<S>) -> Vec3x16<S> {
    let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
    each3!(C => {
        let above = linear[C].simd_gt(zero).select(linear[C], zero);
        above.simd_lt(one).select(above, one)
    })
}

/// [`displayable`] of one value.
pub fn displayable_of(linear: f32) -> f32 {
    let above = if linear > 0.0 { linear } else { 0.0 };
    if above < 1.0 { above } else { 1.0 }
}

#[inline(always)]
fn write_color<S: Simd>(simd: S, fragments: &Fragments, linear: Vec3x16<S>, pixels: &mut Planes) {
    let levels = opaque(simd, linear).to_array();
    if fragments.is_block {
        for (row, level) in levels.as_chunks::<4>().0.iter().enumerate() {
            let place = fragments.place[4 * row] as usize;
            pixels.color[place..place + 4].copy_from_slice(&level.map(|level| (level as u32).to_le_bytes()));
        }
        return;
    }
    // Unused lanes repeat a pixel: they write the same value again.
    for lane in 0..LANES {
        pixels.color[fragments.place[lane] as usize] = (levels[lane] as u32).to_le_bytes();
    }
}

fn write_linear<S: Simd>(
    simd: S,
    fragments: &Fragments,
    linear: Vec3x16<S>,
    pixels: &mut Planes,
    outputs: &Outputs,
) {
    if outputs.color16 {
        for lane in 0..fragments.count {
            let [r, g, b] = each3!(C => encode16(linear[C][lane]));
            pixels.color16[fragments.place[lane] as usize] = [r, g, b, 65535];
        }
    }
    if outputs.linear {
        let shown = displayable(simd, linear);
        let shown = each3!(C => shown[C].to_array());
        for lane in 0..fragments.count {
            let [r, g, b] = each3!(C => shown[C][lane]);
            pixels.linear[fragments.place[lane] as usize] = [r, g, b, 1.0];
        }
    }
}

#[inline(always)]
fn write_geometry<S: Simd>(
    context: &FrameContext,
    fragments: &Fragments,
    normal: Vec3x16<S>,
    pixels: &mut Planes,
    outputs: &Outputs,
) {
    let lanes = 0..fragments.count;
    if outputs.depth {
        for lane in lanes.clone() {
            pixels.depth[fragments.place[lane] as usize] = context.view.distance(fragments.depth[lane]);
        }
    }
    if outputs.ids {
        for lane in lanes.clone() {
            pixels.ids[fragments.place[lane] as usize] = context.face(fragments.slot[lane]);
        }
    }
    if outputs.normals {
        let normal = each3!(A => normal[A].to_array());
        for lane in lanes {
            pixels.normals[fragments.place[lane] as usize] = [0, 1, 2].map(|k| normal[k][lane]);
        }
    }
}
