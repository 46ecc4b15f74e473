//! Palettes of 256 colours, and dithering with them.
//!
//! Colours are counted in cells of four 8-bit steps. The set of cells is split by medians of variance (each time the part
//! whose split reduces the squared error most, across its axis of largest variance, at its mean), as in Wu's quantizer. The
//! ordered dithering is the same at the same pixel of every picture, so that what does not move does not flicker.

/// Bits of a channel that tell cells apart.
const BITS: u32 = 6;
/// Colours of a palette.
const COLORS: usize = 256;

/// A palette.
#[derive(Debug)]
pub(super) struct Palette {
    colors: Vec<[u8; 3]>,
    /// Half of the typical distance between colours of the palette, in 8-bit steps: how much dithering adds at most.
    spread: i32,
}

/// The pixels of a cell.
#[derive(Clone, Copy, Debug, Default)]
struct Cell {
    count: u64,
    sum: [u64; 3],
}

impl Cell {
    fn mean(&self) -> [f64; 3] {
        self.sum.map(|s| s as f64 / self.count.max(1) as f64)
    }
}

/// A set of cells.
struct Part {
    cells: Vec<Cell>,
    mean: [f64; 3],
    /// The axis of largest variance, and the squared error along it.
    axis: usize,
    error: f64,
}

impl Part {
    fn new(cells: Vec<Cell>) -> Self {
        let count = cells.iter().map(|c| c.count).sum::<u64>().max(1) as f64;
        let mut mean = [0.0; 3];
        cells.iter().for_each(|c| (0..3).for_each(|k| mean[k] += c.sum[k] as f64 / count));
        let mut errors = [0.0; 3];
        for cell in &cells {
            let of_cell = cell.mean();
            (0..3).for_each(|k| errors[k] += cell.count as f64 * (of_cell[k] - mean[k]).powi(2));
        }
        let axis = (0..3).fold(0, |best, k| if errors[k] > errors[best] { k } else { best });
        Self { axis, error: errors[axis], mean, cells }
    }

    fn split(self) -> [Self; 2] {
        let (axis, mean) = (self.axis, self.mean[self.axis]);
        let (below, above) = self.cells.into_iter().partition(|c| c.mean()[axis] < mean);
        [below, above].map(Self::new)
    }
}

fn cell_of(color: [u8; 3]) -> usize {
    color.iter().fold(0, |cell, &v| cell << BITS | usize::from(v >> (8 - BITS)))
}

impl Palette {
    /// A palette for these pixels.
    pub fn of(pixels: &[[u8; 4]]) -> Self {
        let mut cells = vec![Cell::default(); 1 << (3 * BITS)];
        for &[r, g, b, _] in pixels {
            let cell = &mut cells[cell_of([r, g, b])];
            cell.count += 1;
            [r, g, b].iter().zip(&mut cell.sum).for_each(|(&v, sum)| *sum += u64::from(v));
        }
        cells.retain(|cell| cell.count > 0);
        let mut parts = vec![Part::new(cells)];
        while parts.len() < COLORS {
            let worst = (0..parts.len()).max_by(|&a, &b| parts[a].error.total_cmp(&parts[b].error));
            let Some(worst) = worst.filter(|&worst| parts[worst].error > 0.0) else { break };
            let [below, above] = parts.swap_remove(worst).split();
            if below.cells.is_empty() || above.cells.is_empty() {
                // Rounding: nothing is left to be split.
                parts.push(Part { error: 0.0, ..if below.cells.is_empty() { above } else { below } });
                continue;
            }
            parts.extend([below, above]);
        }
        let colors: Vec<[u8; 3]> = parts.iter().map(|part| part.mean.map(|v| v.round() as u8)).collect();
        let distances = colors.iter().map(|&a| {
            let others = colors.iter().filter(|&&b| b != a).map(|&b| distance(a, b));
            others.min().map_or(0.0, |d| f64::from(d).sqrt())
        });
        let mean = distances.sum::<f64>() / colors.len().max(1) as f64;
        Self { colors, spread: ((mean * 0.5) as i32).clamp(0, 16) }
    }

    pub fn colors(&self) -> &[[u8; 3]] {
        &self.colors
    }

    /// The number of a palette's colour for each pixel.
    pub fn dithered(&self, pixels: &[[u8; 4]], width: usize) -> Vec<u8> {
        let mut nearest = vec![u16::MAX; 1 << (3 * BITS)];
        let mut index = |color: [u8; 3]| {
            let slot = &mut nearest[cell_of(color)];
            if *slot == u16::MAX {
                let center = color.map(|v| v >> (8 - BITS) << (8 - BITS) | 1 << (7 - BITS));
                let best = (0..self.colors.len()).min_by_key(|&i| distance(self.colors[i], center));
                *slot = best.unwrap_or(0) as u16;
            }
            *slot as u8
        };
        let rows = pixels.chunks(width.max(1)).enumerate();
        let of_row = |(y, row): (usize, &[[u8; 4]])| {
            let shifted = |(x, p): (usize, &[u8; 4])| {
                // -1/2 to 1/2 of the spread on both sides.
                let shift = (threshold(x, y) * 2 - 63) * self.spread / 64;
                [p[0], p[1], p[2]].map(|v| (i32::from(v) + shift).clamp(0, 255) as u8)
            };
            row.iter().enumerate().map(shifted).collect::<Vec<_>>()
        };
        rows.flat_map(of_row).map(&mut index).collect()
    }
}

fn distance(a: [u8; 3], b: [u8; 3]) -> u32 {
    (0..3).map(|k| u32::from(a[k].abs_diff(b[k])).pow(2)).sum()
}

/// Bayer's matrix of 8 x 8 thresholds, 0 to 63.
fn threshold(x: usize, y: usize) -> i32 {
    let bits = |n: usize| [n & 1, n >> 1 & 1, n >> 2 & 1];
    let (a, b) = (bits(x ^ y), bits(y));
    (0..3).fold(0, |value, k| value | (a[k] << 1 | b[k]) << (2 * (2 - k))) as i32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_colors_stay_what_they_are() {
        let colors: Vec<[u8; 4]> = (0..=255).map(|v| [v / 8 * 8, 255 - v / 16 * 16, 7, 255]).collect();
        let palette = Palette::of(&colors);
        let indices = palette.dithered(&colors, 16);
        assert!(palette.colors().len() <= 32);
        for (index, color) in indices.iter().zip(&colors) {
            let found = palette.colors()[usize::from(*index)];
            assert!((0..3).all(|k| found[k].abs_diff(color[k]) <= 16), "{found:?} for {color:?}");
        }
        assert_eq!(Palette::of(&[[9, 8, 7, 255]; 5]).colors(), [[9, 8, 7]]);
    }

    #[test]
    fn every_threshold_is_used_once() {
        let mut all: Vec<i32> = (0..64).map(|i| threshold(i % 8, i / 8)).collect();
        // Neighbours are far apart.
        assert!((threshold(0, 0) - threshold(1, 0)).abs() >= 16);
        all.sort_unstable();
        assert_eq!(all, (0..64).collect::<Vec<_>>());
    }
}
