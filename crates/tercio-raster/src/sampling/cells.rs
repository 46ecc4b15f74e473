//! The positions of samples as cells of a grid that divides every pixel.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16};

use crate::conventions::{SUBPIXEL_BITS, SUBPIXELS};
use crate::simd::{LANES, lookup_128, part};

/// The largest number of samples per pixel.
pub const MAX_SAMPLES: usize = 16;

/// The samples of a pixel, in the middle of some of the cells of a square grid that divides the pixel. Cells of all
/// pixels together are one grid over the picture, on which edge functions are evaluated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SampleCells {
    /// Number of samples, a power of two.
    pub count: usize,
    /// log2 of the edge of a cell, in sub-pixels.
    pub pitch_bits: u32,
    /// Distance of the middle of a cell from its left and upper border, in sub-pixels.
    pub origin: i32,
    /// Column and row of each sample's cell in the pixel; those from number `count` on are 0.
    pub cells: [[i32; 2]; MAX_SAMPLES],
}

impl SampleCells {
    /// One sample in the middle.
    pub const CENTER: Self =
        Self { count: 1, pitch_bits: SUBPIXEL_BITS, origin: SUBPIXELS / 2, cells: [[0; 2]; MAX_SAMPLES] };

    /// N samples in N by N cells, given by the column of the sample in each row.
    pub(super) fn sparse<const N: usize>(columns: [i32; N]) -> Self {
        let mut found = Self::of_grid(N, N);
        for (row, column) in columns.into_iter().enumerate() {
            found.cells[row] = [column, row as i32];
        }
        found
    }

    /// All of `edge` by `edge` cells.
    pub(super) fn ordered(edge: usize) -> Self {
        let mut found = Self::of_grid(edge, edge * edge);
        for (number, cell) in found.cells.iter_mut().enumerate().take(edge * edge) {
            *cell = [number % edge, number / edge].map(|c| c as i32);
        }
        found
    }

    fn of_grid(edge: usize, count: usize) -> Self {
        let pitch = SUBPIXELS / edge as i32;
        Self { count, pitch_bits: pitch.trailing_zeros(), origin: pitch / 2, cells: [[0; 2]; MAX_SAMPLES] }
    }

    /// log2 of the number of samples.
    #[inline(always)]
    pub fn count_bits(&self) -> u32 {
        self.count.trailing_zeros()
    }

    /// Bit i is set if there is a sample i.
    #[inline(always)]
    pub fn mask(&self) -> u32 {
        (1 << self.count) - 1
    }

    /// log2 of the number of cells along the edge of a pixel.
    #[inline(always)]
    pub fn cell_bits(&self) -> u32 {
        SUBPIXEL_BITS - self.pitch_bits
    }

    /// A sample's distance from the left and upper border of its pixel, in sub-pixels.
    ///
    /// # Panics
    /// If the number is 16 or more.
    #[inline(always)]
    pub fn offset(&self, sample: usize) -> [i32; 2] {
        self.cells[sample].map(|cell| (cell << self.pitch_bits) + self.origin)
    }

    /// The centre of some samples, rounded to whole sub-pixels (half of one upwards), as a distance from the left and
    /// upper border of the pixel. Bit i of the mask is sample i.
    ///
    /// # Panics
    /// If the mask is 0.
    pub fn center(&self, mask: u32) -> [i32; 2] {
        let mut sum = [0; 2];
        let mut left = mask;
        while left != 0 {
            let [x, y] = self.cells[left.trailing_zeros() as usize % MAX_SAMPLES];
            sum = [sum[0] + x, sum[1] + y];
            left &= left - 1;
        }
        let count = mask.count_ones() as i32;
        sum.map(|sum| ((2 * (sum << self.pitch_bits) + count) / (2 * count)) + self.origin)
    }
}

/// The centres of all sets of samples as tables: [`SampleCells::center`], faster.
#[derive(Clone, Debug)]
pub struct SampleCenters {
    cells: SampleCells,
    /// The centres of the sets of the first 7 samples, relative to the middle of the pixel: x in the lower 16 bits, y in the
    /// upper.
    centers: [i32; 128],
    /// For the sets of the first and of the last 8 samples: the sums of the columns and of the rows of their cells, and their
    /// number, from bit 0, [`ROW_SHIFT`] and [`COUNT_SHIFT`] on.
    sums: [[i32; 256]; 2],
}

/// Lowest bits of a sum of rows and of a number of samples.
const ROW_SHIFT: u32 = 12;
const COUNT_SHIFT: u32 = 24;

impl SampleCenters {
    /// The tables of a pattern.
    pub fn new(cells: &SampleCells) -> Self {
        let mut centers = [0; 128];
        for mask in 1..=cells.mask().min(127) {
            let [x, y] = cells.center(mask).map(|c| c - SUBPIXELS / 2);
            centers[mask as usize] = (x & 0xffff) | y << 16;
        }
        let mut sums = [[0; 256]; 2];
        for (half, sums) in sums.iter_mut().enumerate() {
            for mask in 1..256_usize {
                let sample = mask.trailing_zeros() as usize;
                let [column, row] = cells.cells[8 * half + sample];
                sums[mask] = sums[mask & (mask - 1)] + column + (row << ROW_SHIFT) + (1 << COUNT_SHIFT);
            }
        }
        Self { cells: *cells, centers, sums }
    }

    /// [`SampleCells::center`], relative to the middle of the pixel.
    #[inline(always)]
    pub fn from_middle(&self, mask: u16) -> [i32; 2] {
        if let Some(&center) = self.centers.get(usize::from(mask)) {
            return [center << 16 >> 16, center >> 16];
        }
        let [low, high] = mask.to_le_bytes().map(usize::from);
        let sums = self.sums[0][low] + self.sums[1][high];
        let count = sums >> COUNT_SHIFT;
        let of_axis = |sum: i32| {
            (2 * (sum << self.cells.pitch_bits) + count) / (2 * count) + (self.cells.origin - SUBPIXELS / 2)
        };
        [of_axis(sums & 0xfff), of_axis(sums >> ROW_SHIFT & 0xfff)]
    }

