//! The weights of a filter that is wider than a pixel.

use super::{Filter, SampleCells, Sampling};
use crate::conventions::{SAMPLE, SUBPIXELS};

/// A sample that contributes to a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tap {
    /// Its pixel, relative to the filtered one: columns to the right, rows downwards.
    pub pixel: [i32; 2],
    /// Its number in its pixel.
    pub sample: usize,
    /// Its weight, a whole number. The sum of all weights of a filter is below 2^24, so that sums of weights are exact.
    pub weight: f32,
}

/// The samples that contribute to a pixel: its neighbours' row by row, each pixel's by number.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FilterWeights {
    /// Empty if the filter is the mean of the pixel's own samples.
    pub taps: Vec<Tap>,
}

impl FilterWeights {
    /// The weights of a sampling's filter.
    pub fn new(sampling: &Sampling) -> Self {
        let halo = sampling.halo() as i32;
        if halo == 0 || sampling.filter == Filter::Box {
            return Self::default();
        }
        let cells = sampling.pattern.cells();
        let neighbours = (-halo..=halo).flat_map(|y| (-halo..=halo).map(move |x| [x, y]));
        let taps = neighbours.flat_map(|pixel| (0..cells.count).map(move |sample| (pixel, sample)));
        let weighted = taps.map(|(pixel, sample)| Tap { pixel, sample, weight: tent(&cells, pixel, sample) });
        Self { taps: weighted.filter(|tap| tap.weight > 0.0).collect() }
    }
}

/// The product of the linear weights across and down, in square sub-pixels.
fn tent(cells: &SampleCells, pixel: [i32; 2], sample: usize) -> f32 {
    let offset = cells.offset(sample);
    let along = |k: usize| SUBPIXELS - (pixel[k] * SUBPIXELS + offset[k] - SAMPLE).abs();
    (along(0).max(0) * along(1).max(0)) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::SamplePattern;

    #[test]
    fn the_weights_of_a_tent_are_exact_and_balanced() {
        for pattern in SamplePattern::ALL.into_iter().skip(1) {
            let sampling = Sampling { filter: Filter::Tent, ..Sampling::of(pattern) };
            let taps = FilterWeights::new(&sampling).taps;
            let total: f64 = taps.iter().map(|t| f64::from(t.weight)).sum();
            assert!(total < f64::from(1 << 24), "{pattern}");
            let cells = pattern.cells();
            for axis in 0..2 {
                let moment: f64 = taps
                    .iter()
                    .map(|t| {
                        let at = t.pixel[axis] * SUBPIXELS + cells.offset(t.sample)[axis] - SAMPLE;
                        f64::from(t.weight) * f64::from(at)
                    })
                    .sum();
                // The centre of gravity is within a hundredth of a pixel of the middle.
                assert!((moment / total).abs() < 2.56, "{pattern}: {}", moment / total);
            }
        }
    }
}
