//! The order in which a tile draws its clusters.

use crate::binning::BinnedCluster;

/// Steps of depth that are told apart. Within one, clusters keep the order in which they stand in memory: they
/// were put there along a space-filling curve, and memory that is read in order is read several times faster.
const STEPS: usize = 16;

/// Sorts clusters front to back, roughly.
#[derive(Debug, Default)]
pub struct DepthOrder {
    arrived: Vec<BinnedCluster>,
    sorted: Vec<BinnedCluster>,
}

impl DepthOrder {
    /// Sorts clusters that come in the order of memory.
    pub fn front_to_back<'a>(&mut self, clusters: impl Iterator<Item = &'a BinnedCluster>) {
        self.arrived.clear();
        self.arrived.extend(clusters);
        let (mut nearest, mut farthest) = (f32::NEG_INFINITY, f32::INFINITY);
        for cluster in &self.arrived {
            nearest = nearest.max(cluster.nearest);
            farthest = farthest.min(cluster.nearest);
        }
        // Without a range the factor is not finite, and every cluster falls into step 0.
        let factor = STEPS as f32 / (nearest - farthest);
        let step = |c: &BinnedCluster| (((nearest - c.nearest) * factor) as usize).min(STEPS - 1);
        let mut starts = [0; STEPS + 1];
        for cluster in &self.arrived {
            starts[step(cluster) + 1] += 1;
        }
        for i in 0..STEPS {
            starts[i + 1] += starts[i];
        }
        self.sorted.clear();
        self.sorted.resize(self.arrived.len(), BinnedCluster::default());
        for cluster in &self.arrived {
            let at = &mut starts[step(cluster)];
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
    fn nearer_steps_come_first_and_keep_their_order() {
        assert_eq!(sorted(&[0.0, 1.0, 0.99, 0.5, 0.51, 1.0]), [1, 2, 5, 4, 3, 0]);
    }

    #[test]
    fn clusters_of_one_depth_keep_their_order() {
        assert_eq!(sorted(&[0.25; 4]), [0, 1, 2, 3]);
        assert_eq!(sorted(&[]), [0; 0]);
    }
}
