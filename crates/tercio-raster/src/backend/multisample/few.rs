//! Coverage and depth tests of triangles of a few pixels, with at most 4 samples per pixel.
//!
//! Edge functions are evaluated for 16 triangles at two samples at once, in 16 bits; where those do not suffice, triangles
//! are drawn as larger ones are ([`super::stamps`]). Only pixels in which samples are covered remain, 16 of which are then
//! processed at once: the depths of their samples are computed, and tested one pixel after another.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i16x32, i32x16, mask32x16};

use super::fragments::Fragment;
use super::memory::SampleMemory;
use super::sink::Sink;
use crate::backend::cluster::{Size, SmallTriangles};
use crate::context::FrameContext;
use crate::conventions::SUBPIXELS;
use crate::sampling::SampleCells;
use crate::simd::{
    LANE_NUMBERS, LANES, append, each3, live_lanes, lookup_16, part, splat, splat_i, store_interleaved,
};
use crate::stats::BackEndCounts;

/// The most samples per pixel.
pub const FEW: usize = 4;
/// Two samples are tested at once.
const PAIRS: usize = FEW / 2;
/// The largest numbers of pixels across and down.
const MOST: i32 = match Size::Small.max_across() {
    Some(max) => max,
    None => 0,
};
/// The largest number of pixels that 16 triangles can reach.
const CAPACITY: usize = LANES * (MOST * MOST) as usize;

/// Where the parts of a hit begin in its word: the place of the pixel, the samples that are covered (as in
/// [`super::fragments::Fragment`]), the lane of the triangle, and the column and row of the pixel in its bounding box.
const COVERED_SHIFT: u32 = 16;
const LANE_SHIFT: u32 = 20;
const COLUMN_SHIFT: u32 = 24;
const ROW_SHIFT: u32 = 26;

/// The largest extent of a triangle, in sub-pixels, whose edge functions fit into 16 bits at all cells of the pixels of its
/// bounding box.
///
/// A corner of such a pixel is less than a pixel outside of the bounding box. With an extent of L, an edge function is there at most
/// 2 L (L + 256) square sub-pixels, and is divided by the edge of a cell, a quarter of a pixel or more.
const MOST_EXTENT: i32 = 903;
const _: () = assert!(2 * MOST_EXTENT * (MOST_EXTENT + SUBPIXELS) / (SUBPIXELS / 4) < i16::MAX as i32);

/// The pixels in which 16 triangles cover samples.
#[derive(Debug)]
pub struct FewHits {
    /// One word for each; room for all, plus 16 because they are written and read 16 at a time.
    words: [i32; CAPACITY + LANES],
    count: usize,
}

impl Default for FewHits {
    fn default() -> Self {
        Self { words: [0; CAPACITY + LANES], count: 0 }
    }
}

/// Lanes of triangles whose edge functions do not fit into 16 bits.
#[inline(always)]
pub fn beyond<S: Simd>(simd: S, t: &SmallTriangles<S>) -> u32 {
    part(
        simd,
        #[inline(always)]
        || {
            let a = each3!(K => t.a[K].abs());
            let b = each3!(K => t.b[K].abs());
            let most = a[0].max(a[1]).max(a[2]).max(b[0].max(b[1]).max(b[2]));
            most.simd_gt(splat_i(simd, MOST_EXTENT)).to_bitmask() as u32 & 0xffff
        },
    )
}

/// The same number for both samples of a pair.
#[inline(always)]
fn pair<S: Simd>(simd: S, v: i32x16<S>) -> i16x32<S> {
    ((v & splat_i(simd, 0xffff)) | (v << 16)).bitcast()
}

/// A number for each sample of a pair.
#[inline(always)]
fn pair_of<S: Simd>(simd: S, first: i32, second: i32) -> i16x32<S> {
    splat_i(simd, (first & 0xffff) | (second << 16)).bitcast()
}

