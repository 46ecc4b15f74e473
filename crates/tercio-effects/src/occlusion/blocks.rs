//! The occlusion of every coarse pixel, block by block, and of single pixels.

use fearless_simd::prelude::*;
use fearless_simd::{Level, Simd, f32x16, i32x16};
use rayon::prelude::*;

use super::coarse::{BLOCK, Coarse, Interleaved, MARGIN, unpacked};
use super::horizon::{Around, Points, occlusion};
use super::pattern::{LINES, MAX_RADIUS, MIN_DISTANCE, PATTERN, Row, STEPS, rows};
use crate::lanes::{LANES, Lanes, clamp, interleaved, load, splat};
use crate::surface::Surface;

/// If the radii in a block differ by less than this factor, their mean stands for all.
const SIMILAR: f32 = 1.25;

/// What is visible in a frame.
pub struct Visible<'a> {
    /// Lengths are in radii of the occlusion.
    pub surface: &'a Surface,
    /// Depths of the frame.
    pub depth: &'a [f32],
    /// Unit normals in world space.
    pub normals: &'a [[f32; 3]],
}

impl Visible<'_> {
    /// Depth and normal of a pixel; nothing outside the picture.
    fn pixel(&self, [x, y]: [usize; 2]) -> (f32, [f32; 3]) {
        if x >= self.surface.width || y >= self.surface.height {
            return (f32::INFINITY, [0.0; 3]);
        }
        let index = y * self.surface.width + x;
        (self.depth[index], self.normals[index])
    }
}

/// Finds the occlusion of pixels.
pub struct Finder<'a> {
    pub visible: Visible<'a>,
    pub coarse: &'a Coarse,
    interleaved: Interleaved,
    rows: [Row; PATTERN],
    /// Of each row.
    columns: [[Row; PATTERN]; PATTERN],
}

impl<'a> Finder<'a> {
    pub fn new(visible: Visible<'a>, coarse: &'a Coarse, level: Level) -> Self {
        let interleaved = Interleaved::new(coarse, visible.surface, level);
        let rows = rows();
        let columns = std::array::from_fn(|row| std::array::from_fn(|column| rows[row].column(column)));
        Self { visible, coarse, interleaved, rows, columns }
    }

    /// The occlusion of the coarse pixels, 0 of those in which nothing is visible, in a plane like that of their depths.
    pub fn of_coarse(&self, level: Level) -> Vec<f32> {
        let Coarse { size, stride, ref depth, .. } = *self.coarse;
        let mut found = vec![0.0; depth.len()];
        let rows = found[MARGIN * stride..].par_chunks_mut(BLOCK * stride);
        rows.take(size[1].div_ceil(BLOCK)).enumerate().for_each(|(block_y, to)| {
            let mut offsets =
                Offsets([[[Offset { index: [0; LANES], away: [[0.0; LANES]; 2] }; 2]; STEPS]; LINES]);
            for block_x in 0..size[0].div_ceil(BLOCK) {
                let first = [block_x * BLOCK, block_y * BLOCK];
                let to = &mut to[MARGIN + first[0]..];
                if self.visible.surface.perspective {
                    tercio_raster::dispatch!(level, simd => self.of_block::<_, true>(simd, first, to, &mut offsets, level));
                } else {
                    tercio_raster::dispatch!(level, simd => self.of_block::<_, false>(simd, first, to, &mut offsets, level));
                }
            }
        });
        found
    }

    /// The occlusion of a block. Pixels at the same place of the pattern look in the same directions, and if they have the
    /// same radius they see what lies side by side.
    #[inline(always)]
    fn of_block<S: Simd, const PERSPECTIVE: bool>(
        &self,
        simd: S,
        first: [usize; 2],
        to: &mut [f32],
        offsets: &mut Offsets,
        level: Level,
    ) {
        let stride = self.coarse.stride;
        let corner = self.coarse.index(first[0], first[1]);
        let infinite = splat(simd, f32::INFINITY);
        let (mut nearest, mut farthest) = (infinite, splat(simd, 0.0));
        for row in 0..BLOCK {
            let depth = &self.coarse.depth[corner + row * stride..][..LANES];
            let depth = f32x16::from_slice(simd, depth);
            nearest = depth.simd_lt(nearest).select(depth, nearest);
            let depth = depth.simd_lt(infinite).select(depth, splat(simd, 0.0));
            farthest = depth.simd_gt(farthest).select(depth, farthest);
        }
        let nearest = nearest.to_array().into_iter().fold(f32::INFINITY, f32::min);
        if nearest == f32::INFINITY {
            return;
        }
        let farthest = farthest.to_array().into_iter().fold(0.0, f32::max);
        let scale = self.visible.surface.scale;
        let [most, least] = if PERSPECTIVE { [scale / nearest, scale / farthest] } else { [scale; 2] };
        let [most, least] = [most.min(MAX_RADIUS), least.min(MAX_RADIUS)];
        if most > SIMILAR * least {
            self.one_by_one(first, to, level);
            return;
        }
        let radius = (most + least) * 0.5;
        for row in 0..PATTERN {
            self.set_offsets(simd, row, radius, offsets);
            let mut columns = [splat(simd, 0.0); PATTERN];
            let normals = self.normals_of_row(simd, corner + row * stride);
            for column in 0..PATTERN {
                let at = [first[0] + column, first[1] + row];
                columns[column] = self.of_cells::<S, PERSPECTIVE>(simd, at, normals[column], offsets);
            }
            for (cell, pixels) in interleaved(columns).into_iter().enumerate() {
                let first = (cell * PATTERN + row) * stride;
                pixels.store_slice(&mut to[first..first + LANES]);
            }
        }
    }

