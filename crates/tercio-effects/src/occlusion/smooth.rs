//! From coarse pixels to all of them: means over one pattern of directions, along tangent planes.
//!
//! First each coarse pixel becomes the mean of those around it that are near its tangent plane: it then has the light of
//! every direction. Each pixel of the picture takes its light from those of the nearest one, two or four of these in whose
//! tangent planes it is. Both are done row by row, so that nothing but the finished colours is kept.

use fearless_simd::prelude::*;
use fearless_simd::{Level, Simd, f32x16, i32x16};
use rayon::prelude::*;

use super::blocks::Finder;
use super::coarse::{BLOCK, MARGIN, unpacked};
use super::horizon::{Points, place};
use super::pattern::PATTERN;
use crate::darken::Colors;
use crate::lanes::{LANES, Lanes, dot, load, load_part, scaled, splat};

/// Coarse pixels on each side of a coarse pixel that are looked at.
const REACH: usize = PATTERN / 2;
/// Columns, and rows, of coarse pixels that are looked at.
const COLUMNS: usize = 2 * REACH + 1;
/// Neighbours this many pixels' widths from a tangent plane do not count, nearer ones the more.
const WIDTHS: f32 = 2.0;
/// A pixel whose neighbours count less than this, of 1 to 4, is computed itself.
const ENOUGH: f32 = 0.0625;
/// Rows of pixels that one thread darkens at a time.
pub const BAND: usize = 2 * BLOCK;

/// Means of one row of coarse pixels, and their tangent planes.
struct Means {
    /// [`MEMBERS`] rows of numbers.
    rows: Vec<f32>,
    length: usize,
    /// Whether any of 16 is occluded.
    occluded: Vec<bool>,
}

/// What [`Means`] have: the occlusion, and four factors of the plane. A pixel's distance from it, in [`WIDTHS`] widths of the
/// pixel, is the sum of the products of the factors with: the pixel's place to the right and upwards, 1, and its depth, the
/// inverse of it for a perspective camera.
const MEMBERS: usize = 5;

impl Means {
    /// Of no pixel.
    fn new(columns: usize) -> Self {
        let length = columns.next_multiple_of(LANES) + LANES;
        let mut new =
            Self { rows: vec![0.0; MEMBERS * length], length, occluded: vec![false; length / LANES] };
        for first in (0..length).step_by(LANES) {
            new.clear(first);
        }
        new
    }

    /// Nothing is near 16 pixels' planes.
    fn clear(&mut self, first: usize) {
        for member in 0..MEMBERS {
            let value = if member == 3 { f32::INFINITY } else { 0.0 };
            self.at(member, first).fill(value);
        }
        self.occluded[first / LANES] = false;
    }

    fn at(&mut self, member: usize, first: usize) -> &mut [f32] {
        &mut self.rows[member * self.length + first..][..LANES]
    }

    #[inline(always)]
    fn load<S: Simd>(&self, simd: S, member: usize, first: usize) -> Lanes<S> {
        f32x16::from_slice(simd, &self.rows[member * self.length + first..][..LANES])
    }
}

/// Takes the light from a picture that does not reach its pixels.
pub struct Smoother<'a> {
    pub finder: &'a Finder<'a>,
    /// That of the coarse pixels.
    pub occlusion: &'a [f32],
    pub strength: f32,
    pub level: Level,
}

