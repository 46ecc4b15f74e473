//! Which processor owns which part of the screen.

use serde::{Deserialize, Serialize};

use crate::workloads::PixelBox;

/// How regions are assigned to owners.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Assignment {
    /// Region k to owner k modulo the number of owners: neighbours have different owners.
    Interleaved,
    /// Runs of consecutive regions to one owner.
    Blocks,
}

/// The screen in square regions, row by row, each with an owner.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Regions {
    /// Pixels across the screen.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Pixels along the edge of a region.
    pub edge: u32,
    /// Owners.
    pub owners: usize,
    /// The assignment.
    pub assignment: Assignment,
}

impl Regions {
    /// The largest square regions of which there are at least as many as owners, reduced as far as the same number of
    /// rows and columns allows, so that those at the borders are not slivers.
    pub fn fitting(width: u32, height: u32, owners: usize, assignment: Assignment) -> Self {
        let regions = |edge: u32| u64::from(width.div_ceil(edge)) * u64::from(height.div_ceil(edge));
        let largest = (1..=width.max(height)).rev().find(|&e| regions(e) >= owners as u64).unwrap_or(1);
        let even = |side: u32| side.div_ceil(side.div_ceil(largest));
        let edge = even(width).max(even(height));
        Self { width, height, edge, owners: owners.max(1), assignment }
    }

    fn columns(&self) -> u64 {
        u64::from(self.width.div_ceil(self.edge))
    }

    /// All regions.
    pub fn count(&self) -> u64 {
        self.columns() * u64::from(self.height.div_ceil(self.edge))
    }

    /// The owner of a region.
    pub fn owner(&self, region: u64) -> usize {
        let owners = self.owners as u64;
        (match self.assignment {
            Assignment::Interleaved => region % owners,
            // At most 2^30 regions and as many owners: the product fits.
            Assignment::Blocks => region * owners / self.count(),
        }) as usize
    }

    /// The pixels of a region.
    pub fn pixels(&self, region: u64) -> PixelBox {
        let (column, row) = ((region % self.columns()) as u32, (region / self.columns()) as u32);
        let [x0, y0] = [column * self.edge, row * self.edge];
        let [x1, y1] = [(x0 + self.edge).min(self.width), (y0 + self.edge).min(self.height)];
        PixelBox { x0: x0 as i32, y0: y0 as i32, x1: x1 as i32 - 1, y1: y1 as i32 - 1 }
    }

    /// The number of pixels of every owner.
    pub fn owned(&self) -> Vec<u64> {
        let mut owned = vec![0; self.owners];
        (0..self.count()).for_each(|region| owned[self.owner(region)] += self.pixels(region).area());
        owned
    }

    /// Every region that a box touches, with the number of the box's pixels in it. The box is inside the screen.
    pub fn touched(&self, pixels: PixelBox) -> impl Iterator<Item = (u64, u64)> {
        let (edge, columns) = (self.edge as i32, self.columns());
        let parts = move |first: i32, last: i32| {
            (first / edge..=last / edge)
                .map(move |k| (k as u64, (last.min(k * edge + edge - 1) - first.max(k * edge) + 1) as u64))
        };
        parts(pixels.y0, pixels.y1).flat_map(move |(row, height)| {
            parts(pixels.x0, pixels.x1).map(move |(column, width)| (row * columns + column, width * height))
        })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn regions_fit_their_owners() {
        let r = Regions::fitting(1024, 1024, 1024, Assignment::Interleaved);
        assert_eq!((r.edge, r.count()), (32, 1024));
        assert_eq!(Regions::fitting(1024, 1024, 1 << 20, Assignment::Blocks).edge, 1);
        assert_eq!(Regions::fitting(100, 50, 1, Assignment::Blocks).edge, 100);
    }

    proptest! {
        #[test]
        fn parts_make_up_the_box(x in 0i32..90, y in 0i32..40, w in 0i32..40, h in 0i32..30, edge in 1u32..50) {
            let r = Regions { width: 130, height: 70, edge, owners: 7, assignment: Assignment::Blocks };
            let pixels = PixelBox { x0: x, y0: y, x1: x + w, y1: y + h };
            let parts: Vec<_> = r.touched(pixels).collect();
            prop_assert_eq!(parts.iter().map(|p| p.1).sum::<u64>(), pixels.area());
            prop_assert!(parts.iter().all(|p| p.0 < r.count() && p.1 > 0));
        }

        #[test]
        fn owners_share_evenly(owners in 1usize..60, edge in 1u32..40, blocks in any::<bool>()) {
            let assignment = if blocks { Assignment::Blocks } else { Assignment::Interleaved };
            let r = Regions { width: 130, height: 70, edge, owners, assignment };
            let mut counts = vec![0u64; owners];
            (0..r.count()).for_each(|k| counts[r.owner(k)] += 1);
            let (least, most) = (counts.iter().min().unwrap(), counts.iter().max().unwrap());
            prop_assert!(most - least <= 1, "{counts:?}");
        }
    }
}
