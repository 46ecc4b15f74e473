//! Every second pixel of every second row of a frame's depths.

use fearless_simd::prelude::*;
use fearless_simd::{Level, Simd, f32x4, i32x16};
use rayon::prelude::*;

use super::pattern::{MAX_RADIUS, PATTERN};
use crate::lanes::{LANES, Lanes, Vec3, clamp, load, load_interleaved, load_part, splat};
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
            tercio_raster::dispatch!(level, simd => even(simd, surface, (depth, normals), (depths, packed)))
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
        packed(simd, normal).store_array(&mut to[number]);
    }
    least.to_array().into_iter().fold(f32::INFINITY, f32::min)
}

/// Steps of a packed component from 0 to 1.
const STEPS: f32 = 511.0;

/// Unit vectors with 10 bits for each component: off by a thousandth.
#[inline(always)]
fn packed<S: Simd>(simd: S, v: Vec3<S>) -> i32x16<S> {
    let [x, y, z] = [rounded(simd, v[0]), rounded(simd, v[1]), rounded(simd, v[2])];
    (x | (y << 10)) | (z << 20)
}

#[inline(always)]
fn rounded<S: Simd>(simd: S, v: Lanes<S>) -> i32x16<S> {
    (clamp(simd, v * STEPS, -STEPS, STEPS) + (STEPS + 1.5)).to_int()
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
            tercio_raster::dispatch!(level, simd => take_apart(simd, from, to, stride, margin / PATTERN));
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

#[cfg(test)]
mod tests {
    use tercio_raster::SimdLevel;

    use super::*;

    #[test]
    fn packed_normals_are_off_by_a_thousandth_at_most() {
        for level in SimdLevel::available() {
            let level = level.level().expect("available");
            for k in 0..200 {
                let at = |lane: usize| -1.0 + (k * LANES + lane) as f32 / (100 * LANES) as f32;
                let v: [[f32; LANES]; 3] = [
                    std::array::from_fn(at),
                    std::array::from_fn(|lane| -at(lane)),
                    std::array::from_fn(|lane| [0.0, 1.0, -1.0][lane % 3]),
                ];
                let found = tercio_raster::dispatch!(level, simd => {
                    let [x, y, z] = unpacked(packed(simd, [load(simd, &v[0]), load(simd, &v[1]), load(simd, &v[2])]));
                    [x.to_array(), y.to_array(), z.to_array()]
                });
                for lane in 0..LANES {
                    assert!((0..3).all(|k| (found[k][lane] - v[k][lane]).abs() < 1e-3), "{lane}: {v:?}");
                    assert!(v[2][lane] != 0.0 || found[2][lane] == 0.0);
                }
            }
        }
    }

    /// The depth of a coarse pixel is where its index says, and what another pixel sees there where the offsets say.
    #[test]
    fn interleaved_pixels_are_found_by_index_and_by_offset() {
        let (width, height) = (75, 41);
        let surface = Surface {
            width,
            height,
            perspective: false,
            scale: 30.0,
            middle: [0.0; 2],
            axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            per_world: 1.0,
        };
        let depth: Vec<_> = (0..width * height).map(|i| 1.0 + i as f32).collect();
        for level in SimdLevel::available() {
            let level = level.level().expect("available");
            let coarse = Coarse::new(&surface, &depth, &vec![[0.0, 0.0, 1.0]; depth.len()], level);
            let interleaved = Interleaved::new(&coarse, &surface, level);
            assert_eq!((coarse.size, coarse.nearest), ([38, 21], 1.0));
            for (x, y) in (0..38).flat_map(|x| (0..21).map(move |y| (x, y))) {
                let expected = depth[2 * y * width + 2 * x];
                assert_eq!(coarse.depth[coarse.index(x, y)], expected);
                assert_eq!(interleaved.depth[interleaved.index(x, y)], expected);
            }
            for (right, below) in (-15..=15).flat_map(|x| (-15..=15).map(move |y| (x, y))) {
                let offsets = tercio_raster::dispatch!(level, simd => {
                    let [right, below] = [i32x16::splat(simd, right), i32x16::splat(simd, below)];
                    interleaved.offsets(simd, right, below).to_array()
                });
                for column in 0..PATTERN {
                    let (x, y) = (20 + column, 16);
                    let seen = interleaved.index(x, y).wrapping_add_signed(offsets[column] as isize);
                    let at = [x as isize + right as isize, y as isize + below as isize].map(|at| at as usize);
                    assert_eq!(seen, interleaved.index(at[0], at[1]));
                }
            }
        }
    }
}