impl FewHits {
    /// Finds the pixels in which the triangles in some lanes, whose edge functions fit into 16 bits, cover samples. Rows of
    /// pixels are `1 << stride_bits` apart. Not inlined, so that it is compiled only once per SIMD level.
    #[inline(never)]
    pub fn scan<S: Simd>(
        &mut self,
        simd: S,
        cells: &SampleCells,
        t: &SmallTriangles<S>,
        lanes: u32,
        is_tiny: bool,
        stride_bits: u32,
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                let extent = if is_tiny { [2, 2] } else { pixels(simd, t, lanes) };
                self.scan_pixels(simd, cells, t, lanes, extent, stride_bits);
            },
        );
    }

    /// Tests the pixels in the first `across` columns and `down_to` rows of the bounding boxes.
    #[inline(always)]
    fn scan_pixels<S: Simd>(
        &mut self,
        simd: S,
        cells: &SampleCells,
        t: &SmallTriangles<S>,
        lanes: u32,
        [across, down_to]: [i32; 2],
        stride_bits: u32,
    ) {
        let count = &mut 0;
        part(
            simd,
            #[inline(always)]
            || {
                let lanes = mask32x16::from_bitmask(simd, u64::from(lanes));
                let all = splat_i(simd, cells.mask() as i32);
                let (a, b) = (each3!(K => pair(simd, t.a[K])), each3!(K => pair(simd, t.b[K])));
                let c = each3!(K => pair(simd, t.c[K]));
                let bits = cells.cell_bits();
                let right = each3!(K => a[K] << bits);
                let down = each3!(K => b[K] << bits);
                // What does not exist of four samples is found to be covered as the first cell, and left out.
                let mut at_row = [c; PAIRS];
                let mut bit = [splat_i(simd, 0); PAIRS];
                for pair in 0..PAIRS {
                    let [first, second] = [cells.cells[2 * pair], cells.cells[2 * pair + 1]];
                    let (x, y) = (pair_of(simd, first[0], second[0]), pair_of(simd, first[1], second[1]));
                    at_row[pair] = each3!(K => (a[K] * x + b[K] * y) + c[K]);
                    bit[pair] = splat_i(simd, 1 << (2 * pair) | 2 << (2 * pair + 16));
                }
                let first = (t.first[1] << stride_bits) + t.first[0];
                let first = first | (i32x16::load_array(simd, LANE_NUMBERS) << LANE_SHIFT);
                for row in 0..down_to {
                    let in_row = lanes & t.extent[1].simd_ge(splat_i(simd, row));
                    let mut e = at_row;
                    for column in 0..across {
                        let in_box = in_row & t.extent[0].simd_ge(splat_i(simd, column));
                        let mut outside = splat_i(simd, 0);
                        for pair in 0..PAIRS {
                            let any = (e[pair][0] | e[pair][1]) | e[pair][2];
                            // All bits of a negative number, shifted, are set.
                            outside |= (any >> 15).bitcast::<i32x16<S>>() & bit[pair];
                        }
                        let covered = ((outside | (outside >> 16)) & all) ^ all;
                        let hits = in_box & covered.simd_gt(splat_i(simd, 0));
                        let hits = hits.to_bitmask() as u32 & 0xffff;
                        // Whether there are any cannot be predicted.
                        let place = column + (row << stride_bits);
                        let at = place | column << COLUMN_SHIFT | row << ROW_SHIFT;
                        let words = (first + at) | (covered << COVERED_SHIFT);
                        append(simd, &mut self.words, *count, hits, words);
                        *count += hits.count_ones() as usize;
                        for pair in 0..PAIRS {
                            e[pair] = each3!(K => e[pair][K] + right[K]);
                        }
                    }
                    for pair in 0..PAIRS {
                        at_row[pair] = each3!(K => at_row[pair][K] + down[K]);
                    }
                }
            },
        );
        self.count = *count;
    }

    /// Tests the depths of what was found in the same triangles, and adds the fragments that win. `first_slot` is the
    /// slot of the cluster's first triangle, `numbers` are the triangles' numbers in the cluster.
    #[expect(clippy::too_many_arguments, reason = "one call site; a struct would only rename them")]
    #[inline(always)]
    pub fn test<S: Simd, K: Sink>(
        &self,
        simd: S,
        context: &FrameContext,
        t: &SmallTriangles<S>,
        first_slot: u32,
        numbers: &[u8; LANES],
        memory: &mut SampleMemory,
        counts: &mut BackEndCounts,
    ) {
        let mut slots = [0; LANES];
        for lane in 0..LANES {
            slots[lane] = (first_slot + u32::from(numbers[lane])) as i32;
        }
        let mut samples_covered = 0;
        for first in (0..self.count).step_by(LANES) {
            let mut pixels = Pixels::default();
            let offset = memory.lane_offset;
            part(
                simd,
                #[inline(always)]
                || {
                    let live = live_lanes(self.count - first);
                    let live = mask32x16::from_bitmask(simd, u64::from(live));
                    let words = i32x16::from_slice(simd, &self.words[first..first + LANES]);
                    let words = live.select(words, splat_i(simd, 0));
                    samples_covered += pixels.set(simd, t, offset, &slots, words);
                },
            );
            let count = (self.count - first).min(LANES);
            K::in_small_pixels(memory, simd, context, &pixels.fragments[..count], &pixels.depths);
        }
        counts.samples_covered += u64::from(samples_covered as u32);
    }
}

