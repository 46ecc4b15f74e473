//! Every second pixel of every second row of a frame's depths.

use fearless_simd::prelude::*;
use fearless_simd::{Level, Simd, dispatch, f32x4, i32x16};
use rayon::prelude::*;

use super::pattern::{MAX_RADIUS, PATTERN};
use crate::lanes::{LANES, Lanes, Vec3, load, load_interleaved, load_part, splat};
use crate::surface::Surface;

/// Coarse pixels along the edge of a block.
pub const BLOCK: usize = LANES;
/// Coarse pixels beside the picture, on each side, in which nothing is visible.
pub const MARGIN: usize = 2;
/// Coarse pixels of which a row of the planes is a multiple, without the margins.
const GROUP: usize = 4 * LANES;

/// Coarse pixels: pixels (2x, 2y) of the picture.
pub struct Coarse {
    /// Pixels across and down.
    pub size: [usize; 2],
    /// Length of a row, with margins.
    pub stride: usize,
    /// Depths, in the surface's unit of length; infinite where nothing is visible.
    pub depth: Vec<f32>,
    /// Normals in the camera's axes as [`packed`], so that those of a frame, which lie far apart, are fetched once.
    pub normals: Vec<i32>,
    /// The least depth.
    pub nearest: f32,
}

impl Coarse {
    /// Takes them from a frame's depths, and normals in world space.
    pub fn new(surface: &Surface, depth: &[f32], normals: &[[f32; 3]], level: Level) -> Self {
        let size = [surface.width.div_ceil(2), surface.height.div_ceil(2)];
        let stride = size[0].next_multiple_of(GROUP) + 2 * MARGIN;
        let length = stride * (size[1].next_multiple_of(BLOCK) + 2 * MARGIN);
        let (mut depths, mut packed) = (vec![f32::INFINITY; length], vec![0; length]);
        let rows = depths.par_chunks_mut(stride).zip(packed.par_chunks_mut(stride)).skip(MARGIN);
        let from = depth.par_chunks(2 * surface.width).zip(normals.par_chunks(2 * surface.width));
        let nearest = rows.zip(from).with_min_len(BLOCK).map(|((depths, packed), (depth, normals))| {
            let depths = depths[MARGIN..].as_chunks_mut::<LANES>().0;
            let packed = packed[MARGIN..].as_chunks_mut::<LANES>().0;
            let (depth, normals) = (&depth[..surface.width], &normals[..surface.width]);
            dispatch!(level, simd => even(simd, surface, (depth, normals), (depths, packed)))
        });
        let nearest = nearest.reduce(|| f32::INFINITY, f32::min);
        Self { size, stride, depth: depths, normals: packed, nearest }
    }

    /// The index of a coarse pixel, which may be in the margin if numbered from there.
    pub fn index(&self, x: usize, y: usize) -> usize {
        (y + MARGIN) * self.stride + MARGIN + x
    }
}

/// Every second depth and normal of a row; returns the least depth.
#[inline(always)]
fn even<S: Simd>(
    simd: S,
    surface: &Surface,
    (depth, normals): (&[f32], &[[f32; 3]]),
    (depths, to): (&mut [[f32; LANES]], &mut [[i32; LANES]]),
) -> f32 {
    let infinite = splat(simd, f32::INFINITY);
    let mut least = infinite;
    for (number, first) in (0..depth.len()).step_by(2 * LANES).enumerate() {
        let low = load_part(simd, depth, first, f32::INFINITY);
        let found = low.unzip_low(load_part(simd, depth, first + LANES, f32::INFINITY)) * surface.per_world;
        if found.simd_lt(infinite).all_false() {
            continue;
        }
        least = found.simd_lt(least).select(found, least);
        found.store_array(&mut depths[number]);
        let mut all = [[0.0; LANES]; 3];
        for lane in 0..LANES {
            let normal = &normals[(first + 2 * lane).min(normals.len() - 1)];
            (0..3).for_each(|k| all[k][lane] = normal[k]);
        }
        let normal = surface.to_camera([load(simd, &all[0]), load(simd, &all[1]), load(simd, &all[2])]);
        packed(normal).store_array(&mut to[number]);
    }
    least.to_array().into_iter().fold(f32::INFINITY, f32::min)
}

/// Steps of a packed component from 0 to 1.
const STEPS: f32 = 511.0;

/// Unit vectors with 10 bits for each component: off by a thousandth.
#[inline(always)]
fn packed<S: Simd>(v: Vec3<S>) -> i32x16<S> {
    let [x, y, z] = [rounded(v[0]), rounded(v[1]), rounded(v[2])];
    (x | (y << 10)) | (z << 20)
}