    /// [`SampleCenters::from_middle`] of 16 sets, none of them empty.
    #[inline(always)]
    pub fn of_sixteen<S: Simd>(&self, simd: S, masks: i32x16<S>) -> [i32x16<S>; 2] {
        if self.cells.count < 8 {
            let center = lookup_128(simd, &self.centers, masks);
            return [(center << 16) >> 16, center >> 16];
        }
        let (mut sums, masks) = ([0; LANES], masks.to_array());
        for lane in 0..LANES {
            let [low, high, ..] = masks[lane].to_le_bytes();
            sums[lane] = self.sums[0][usize::from(low)] + self.sums[1][usize::from(high)];
        }
        part(
            simd,
            #[inline(always)]
            || {
                let sums = i32x16::load_array(simd, sums);
                let count = sums >> COUNT_SHIFT;
                let to_middle = self.cells.origin - SUBPIXELS / 2;
                // The quotient of whole numbers below 2^13 is truncated correctly: unless it is whole, it is farther from
                // the next whole number than its rounding error.
                let divisor: f32x16<S> = (count << 1).to_float();
                let double = self.cells.pitch_bits + 1;
                let x: f32x16<S> = (((sums & 0xfff) << double) + count).to_float();
                let y: f32x16<S> = ((((sums >> ROW_SHIFT) & 0xfff) << double) + count).to_float();
                [
                    (x / divisor).to_int::<i32x16<S>>() + to_middle,
                    (y / divisor).to_int::<i32x16<S>>() + to_middle,
                ]
            },
        )
    }
}

#[cfg(test)]
mod tests {
    use crate::dispatch;
    use fearless_simd::prelude::*;

    use super::*;
    use crate::conventions::SAMPLE;
    use crate::sampling::SamplePattern;
    use crate::simd::SimdLevel;

    #[test]
    fn sparse_patterns_have_one_sample_in_each_row_and_column_far_from_each_other() {
        use SamplePattern as P;
        // The smallest distance of two samples, also across the borders of pixels, as a square in cells.
        for (pattern, expected) in [(P::Sparse2, 2), (P::Sparse4, 2), (P::Sparse8, 8), (P::Sparse16, 13)] {
            let cells = pattern.cells();
            let n = cells.count as i32;
            for axis in 0..2 {
                let mut used: Vec<i32> = cells.cells[..cells.count].iter().map(|cell| cell[axis]).collect();
                used.sort_unstable();
                assert_eq!(used, (0..n).collect::<Vec<_>>(), "{pattern}");
            }
            let mut least = i32::MAX;
            for a in 0..cells.count {
                for b in 0..a {
                    let apart = [0, 1].map(|k| (cells.cells[a][k] - cells.cells[b][k]).abs());
                    let [x, y] = apart.map(|d| d.min(n - d));
                    least = least.min(x * x + y * y);
                }
            }
            assert_eq!(least, expected, "{pattern}");
        }
    }

    #[test]
    fn the_centre_of_all_samples_is_the_middle_of_the_pixel() {
        for pattern in SamplePattern::ALL {
            let cells = pattern.cells();
            assert_eq!(cells.center(cells.mask()), [SAMPLE; 2], "{pattern}");
            assert_eq!(pattern.name().parse(), Ok(pattern));
            for sample in 0..cells.count {
                assert_eq!(cells.center(1 << sample), cells.offset(sample), "{pattern}");
            }
        }
        assert!("3".parse::<SamplePattern>().is_err());
    }

    #[test]
    fn tables_have_the_centres_of_all_sets_of_samples() {
        for pattern in SamplePattern::ALL {
            let cells = pattern.cells();
            let centers = SampleCenters::new(&cells);
            for mask in 1..=cells.mask() {
                let expected = cells.center(mask).map(|c| c - SAMPLE);
                assert_eq!(centers.from_middle(mask as u16), expected, "{pattern}, {mask:b}");
            }
        }
    }

    #[test]
    fn every_simd_level_has_the_same_centres() {
        for level in SimdLevel::available() {
            let level = level.level().unwrap();
            for pattern in SamplePattern::ALL {
                let (cells, centers) = (pattern.cells(), SampleCenters::new(&pattern.cells()));
                for first in (1..=cells.mask()).step_by(LANES) {
                    let masks: [i32; LANES] =
                        std::array::from_fn(|lane| (first + lane as u32).min(cells.mask()) as i32);
                    let [x, y] = dispatch!(level, simd => {
                        let [x, y] = centers.of_sixteen(simd, i32x16::load_array(simd, masks));
                        [x.to_array(), y.to_array()]
                    });
                    for lane in 0..LANES {
                        let expected = centers.from_middle(masks[lane] as u16);
                        assert_eq!([x[lane], y[lane]], expected, "{pattern}, {:b}", masks[lane]);
                    }
                }
            }
        }
    }

    #[test]
    fn the_centre_of_some_samples_is_rounded() {
        // Offsets 32, 96, 160, 224: rows 0, 1 and 3 have a mean of 117 1/3.
        let cells = SamplePattern::Sparse4.cells();
        let mask = 0b1011;
        let mean = |axis: usize| {
            let sum: i32 = [0, 1, 3].iter().map(|&s| cells.offset(s)[axis]).sum();
            (f64::from(sum) / 3.0).round() as i32
        };
        assert_eq!(cells.center(mask), [mean(0), mean(1)]);
    }
}