/// 16 pixels in which triangles cover samples.
#[derive(Default)]
struct Pixels {
    fragments: [Fragment; LANES],
    /// Depths of the samples, NaN where they are not covered.
    depths: [[f32; FEW]; LANES],
}

impl Pixels {
    /// Unpacks the words of hits, 0 in lanes without one. `offset` has the distances of the samples of a pixel from its first
    /// cell. Returns the number of samples that are covered.
    #[inline(always)]
    fn set<S: Simd>(
        &mut self,
        simd: S,
        t: &SmallTriangles<S>,
        offset: [[f32; LANES]; 2],
        slots: &[i32; LANES],
        words: i32x16<S>,
    ) -> i32 {
        let lane = (words >> LANE_SHIFT) & 15;
        let place = words & ((1 << LANE_SHIFT) - 1);
        let slot = lookup_16(simd, i32x16::load_array_ref(simd, slots), lane);
        let (low, high) = self.fragments.split_at_mut(LANES / 2);
        slot.zip_low(place).store_slice(bytemuck::cast_slice_mut(low));
        slot.zip_high(place).store_slice(bytemuck::cast_slice_mut(high));

        let of = |table: f32x16<S>| -> f32x16<S> { lookup_16(simd, table.bitcast(), lane).bitcast() };
        let column = (words >> COLUMN_SHIFT) & 3;
        let row = words >> ROW_SHIFT;
        let x = lookup_16(simd, t.from_anchor[0], lane) + column * SUBPIXELS;
        let y = lookup_16(simd, t.from_anchor[1], lane) + row * SUBPIXELS;
        let (x, y) = (x.to_float::<f32x16<S>>(), y.to_float::<f32x16<S>>());
        let slope = [of(t.slope[0]), of(t.slope[1])];
        let (base, nearest) = (of(t.base), of(t.nearest));
        let mut depths = [splat(simd, 0.0); FEW];
        let mut count = splat_i(simd, 0);
        for sample in 0..FEW {
            // Whole numbers of this size are exact.
            let (x, y) = (x + offset[0][sample], y + offset[1][sample]);
            let depth = (x * slope[0] + y * slope[1]) + base;
            let depth = depth.max(base).min(nearest);
            let is_covered = (words << (31 - COVERED_SHIFT - sample as u32)) >> 31;
            count -= is_covered;
            // With all bits set it is NaN.
            depths[sample] = (depth.bitcast::<i32x16<S>>() | !is_covered).bitcast();
        }
        store_interleaved(depths, &mut self.depths);
        count.reduce_sum()
    }
}