#[inline(always)]
fn rounded<S: Simd>(v: Lanes<S>) -> i32x16<S> {
    let steps: i32x16<S> = (v * STEPS + (STEPS + 1.5)).to_int();
    steps & 1023
}

/// The reverse of [`packed`].
#[inline(always)]
pub fn unpacked<S: Simd>(packed: i32x16<S>) -> Vec3<S> {
    [component(packed & 1023), component((packed >> 10) & 1023), component(packed >> 20)]
}

#[inline(always)]
fn component<S: Simd>(steps: i32x16<S>) -> Lanes<S> {
    let steps: Lanes<S> = steps.to_float();
    (steps - (STEPS + 1.0)) * (1.0 / STEPS)
}

/// The same depths, apart by the columns of the pattern: whoever looks at the same distance from each fourth pixel finds
/// what it sees side by side.
pub struct Interleaved {
    /// Rows of the picture, each as one row for each column of the pattern.
    depth: Vec<f32>,
    /// Coarse pixels beyond the picture, on each side: as far as anything is looked at.
    margin: usize,
    /// Length of the rows.
    stride: usize,
}

impl Interleaved {
    /// Arranges depths anew. What is farther away than the radius of the nearest pixel is never looked at.
    pub fn new(coarse: &Coarse, surface: &Surface, level: Level) -> Self {
        let scale = surface.scale;
        let radius = if surface.perspective { scale / coarse.nearest } else { scale };
        let reach = (radius.min(MAX_RADIUS) * 0.5) as usize + 2;
        let margin = reach.next_multiple_of(PATTERN);
        let [across, down] = [coarse.stride - 2 * MARGIN, coarse.size[1].next_multiple_of(BLOCK)];
        let stride = (across + 2 * margin) / PATTERN;
        let mut depth = vec![f32::INFINITY; PATTERN * stride * (down + 2 * margin)];
        let from = coarse.depth.par_chunks(coarse.stride).skip(MARGIN);
        let rows = depth.par_chunks_mut(PATTERN * stride).skip(margin).zip(from).take(coarse.size[1]);
        rows.with_min_len(BLOCK).for_each(|(to, from)| {
            let from = &from[MARGIN..MARGIN + across];
            dispatch!(level, simd => take_apart(simd, from, to, stride, margin / PATTERN));
        });
        Self { depth, margin, stride }
    }

    /// The index of a coarse pixel.
    pub fn index(&self, x: usize, y: usize) -> usize {
        let [x, y] = [x, y].map(|at| at + self.margin);
        y * PATTERN * self.stride + x % PATTERN * self.stride + x / PATTERN
    }

    /// How far apart in the plane are the pixels of the pattern's columns, by lane, and others that are so many coarse pixels
    /// to the right and below.
    #[inline(always)]
    pub fn offsets<S: Simd>(&self, simd: S, right: i32x16<S>, below: i32x16<S>) -> i32x16<S> {
        let stride = self.stride as i32;
        let own = i32x16::load_array(simd, COLUMNS);
        // Rounded down, also if negative.
        let x = own + right;
        let column = (x & (PATTERN as i32 - 1)) - own;
        (below * PATTERN as i32 + column) * stride + (x >> PATTERN.ilog2())
    }

    /// The depths of 4 x 4 pixels of a block, each [`PATTERN`] pixels from the next, row by row.
    #[inline(always)]
    pub fn load<S: Simd>(&self, simd: S, first: usize) -> Lanes<S> {
        let step = PATTERN * PATTERN * self.stride;
        let from = &self.depth[first..first + 3 * step + PATTERN];
        let upper = four(simd, from, 0).combine(four(simd, from, step));
        upper.combine(four(simd, from, 2 * step).combine(four(simd, from, 3 * step)))
    }
}

/// The column of the pattern of each lane.
const COLUMNS: [i32; LANES] = [0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3];

#[inline(always)]
fn four<S: Simd>(simd: S, from: &[f32], first: usize) -> f32x4<S> {
    f32x4::from_slice(simd, &from[first..first + PATTERN])
}

#[inline(always)]
fn take_apart<S: Simd>(simd: S, from: &[f32], to: &mut [f32], stride: usize, margin: usize) {
    let (groups, _) = from.as_chunks::<PATTERN>().0.as_chunks::<LANES>();
    for (number, group) in groups.iter().enumerate() {
        for (column, cells) in load_interleaved(simd, group).into_iter().enumerate() {
            let first = column * stride + margin + number * LANES;
            cells.store_slice(&mut to[first..first + LANES]);
        }
    }
}