    /// The normals of every fourth row of a block from this index on, by the column of the pattern.
    #[inline(always)]
    fn normals_of_row<S: Simd>(&self, simd: S, first: usize) -> [i32x16<S>; PATTERN] {
        let step = PATTERN * self.coarse.stride;
        let row = |row: usize| &self.coarse.normals[first + row * step..][..LANES];
        let [a, b] = [i32x16::from_slice(simd, row(0)), i32x16::from_slice(simd, row(1))];
        let [c, d] = [i32x16::from_slice(simd, row(2)), i32x16::from_slice(simd, row(3))];
        let (even, odd) = ([a.unzip_low(b), c.unzip_low(d)], [a.unzip_high(b), c.unzip_high(d)]);
        [
            even[0].unzip_low(even[1]),
            odd[0].unzip_low(odd[1]),
            even[0].unzip_high(even[1]),
            odd[0].unzip_high(odd[1]),
        ]
    }

    /// The occlusion of 4 x 4 coarse pixels, each [`PATTERN`] pixels from the next, row by row from the given one.
    #[inline(always)]
    fn of_cells<S: Simd, const PERSPECTIVE: bool>(
        &self,
        simd: S,
        [x, y]: [usize; 2],
        normals: i32x16<S>,
        offsets: &Offsets,
    ) -> Lanes<S> {
        let surface = self.visible.surface;
        let own = self.interleaved.index(x, y);
        let depth = self.interleaved.load(simd, own);
        let is_visible = depth.simd_lt(splat(simd, f32::INFINITY));
        if is_visible.all_false() {
            return splat(simd, 0.0);
        }
        let depth = is_visible.select(depth, splat(simd, 1.0));
        let cells = [load(simd, &CELLS[0]) + (2 * x) as f32, load(simd, &CELLS[1]) + (2 * y) as f32];
        let points = Points::new(surface, cells, depth, unpacked(normals));
        let around = Beside { interleaved: &self.interleaved, offsets, own, column: x % PATTERN };
        let row = &self.columns[y % PATTERN][x % PATTERN];
        let found = occlusion::<S, PERSPECTIVE>(simd, &points, row, &around);
        is_visible.select(found, splat(simd, 0.0))
    }

    /// The occlusion of a block whose pixels have different radii.
    #[inline(never)]
    fn one_by_one(&self, first: [usize; 2], to: &mut [f32], level: Level) {
        for row in 0..BLOCK {
            let y = first[1] + row;
            let pixels = std::array::from_fn(|x| [2 * (first[0] + x), 2 * y]);
            let found = self.of_pixels(&pixels, y % PATTERN, level);
            to[row * self.coarse.stride..][..LANES].copy_from_slice(&found);
        }
    }

    /// The occlusion of 16 pixels, given from the upper left one; 0 of those outside the picture or where nothing is
    /// visible. The lane and the row of the pattern select the directions.
    pub fn of_pixels(&self, pixels: &[[usize; 2]; LANES], row: usize, level: Level) -> [f32; LANES] {
        let (mut depth, mut normals) = ([f32::INFINITY; LANES], [[0.0; LANES]; 3]);
        let mut places = [[0.0; LANES]; 2];
        for (lane, &[x, y]) in pixels.iter().enumerate() {
            let normal;
            (depth[lane], normal) = self.visible.pixel([x, y]);
            (0..3).for_each(|k| normals[k][lane] = normal[k]);
            (places[0][lane], places[1][lane]) = (x as f32, y as f32);
        }
        let row = &self.rows[row];
        if self.visible.surface.perspective {
            tercio_raster::dispatch!(level, simd => self.of_lanes::<_, true>(simd, &places, &depth, &normals, row).to_array())
        } else {
            tercio_raster::dispatch!(level, simd => self.of_lanes::<_, false>(simd, &places, &depth, &normals, row).to_array())
        }
    }

    #[inline(always)]
    fn of_lanes<S: Simd, const PERSPECTIVE: bool>(
        &self,
        simd: S,
        places: &[[f32; LANES]; 2],
        depth: &[f32; LANES],
        normals: &[[f32; LANES]; 3],
        row: &Row,
    ) -> Lanes<S> {
        let surface = self.visible.surface;
        let depth = load(simd, depth) * surface.per_world;
        let is_visible = depth.simd_lt(splat(simd, f32::INFINITY));
        let depth = is_visible.select(depth, splat(simd, 1.0));
        let normal = [load(simd, &normals[0]), load(simd, &normals[1]), load(simd, &normals[2])];
        let pixels = [load(simd, &places[0]), load(simd, &places[1])];
        let points = Points::new(surface, pixels, depth, surface.to_camera(normal));
        let radius = points.radius(simd, surface);
        let around = Anywhere { coarse: self.coarse, row, pixels, radius, inverse: 1.0 / surface.scale };
        let found = occlusion::<S, PERSPECTIVE>(simd, &points, row, &around);
        is_visible.select(found, splat(simd, 0.0))
    }
}