/// The largest numbers of pixels across and down in the boxes of the triangles in some lanes.
#[inline(always)]
pub fn pixels<S: Simd>(simd: S, t: &SmallTriangles<S>, lanes: u32) -> [i32; 2] {
    part(
        simd,
        #[inline(always)]
        || {
            let lanes = mask32x16::from_bitmask(simd, u64::from(lanes));
            let mut pixels = [1, 1];
            for (pixels, extent) in pixels.iter_mut().zip(t.extent) {
                for more in 1..MOST {
                    *pixels += i32::from((lanes & extent.simd_ge(splat_i(simd, more))).any_true());
                }
            }
            pixels
        },
    )
}

#[cfg(test)]
mod tests {
    use crate::dispatch;
    use proptest::prelude::*;

    use super::*;
    use crate::sampling::SamplePattern;
    use crate::screen::{Edges, ScreenTriangle};
    use crate::simd::SimdLevel;

    const ZERO: [i32; LANES] = [0; LANES];

    /// 16 triangles, set up one by one in 64 bits.
    struct Expected {
        edges: Vec<Edges>,
        first: [[i32; LANES]; 2],
        extent: [[i32; LANES]; 2],
    }

    impl Expected {
        fn new(triangles: &[ScreenTriangle], cells: &SampleCells) -> Self {
            let edges = triangles.iter().map(|t| Edges::of_cells(t, cells)).collect();
            let mut found = Self { edges, first: [ZERO; 2], extent: [ZERO; 2] };
            for (lane, t) in triangles.iter().enumerate() {
                for (axis, v) in [t.x, t.y].into_iter().enumerate() {
                    let [a, b, c] = v;
                    let first = (a.min(b).min(c) + cells.origin - 1) >> 8;
                    found.first[axis][lane] = first;
                    found.extent[axis][lane] = ((a.max(b).max(c) - cells.origin) >> 8) - first;
                }
            }
            found
        }

        fn set_up<S: Simd>(&self, simd: S, cells: &SampleCells) -> SmallTriangles<S> {
            let bits = cells.cell_bits();
            let (mut a, mut b, mut c) = ([ZERO; 3], [ZERO; 3], [ZERO; 3]);
            for (lane, edges) in self.edges.iter().enumerate() {
                for k in 0..3 {
                    (a[k][lane], b[k][lane]) = (edges.a[k], edges.b[k]);
                    let value = edges.at(k, self.first[0][lane] << bits, self.first[1][lane] << bits);
                    c[k][lane] = i32::try_from(value).unwrap();
                }
            }
            let load = |v: [i32; LANES]| i32x16::load_array(simd, v);
            SmallTriangles {
                first: self.first.map(load),
                extent: self.extent.map(load),
                c: c.map(load),
                a: a.map(load),
                b: b.map(load),
                from_anchor: [splat_i(simd, 0); 2],
                base: splat(simd, 0.0),
                nearest: splat(simd, 0.0),
                slope: [splat(simd, 0.0); 2],
            }
        }

        /// Lane, pixel and covered samples of each hit.
        fn hits(&self, lanes: u32, cells: &SampleCells) -> Vec<[i32; 4]> {
            let mut hits = Vec::new();
            for (lane, edges) in self.edges.iter().enumerate().filter(|(lane, _)| lanes >> lane & 1 == 1) {
                for row in 0..=self.extent[1][lane] {
                    for column in 0..=self.extent[0][lane] {
                        let pixel = [self.first[0][lane] + column, self.first[1][lane] + row];
                        let is_covered = |sample: &usize| {
                            let [x, y] =
                                [0, 1].map(|k| (pixel[k] << cells.cell_bits()) + cells.cells[*sample][k]);
                            (0..3).all(|k| edges.at(k, x, y) >= 0)
                        };
                        let covered = (0..cells.count).filter(is_covered).map(|s| 1 << s).sum();
                        if covered != 0 {
                            hits.push([lane as i32, pixel[0], pixel[1], covered]);
                        }
                    }
                }
            }
            hits
        }
    }