impl Smoother<'_> {
    /// Darkens bands of [`BAND`] rows.
    pub fn darken(&self, bands: Vec<Colors>) {
        let (surface, columns) = (self.finder.visible.surface, self.finder.coarse.size[0]);
        let memory = || {
            let light = vec![1.0; surface.width.next_multiple_of(2 * LANES)];
            ([Means::new(columns), Means::new(columns)], light)
        };
        bands.into_par_iter().enumerate().for_each_init(memory, |(means, light), (number, mut colors)| {
            let rows = number * BAND..((number + 1) * BAND).min(surface.height);
            let [upper, lower] = means;
            let first = rows.start;
            self.average(upper, first / 2);
            for y in rows {
                if y % 2 == 1 {
                    self.average(lower, y / 2 + 1);
                }
                if surface.perspective {
                    tercio_raster::dispatch!(self.level, simd => self.row::<_, true>(simd, y, [upper, lower], light));
                } else {
                    tercio_raster::dispatch!(self.level, simd => self.row::<_, false>(simd, y, [upper, lower], light));
                }
                self.compute_alone(y, light);
                colors.darken((y - first) * surface.width, &light[..surface.width], self.level);
                if y % 2 == 1 {
                    std::mem::swap(upper, lower);
                }
            }
        });
    }

    /// The means of a row of coarse pixels; none below the picture.
    fn average(&self, means: &mut Means, y: usize) {
        let [across, down] = self.finder.coarse.size;
        for x in (0..across).step_by(LANES) {
            if y >= down {
                means.clear(x);
            } else if self.finder.visible.surface.perspective {
                tercio_raster::dispatch!(self.level, simd => self.average_16::<_, true>(simd, means, [x, y]));
            } else {
                tercio_raster::dispatch!(self.level, simd => self.average_16::<_, false>(simd, means, [x, y]));
            }
        }
    }

    #[inline(always)]
    fn average_16<S: Simd, const PERSPECTIVE: bool>(&self, simd: S, means: &mut Means, [x, y]: [usize; 2]) {
        let (coarse, surface) = (self.finder.coarse, self.finder.visible.surface);
        let center = coarse.index(x, y);
        let depth = f32x16::from_slice(simd, &coarse.depth[center..center + LANES]);
        let is_visible = depth.simd_lt(splat(simd, f32::INFINITY));
        if is_visible.all_false() {
            means.clear(x);
            return;
        }
        let (none, one) = (splat(simd, 0.0), splat(simd, 1.0));
        let depth = is_visible.select(depth, one);
        let normal = unpacked(i32x16::from_slice(simd, &coarse.normals[center..center + LANES]));
        let pixels = [load(simd, &EVEN) + (2 * x) as f32, splat(simd, (2 * y) as f32)];
        let points = Points::new(surface, pixels, depth, normal);
        // The normal, so long that distances are in `WIDTHS` widths of a pixel at a depth of 1.
        let normal = scaled(normal, splat(simd, surface.scale / WIDTHS));
        let own = dot(points.position, normal);
        let (constant, of_depth) = if PERSPECTIVE { (-normal[2], -own) } else { (-own, -normal[2]) };
        // The same at this pixel's depth.
        let shorter = if PERSPECTIVE { one / depth } else { one };
        let (own, a, b, c) = (own * shorter, normal[0] * shorter, normal[1] * shorter, normal[2] * shorter);
        let apart = 2.0 / surface.scale;
        let offset = |number: usize| (number as f32 - REACH as f32) * apart;
        let plane = [normal[0], normal[1], constant, of_depth];
        let nothing = [none, none, splat(simd, f32::INFINITY), none];
        for member in 0..MEMBERS - 1 {
            is_visible.select(plane[member], nothing[member]).store_slice(means.at(member + 1, x));
        }
        means.occluded[x / LANES] = self.is_any_occluded(simd, center);
        if !means.occluded[x / LANES] {
            none.store_slice(means.at(0, x));
            return;
        }
        let aside: [_; COLUMNS] = [a * offset(0), a * offset(1), none, a * offset(3), a * offset(4)];
        let (mut sum, mut total) = (none, none);
        for row in 0..COLUMNS {
            let first = center + row * coarse.stride - REACH * coarse.stride - REACH;
            let depths = &coarse.depth[first..first + LANES + COLUMNS - 1];
            let occlusions = &self.occlusion[first..first + LANES + COLUMNS - 1];
            let in_row = (points.at[1] - offset(row)) * b;
            let in_row = in_row + points.at[0] * a;
            let in_row = if PERSPECTIVE { in_row - c } else { in_row - own };
            let (mut inner, mut outer) = ([none; 2], [none; 2]);
            for column in 0..COLUMNS {
                let depth = f32x16::from_slice(simd, &depths[column..column + LANES]);
                let occlusion = f32x16::from_slice(simd, &occlusions[column..column + LANES]);
                let along = in_row + aside[column];
                let off = if PERSPECTIVE { depth * along - own } else { along - depth * c };
                let near = one - off.abs();
                // Not where nothing is visible: infinite, or no number.
                let near = near.simd_gt(none).select(near, none);
                let to = if column % (COLUMNS - 1) == 0 { &mut outer } else { &mut inner };
                to[0] += near * occlusion;
                to[1] += near;
            }
            // There are five columns and rows, of which the outer two have the same direction.
            let weight = if row % (COLUMNS - 1) == 0 { 0.5 } else { 1.0 };
            sum += (inner[0] + outer[0] * 0.5) * weight;
            total += (inner[1] + outer[1] * 0.5) * weight;
        }
        let mean = sum / total;
        is_visible.select(mean, none).store_slice(means.at(0, x));
    }

    /// Is any coarse pixel occluded that is looked at for 16 of them, from the one of this index on?
    #[inline(always)]
    fn is_any_occluded<S: Simd>(&self, simd: S, center: usize) -> bool {
        let stride = self.finder.coarse.stride;
        let mut any = splat(simd, 0.0);
        for row in 0..COLUMNS {
            let first = center + row * stride - REACH * stride - REACH;
            let occlusions = &self.occlusion[first..first + LANES + COLUMNS - 1];
            any += f32x16::from_slice(simd, &occlusions[..LANES]);
            any += f32x16::from_slice(simd, &occlusions[COLUMNS - 1..]);
        }
        any.simd_gt(splat(simd, 0.0)).any_true()
    }

    /// The light of a row of pixels, of the means of the rows of coarse pixels beside it; less than 0 where none of them is
    /// near.
    #[inline(always)]
    fn row<S: Simd, const PERSPECTIVE: bool>(
        &self,
        simd: S,
        y: usize,
        means: [&Means; 2],
        light: &mut [f32],
    ) {
        let visible = &self.finder.visible;
        let surface = visible.surface;
        let depths = &visible.depth[y * surface.width..(y + 1) * surface.width];
        let (none, one, infinite) = (splat(simd, 0.0), splat(simd, 1.0), splat(simd, f32::INFINITY));
        let means = &means[..1 + y % 2];
        for (number, light) in light.as_chunks_mut::<{ 2 * LANES }>().0.iter_mut().enumerate() {
            let (x, coarse) = (number * 2 * LANES, number * LANES);
            let depth = [
                load_part(simd, depths, x, f32::INFINITY),
                load_part(simd, depths, x + LANES, f32::INFINITY),
            ];
            if (depth[0].simd_lt(infinite) | depth[1].simd_lt(infinite)).all_false() {
                light.fill(1.0);
                continue;
            }
            // The last pixel has a neighbour among the next ones.
            if !means.iter().any(|row| row.occluded[number] | row.occluded[number + 1]) {
                light.fill(1.0);
                continue;
            }
            let mut found = [none; 2];
            for odd in 0..2 {
                let depth =
                    if odd == 0 { depth[0].unzip_low(depth[1]) } else { depth[0].unzip_high(depth[1]) };
                let is_visible = depth.simd_lt(infinite);
                let depth = is_visible.select(depth * surface.per_world, one);
                let depth = if PERSPECTIVE { one / depth } else { depth };
                let [right, up] =
                    place(surface, [load(simd, &EVEN) + (x + odd) as f32, splat(simd, y as f32)]);
                let (mut sum, mut total) = (none, none);
                for row in means {
                    for column in coarse..=coarse + odd {
                        let of = |member: usize| row.load(simd, member, column);
                        let off = ((of(1) * right + of(2) * up) + of(3)) + of(4) * depth;
                        let near = one - off.abs();
                        let near = near.simd_gt(none).select(near, none);
                        sum += near * of(0);
                        total += near;
                    }
                }
                let left = one - (sum / total) * self.strength;
                let left = total.simd_ge(splat(simd, ENOUGH)).select(left, splat(simd, -1.0));
                found[odd] = is_visible.select(left, one);
            }
            found[0].zip_low(found[1]).store_slice(&mut light[..LANES]);
            found[0].zip_high(found[1]).store_slice(&mut light[LANES..]);
        }
    }

    /// The light of those pixels of a row that have no neighbour in their tangent plane. They are not averaged with others: so
    /// that they have less noise, each has the directions of a row of the pattern.
    fn compute_alone(&self, y: usize, light: &mut [f32]) {
        let mut alone = Vec::new();
        for (number, sixteen) in light.as_chunks::<LANES>().0.iter().enumerate() {
            if sixteen.iter().fold(false, |any, &light| any | (light < 0.0)) {
                let pixels = number * LANES..(number + 1) * LANES;
                alone.extend(pixels.filter(|&x| light[x] < 0.0));
            }
        }
        for pixels in alone.chunks(LANES / PATTERN) {
            // A lane has the directions of its column.
            let places: [_; LANES] =
                std::array::from_fn(|lane| [pixels.get(lane / PATTERN).copied().unwrap_or(usize::MAX), y]);
            let found = self.finder.of_pixels(&places, y % PATTERN, self.level);
            for (&x, of_columns) in pixels.iter().zip(found.as_chunks::<PATTERN>().0) {
                let mean = of_columns.iter().sum::<f32>() / PATTERN as f32;
                light[x] = 1.0 - self.strength * mean;
            }
        }
    }
}

/// Pixels from the first one to each of 16 coarse ones.
const EVEN: [f32; LANES] = {
    let mut even = [0.0; LANES];
    let mut lane = 0;
    while lane < LANES {
        even[lane] = (2 * lane) as f32;
        lane += 1;
    }
    even
};

const _: () = assert!(REACH <= MARGIN, "what is looked at is in the planes");