/// Pixels from the first one to each of 4 x 4 of a block: to the right and down.
const CELLS: [[f32; LANES]; 2] = {
    let mut cells = [[0.0; LANES]; 2];
    let mut lane = 0;
    while lane < LANES {
        cells[0][lane] = (2 * PATTERN * (lane % PATTERN)) as f32;
        cells[1][lane] = (2 * PATTERN * (lane / PATTERN)) as f32;
        lane += 1;
    }
    cells
};

/// Where the points of a row of the pattern look, by line, step, side, and column of the pattern.
struct Offsets([[[Offset; 2]; STEPS]; LINES]);

#[derive(Clone, Copy)]
struct Offset {
    /// In the plane of depths.
    index: [i32; LANES],
    /// As [`Points::at`] counts: to the right and upwards.
    away: [[f32; LANES]; 2],
}

impl Finder<'_> {
    #[inline(always)]
    fn set_offsets<S: Simd>(&self, simd: S, row: usize, radius: f32, offsets: &mut Offsets) {
        let row = &self.rows[row];
        let per_coarse = 2.0 / self.visible.surface.scale;
        for line in 0..LINES {
            let [right, up] = [load(simd, &row.lines[line][0]), load(simd, &row.lines[line][1])];
            for step in 0..STEPS {
                let distance = load(simd, &row.steps[step]) * radius;
                let distance = clamp(simd, distance, MIN_DISTANCE, MAX_RADIUS) * 0.5;
                for side in 0..2 {
                    let distance = if side == 0 { distance } else { -distance };
                    // The nearest coarse pixel.
                    let x = (right * distance + 0.5).floor();
                    let y = (up * distance + 0.5).floor();
                    offsets.0[line][step][side] = Offset {
                        index: self.interleaved.offsets(simd, x.to_int(), (-y).to_int()).to_array(),
                        away: [(x * per_coarse).to_array(), (y * per_coarse).to_array()],
                    };
                }
            }
        }
    }
}

/// What 4 x 4 pixels of a block see, which look in the same directions.
struct Beside<'a> {
    interleaved: &'a Interleaved,
    offsets: &'a Offsets,
    /// The index of the first pixel.
    own: usize,
    /// Of the pattern.
    column: usize,
}

impl<S: Simd> Around<S> for Beside<'_> {
    #[inline(always)]
    fn seen(&self, simd: S, line: usize, side: usize, step: usize) -> ([Lanes<S>; 2], Lanes<S>) {
        let Offset { index, away } = &self.offsets.0[line][step][side];
        let index = self.own.wrapping_add_signed(index[self.column] as isize);
        let [right, up] = [splat(simd, away[0][self.column]), splat(simd, away[1][self.column])];
        ([right, up], self.interleaved.load(simd, index))
    }
}

/// What any pixels see.
struct Anywhere<'a, S: Simd> {
    coarse: &'a Coarse,
    row: &'a Row,
    pixels: [Lanes<S>; 2],
    /// In pixels.
    radius: Lanes<S>,
    /// Units of length per pixel.
    inverse: f32,
}

impl<S: Simd> Around<S> for Anywhere<'_, S> {
    #[inline(always)]
    fn seen(&self, simd: S, line: usize, side: usize, step: usize) -> ([Lanes<S>; 2], Lanes<S>) {
        let distance = load(simd, &self.row.steps[step]) * self.radius;
        let distance = clamp(simd, distance, MIN_DISTANCE, MAX_RADIUS);
        let distance = if side == 0 { distance } else { -distance };
        let [right, up] = &self.row.lines[line];
        let [right, up] = [load(simd, right) * distance, load(simd, up) * distance];
        // The nearest coarse pixel, in the margin if it is outside.
        let [across, down] = self.coarse.size;
        let x = clamp(simd, (self.pixels[0] + right) * 0.5 + 0.5, -1.0, across as f32).floor();
        let y = clamp(simd, (self.pixels[1] - up) * 0.5 + 0.5, -1.0, down as f32).floor();
        let (column, line): (i32x16<S>, i32x16<S>) = (x.to_int(), y.to_int());
        let margin = MARGIN as i32;
        let index = ((line + margin) * self.coarse.stride as i32 + (column + margin)).to_array();
        let mut depth = [0.0; LANES];
        for lane in 0..LANES {
            depth[lane] = self.coarse.depth[index[lane] as usize];
        }
        let away = [(x * 2.0 - self.pixels[0]) * self.inverse, (y * 2.0 - self.pixels[1]) * -self.inverse];
        (away, load(simd, &depth))
    }
}