    /// A triangle that is at most `most` sub-pixels across and down, and has an area.
    fn triangle(most: i32) -> impl Strategy<Value = ScreenTriangle> {
        let corner = move || (0..=most, 0..=most);
        let corners = ([corner(), corner(), corner()], (0..1000, 0..1000));
        let triangle = corners.prop_map(|(p, (right, down))| ScreenTriangle {
            x: [p[0].0 + right, p[1].0 + right, p[2].0 + right],
            y: [p[0].1 + down, p[1].1 + down, p[2].1 + down],
            ..ScreenTriangle::default()
        });
        triangle.prop_filter("it has no area", |t| t.area() != 0)
    }

    proptest! {
        #[test]
        fn every_level_finds_the_samples_that_64_bits_find(
            small in prop::collection::vec(triangle(500), LANES),
            large in prop::collection::vec(triangle(MOST_EXTENT), LANES),
            corners in prop::collection::vec(prop::sample::select(vec![0, MOST_EXTENT]), 6 * LANES),
        ) {
            // As large as they may be, in the corners of their bounding boxes.
            let mut largest = large.clone();
            for (t, v) in largest.iter_mut().zip(corners.as_chunks::<6>().0) {
                let moved = ScreenTriangle { x: [v[0], v[1], v[2]], y: [v[3], v[4], v[5]], ..*t };
                if moved.area() != 0 {
                    *t = moved;
                }
            }
            for pattern in [SamplePattern::Center, SamplePattern::Sparse2, SamplePattern::Sparse4, SamplePattern::Ordered2x2] {
                for (triangles, is_tiny) in [(&small, true), (&large, false), (&largest, false)] {
                    let cells = pattern.cells();
                    let expected = Expected::new(triangles, &cells);
                    let fits = |limit: i32, lane: &usize| {
                        (0..2).all(|axis| (0..limit).contains(&expected.extent[axis][*lane]))
                    };
                    let limit = if is_tiny { 2 } else { MOST };
                    let lanes = (0..LANES).filter(|lane| fits(limit, lane)).map(|lane| 1 << lane).sum();
                    let mut hits = expected.hits(lanes, &cells);
                    hits.sort_unstable();
                    for level in SimdLevel::available() {
                        let mut few = FewHits::default();
                        let beyond = dispatch!(level.level().unwrap(), simd => {
                            let t = expected.set_up(simd, &cells);
                            few.scan(simd, &cells, &t, lanes, is_tiny, 5);
                            beyond(simd, &t)
                        });
                        prop_assert_eq!(beyond, 0);
                        let unpack = |&word: &i32| {
                            let place = word & 0xffff;
                            [word >> LANE_SHIFT & 15, place & 31, place >> 5, word >> COVERED_SHIFT & 15]
                        };
                        let mut found: Vec<[i32; 4]> = few.words[..few.count].iter().map(unpack).collect();
                        found.sort_unstable();
                        prop_assert_eq!(&found, &hits, "{:?}, {}", level, pattern);
                    }
                }
            }
        }

        #[test]
        fn triangles_that_extend_farther_are_left_out(t in triangle(4000)) {
            let cells = SamplePattern::Sparse4.cells();
            let expected = Expected::new(&[t; LANES], &cells);
            let extent = |v: [i32; 3]| v.iter().max().unwrap() - v.iter().min().unwrap();
            let is_beyond = extent(t.x).max(extent(t.y)) > MOST_EXTENT;
            for level in SimdLevel::available() {
                let found = dispatch!(level.level().unwrap(), simd => beyond(simd, &expected.set_up(simd, &cells)));
                prop_assert_eq!(found, if is_beyond { 0xffff } else { 0 });
            }
        }
    }
}
