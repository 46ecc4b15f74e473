//! From every second pixel to all of them: means over one pattern of directions, along the tangent plane.

use fearless_simd::prelude::*;
use fearless_simd::{Level, Simd, dispatch, f32x16};
use rayon::prelude::*;

use super::horizon::{Horizons, MARGIN, PATTERN};
use crate::lanes::{LANES, Lanes, dot, load, minus, splat};

/// Coarse pixels on each side of a pixel that are looked at.
const REACH: usize = PATTERN / 2;
/// Columns, and rows, of coarse pixels that are looked at.
const COLUMNS: usize = 2 * REACH + 1;
/// Neighbours this many pixels' widths from a pixel's tangent plane do not count, nearer ones the more.
const WIDTHS: f32 = 2.0;
/// A pixel whose neighbours count less than this, of 16, is computed itself.
const ENOUGH: f32 = 1.0;

/// The share of light that is left in each pixel.
pub fn light(horizons: &Horizons, strength: f32, level: Level) -> Vec<f32> {
    let width = horizons.surface.width;
    let mut light = vec![1.0; horizons.surface.depth.len()];
    light.par_chunks_mut(width).enumerate().for_each(|(y, to)| {
        // By the column of the pattern, which selects their directions.
        let mut alone: [Vec<usize>; PATTERN] = Default::default();
        for (chunk, to) in to.chunks_mut(LANES).enumerate() {
            let x = chunk * LANES;
            let Some(neighbours) = Neighbours::of(horizons, x, y) else { continue };
            if !neighbours.are_occluded(horizons) {
                continue;
            }
            let found = dispatch!(level, simd => {
                let (sum, weight) = neighbours.mean(simd, horizons);
                (sum.to_array(), weight.to_array())
            });
            for (lane, to) in to.iter_mut().enumerate() {
                match (found.0[lane], found.1[lane]) {
                    _ if !neighbours.depth[lane].is_finite() => {}
                    (sum, weight) if weight >= ENOUGH => *to = 1.0 - strength * (sum / weight),
                    _ => alone[(x + lane) % PATTERN].push(x + lane),
                }
            }
        }
        while alone.iter().any(|pixels| !pixels.is_empty()) {
            let of_lane: [_; LANES] = std::array::from_fn(|lane| alone[lane % PATTERN].pop());
            let places = of_lane.map(|x| [x.unwrap_or(usize::MAX), y]);
            let found = horizons.of_pixels(&places, y % PATTERN, level);
            for (x, occlusion) in of_lane.into_iter().zip(found) {
                if let Some(x) = x {
                    to[x] = 1.0 - strength * occlusion;
                }
            }
        }
    });
    light
}

/// 16 pixels of a row.
struct Neighbours {
    x: [f32; LANES],
    y: usize,
    depth: [f32; LANES],
    /// In the camera's axes.
    normal: [[f32; LANES]; 3],
}

impl Neighbours {
    /// The pixels from x on; `None` if nothing is visible in them.
    fn of(horizons: &Horizons, x: usize, y: usize) -> Option<Self> {
        let surface = horizons.surface;
        let first = y * surface.width + x;
        let count = LANES.min(surface.width - x);
        let mut depth = [f32::INFINITY; LANES];
        depth[..count].copy_from_slice(&surface.depth[first..first + count]);
        if depth.iter().all(|d| d.is_infinite()) {
            return None;
        }
        let mut normal = [[0.0; LANES]; 3];
        for lane in 0..count {
            let n = surface.to_camera(horizons.normals[first + lane]);
            (0..3).for_each(|k| normal[k][lane] = n[k]);
        }
        Some(Self { x: std::array::from_fn(|lane| (x + lane) as f32), y, depth, normal })
    }

    /// The weighted sum of the occlusion of the coarse pixels around each pixel, and the sum of the weights.
    ///
    /// Coarse pixels lie on even pixels: around an odd one there are four columns, of which each has another direction;
    /// around an even one there are five, and the outer two have the same direction and half the weight.
    #[inline(always)]
    fn mean<S: Simd>(&self, simd: S, horizons: &Horizons) -> (Lanes<S>, Lanes<S>) {
        let (x, none, one) = (load(simd, &self.x), splat(simd, 0.0), splat(simd, 1.0));
        let depth = load(simd, &self.depth);
        let depth = depth.simd_lt(splat(simd, f32::INFINITY)).select(depth, one);
        let position = horizons.position(simd, x, splat(simd, self.y as f32), depth);
        let normal = [load(simd, &self.normal[0]), load(simd, &self.normal[1]), load(simd, &self.normal[2])];
        let scale = horizons.surface.scale;
        let pixel =
            if horizons.surface.perspective { depth * (1.0 / scale) } else { splat(simd, 1.0 / scale) };
        let per_width = splat(simd, 1.0 / WIDTHS) / pixel;
        let (mut sum, mut total) = (none, none);
        let coarse_x = self.x[0] as usize / 2;
        let columns: [_; COLUMNS] = std::array::from_fn(|column| {
            let at = |lane: usize| (2 * (coarse_x + lane / 2 + column)) as f32 - 2.0 * REACH as f32;
            [std::array::from_fn(at), std::array::from_fn(|lane| side_weight(column, lane))]
        });
        for row in 0..COLUMNS {
            let row_weight = side_weight(row, self.y);
            if row_weight == 0.0 {
                continue;
            }
            let start = self.start(horizons, row);
            let at_y = splat(simd, 2.0 * (self.y / 2 + row) as f32 - 2.0 * REACH as f32);
            for (column, [at_x, weight]) in columns.iter().enumerate() {
                let first = start + 2 * column;
                let depth = f32x16::from_slice(simd, &horizons.depth[first..first + LANES]);
                let occlusion = f32x16::from_slice(simd, &horizons.occlusion[first..first + LANES]);
                let apart = minus(horizons.position(simd, load(simd, at_x), at_y, depth), position);
                let off = dot(apart, normal).abs() * per_width;
                // Not where nothing is visible: infinite, or no number.
                let near = off.simd_lt(one).select(one - off, none) * (load(simd, weight) * row_weight);
                sum += near * occlusion;
                total += near;
            }
        }
        (sum, total)
    }

    /// The index of the first number of a coarse row around the pixels; margins begin before the picture.
    #[inline(always)]
    fn start(&self, horizons: &Horizons, row: usize) -> usize {
        let x = self.x[0] as usize / 2;
        (self.y / 2 + row + MARGIN - REACH) * horizons.stride + 2 * (x + MARGIN - REACH)
    }

    /// Is anything around the pixels occluded?
    fn are_occluded(&self, horizons: &Horizons) -> bool {
        (0..COLUMNS).any(|row| {
            let start = self.start(horizons, row);
            let around = &horizons.occlusion[start..start + LANES + 4 * REACH];
            around.iter().fold(false, |any, &occlusion| any | (occlusion > 0.0))
        })
    }
}

/// The weight of one of five columns or rows of coarse pixels around a pixel.
#[inline(always)]
fn side_weight(number: usize, pixel: usize) -> f32 {
    match (pixel % 2, number) {
        (0, 0 | 4) => 0.5,
        (1, 0) => 0.0,
        _ => 1.0,
    }
}
