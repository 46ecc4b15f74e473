//! How far a mesh reaches in a direction.

use crate::loops::prelude::*;
use glam::DVec3;

use super::{Cluster, ClusteredMesh};

/// Clusters of a group. Neighbours in the order of the mesh are near each other, so that the box of a group is small.
const GROUP: usize = 64;
/// Groups that one thread looks at, at least.
const GROUPS_OF_THREAD: usize = 1 << 12;

/// A box: its lower and its upper corner.
pub(crate) type Corners = [[f32; 3]; 2];

impl ClusteredMesh {
    /// The largest `direction . p` of all vertices `p`, in the coordinates of the positions (relative to `origin`, in units of
    /// 2^`exponent`); minus infinity if there are none. The same however the mesh is split into clusters.
    pub fn farthest(&self, direction: DVec3) -> f64 {
        let d = direction.to_array();
        // All sums run in the same order, so that no vertex is outside its box after rounding.
        let of_box = |[min, max]: Corners| {
            let far = |k: usize| d[k] * f64::from(if d[k] < 0.0 { min[k] } else { max[k] });
            far(0) + far(1) + far(2)
        };
        let of_cluster = |number: usize| {
            let [x, y, z] = self.cluster(number).positions();
            (0..x.len()).fold(f64::NEG_INFINITY, |best, i| {
                let p = [x[i], y[i], z[i]].map(f64::from);
                best.max(d[0] * p[0] + d[1] * p[1] + d[2] * p[2])
            })
        };
        let clusters = self.clusters();
        let of_group = |group: usize, start: f64| {
            let first = group * GROUP;
            let of_this = clusters.iter().enumerate().skip(first).take(GROUP);
            of_this.fold(start, |best, (number, cluster)| {
                if of_box(corners(cluster)) > best { best.max(of_cluster(number)) } else { best }
            })
        };
        // Begins with the box that reaches farthest: then few others need a test of what is in them.
        let groups = || self.groups().par_iter().enumerate().with_min_len(GROUPS_OF_THREAD);
        let far = groups().map(|(group, &of)| (group, of_box(of))).max_by(|a, b| a.1.total_cmp(&b.1));
        let Some((first, _)) = far else { return f64::NEG_INFINITY };
        let of_first = (first * GROUP..clusters.len()).take(GROUP);
        let farthest =
            of_first.max_by(|&a, &b| of_box(corners(&clusters[a])).total_cmp(&of_box(corners(&clusters[b]))));
        let start = of_group(first, farthest.map_or(f64::NEG_INFINITY, of_cluster));
        let look = |best: f64, (group, &of): (usize, &Corners)| {
            if of_box(of) > best { of_group(group, best) } else { best }
        };
        groups().fold(|| start, look).reduce(|| start, f64::max)
    }

    /// A vertex that is [farthest](Self::farthest) in a direction; none if there are none, or none that is finite.
    pub fn farthest_vertex(&self, direction: DVec3) -> Option<[f32; 3]> {
        let (most, d) = (self.farthest(direction), direction.to_array());
        let along = |p: [f32; 3]| {
            let p = p.map(f64::from);
            d[0] * p[0] + d[1] * p[1] + d[2] * p[2]
        };
        let reaches = |[min, max]: Corners| {
            along(std::array::from_fn(|k| if d[k] < 0.0 { min[k] } else { max[k] })) >= most
        };
        let groups = self.groups().iter().enumerate().filter(|(_, of)| reaches(**of));
        let mut clusters = groups
            .flat_map(|(group, _)| (group * GROUP..self.clusters().len()).take(GROUP))
            .filter(|&number| reaches(corners(&self.clusters()[number])));
        clusters.find_map(|number| {
            let cluster = self.cluster(number);
            (0..cluster.vertices()).map(|v| cluster.position(v)).find(|&p| along(p) == most)
        })
    }

    /// The boxes of [`GROUP`] clusters each.
    fn groups(&self) -> &[Corners] {
        self.groups.get_or_init(|| {
            let union = |a: Corners, b: Corners| {
                let [mut min, mut max] = a;
                for k in 0..3 {
                    (min[k], max[k]) = (min[k].min(b[0][k]), max[k].max(b[1][k]));
                }
                [min, max]
            };
            let of = |group: &[Cluster]| {
                let none = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
                group.iter().map(corners).fold(none, union)
            };
            self.clusters().par_chunks(GROUP).with_min_len(GROUP).map(of).collect()
        })
    }
}

fn corners(cluster: &Cluster) -> Corners {
    [cluster.min, cluster.max]
}

#[cfg(test)]
mod tests {
    use std::sync::LazyLock;

    use proptest::prelude::*;

    use super::*;
    use crate::builtin;
    use crate::cluster::shuffle::shuffle;
    use crate::cluster::{PartitionOptions, partition};

    fn of_all_vertices(mesh: &ClusteredMesh, d: DVec3) -> f64 {
        let positions =
            mesh.views().flat_map(|c| (0..c.vertices()).map(move |v| c.position(v)).collect::<Vec<_>>());
        positions
            .map(|p| d.x * f64::from(p[0]) + d.y * f64::from(p[1]) + d.z * f64::from(p[2]))
            .fold(f64::NEG_INFINITY, f64::max)
    }

    /// A mesh, and the same with its clusters in another order, so that others make up a group. The groups of the first are known
    /// when it is shuffled.
    static MESHES: LazyLock<[ClusteredMesh; 2]> = LazyLock::new(|| {
        let mesh = partition(builtin::make("builtin:terrain@40k").unwrap(), &PartitionOptions::default());
        assert!(mesh.clusters().len() > 3 * GROUP);
        mesh.groups();
        let shuffled = shuffle(&mesh, 7);
        [mesh, shuffled]
    });

    proptest! {
        #[test]
        fn the_farthest_of_all_vertices(direction: [i8; 3]) {
            let d = DVec3::from_array(direction.map(f64::from)) / 7.0;
            for mesh in &*MESHES {
                prop_assert_eq!(mesh.farthest(d), of_all_vertices(mesh, d));
                let vertex = DVec3::from(mesh.farthest_vertex(d).unwrap().map(f64::from));
                prop_assert!((d.dot(vertex) - mesh.farthest(d)).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn nothing_reaches_nowhere() {
        assert_eq!(ClusteredMesh::default().farthest(DVec3::X), f64::NEG_INFINITY);
        assert_eq!(ClusteredMesh::default().farthest_vertex(DVec3::X), None);
    }
}
