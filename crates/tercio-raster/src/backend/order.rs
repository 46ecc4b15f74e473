//! The order in which a tile draws its clusters.

use crate::binning::BinnedCluster;

/// Number of depth buckets. Within a bucket, clusters keep their order in memory: they are stored along a space-filling
/// curve, and sequential reads of memory are several times faster.
const DEPTH_BUCKETS: usize = 16;

/// Sorts clusters approximately front to back.
#[derive(Debug, Default)]
pub struct DepthOrder {
    unsorted: Vec<BinnedCluster>,
    sorted: Vec<BinnedCluster>,
}

impl DepthOrder {
    /// Sorts clusters that are given in memory order.
    pub fn front_to_back<'a>(&mut self, clusters: impl Iterator<Item = &'a BinnedCluster>) {
        self.unsorted.clear();
        self.unsorted.extend(clusters);
        let (mut nearest, mut farthest) = (f32::NEG_INFINITY, f32::INFINITY);
        for cluster in &self.unsorted {
            nearest = nearest.max(cluster.nearest);
            farthest = farthest.min(cluster.nearest);
        }
        // If all depths are equal, the factor is not finite, and every cluster falls into bucket 0.
        let factor = DEPTH_BUCKETS as f32 / (nearest - farthest);
        let bucket = |c: &BinnedCluster| (((nearest - c.nearest) * factor) as usize).min(DEPTH_BUCKETS - 1);
        let mut starts = [0; DEPTH_BUCKETS + 1];
        for cluster in &self.unsorted {
            starts[bucket(cluster) + 1] += 1;
        }
        for i in 0..DEPTH_BUCKETS {
            starts[i + 1] += starts[i];
        }
        self.sorted.clear();
        self.sorted.resize(self.unsorted.len(), BinnedCluster::default());
        for cluster in &self.unsorted {
            let at = &mut starts[bucket(cluster)];
            self.sorted[*at] = *cluster;
            *at += 1;
        }
    }

    /// The clusters in order.
    pub fn clusters(&self) -> &[BinnedCluster] {
        &self.sorted
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sorted(depths: &[f32]) -> Vec<u32> {
        let clusters: Vec<_> = (0..)
            .zip(depths)
            .map(|(number, &nearest)| BinnedCluster { number, nearest, ..BinnedCluster::default() })
            .collect();
        let mut order = DepthOrder::default();
        order.front_to_back(clusters.iter());
        order.clusters().iter().map(|c| c.number).collect()
    }

    #[test]
    fn nearer_buckets_come_first_and_keep_their_order() {
        assert_eq!(sorted(&[0.0, 1.0, 0.99, 0.5, 0.51, 1.0]), [1, 2, 5, 4, 3, 0]);
    }

    #[test]
    fn clusters_of_one_depth_keep_their_order() {
        assert_eq!(sorted(&[0.25; 4]), [0, 1, 2, 3]);
        assert_eq!(sorted(&[]), [0; 0]);
    }
}
