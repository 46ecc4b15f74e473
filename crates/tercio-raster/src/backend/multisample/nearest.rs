//! What is nearest in the pixels of a tile in which all that is drawn is opaque.

use fearless_simd::Simd;

use crate::simd::LANES;
use crate::view::View;

/// What is nearest in each of 16 pixels, if all that is drawn is opaque.
#[derive(Default)]
pub struct NearestOfRow {
    /// Its depth, 0 where nothing was drawn.
    pub depth: [f32; LANES],
    /// Its fragment, or [`NO_FRAGMENT`](super::fragments::NO_FRAGMENT).
    pub fragment: [u32; LANES],
    /// The pixels in which several fragments have that depth, one bit each.
    pub undecided: u32,
}

impl NearestOfRow {
    /// Finds it among the N samples of each pixel. Not inlined, so that it is compiled only once per SIMD level.
    #[inline(never)]
    pub fn find<S: Simd, const N: usize>(&mut self, simd: S, depths: &[f32], fragments: &[u32]) {
        simd.vectorize(
            #[inline(always)]
            || {
                let pixels = depths.as_chunks::<N>().0.iter().zip(fragments.as_chunks::<N>().0);
                for (lane, (depths, fragments)) in pixels.enumerate().take(LANES) {
                    let (mut nearest, mut fragment) = (depths[0], fragments[0]);
                    for sample in 1..N {
                        let is_nearer = depths[sample] > nearest;
                        nearest = if is_nearer { depths[sample] } else { nearest };
                        fragment = if is_nearer { fragments[sample] } else { fragment };
                    }
                    let mut is_undecided = false;
                    for sample in 0..N {
                        is_undecided |= depths[sample] == nearest && fragments[sample] != fragment;
                    }
                    self.depth[lane] = nearest;
                    self.fragment[lane] = fragment;
                    self.undecided |= u32::from(is_undecided) << lane;
                }
            },
        );
    }

    /// Writes the distances of pixels in which something was drawn.
    #[inline(always)]
    pub fn write_distances(&self, view: &View, to: &mut [f32]) {
        let mut distances = [f32::INFINITY; LANES];
        distances[..to.len()].copy_from_slice(to);
        for (distance, &depth) in distances.iter_mut().zip(&self.depth) {
            *distance = if depth > 0.0 { view.distance(depth) } else { *distance };
        }
        to.copy_from_slice(&distances[..to.len()]);
    }
}
