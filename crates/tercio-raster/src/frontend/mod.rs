//! The front end, parallel over clusters: culls whole clusters and sorts the others into bins.
//!
//! [`cull`] classifies clusters, 16 at a time. Those that are small on the screen are binned as a whole; the back end
//! projects their vertices in each tile that draws them. The others are binned triangle by triangle: [`triangles`]
//! projects their vertices, culls triangles 16 at a time, clips those that cross the near plane or the guard band, and
//! bins the rest one by one.

mod cull;
mod load;
mod triangles;

use std::ops::Range;

use fearless_simd::Simd;
use tercio_mesh::cluster::{Cluster, MAX_TRIANGLES};

use crate::binning::{BinnedCluster, Bins};
use crate::context::FrameContext;
use crate::settings::{LastStage, Sorting};
use crate::simd::LANES;
use crate::stats::FrontEndCounts;
use cull::{ClusterLanes, ClusterTests, Placement};
pub use load::{divide_clusters, estimate as estimate_load};
use triangles::TrianglePass;

/// The output of one batch of clusters.
pub struct Batch<'a> {
    /// Clusters and triangles, sorted into tiles.
    pub bins: &'a mut Bins,
    /// Counts of what was received, culled and binned.
    pub counts: FrontEndCounts,
}

/// Clusters that overlap more tiles than this are binned triangle by triangle, because otherwise each of the tiles
/// would transform the whole cluster.
const MAX_TILES_PER_CLUSTER: u32 = 16;

/// Sorts ranges of the scene's clusters into the bins of a batch.
#[inline(always)]
pub fn run<S: Simd>(
    simd: S,
    context: &FrameContext,
    clusters: &[Range<u32>],
    bins: &mut Bins,
) -> FrontEndCounts {
    bins.clear();
    let batch = &mut Batch { bins, counts: FrontEndCounts::default() };
    let mut pass = TrianglePass::default();
    let mut lanes = ClusterLanes::default();
    for (instance, number, range) in clusters.iter().flat_map(|range| context.by_instance(range.clone())) {
        let mesh = &*context.scene.instances[instance].mesh;
        let sixteens = mesh.clusters()[range].chunks(LANES).zip((number..).step_by(LANES));
        for (clusters, number) in sixteens {
            sort_16(simd, context, instance, clusters, number, &mut pass, &mut lanes, batch);
        }
    }
    batch.bins.sort(&context.grid);
    batch.counts
}

/// Culls and sorts at most 16 clusters of one instance; the first is cluster `number` of the frame.
#[expect(clippy::too_many_arguments, reason = "one call site; a struct would only rename them")]
#[inline(always)]
fn sort_16<S: Simd>(
    simd: S,
    context: &FrameContext,
    instance: usize,
    clusters: &[Cluster],
    number: u32,
    pass: &mut TrianglePass,
    lanes: &mut ClusterLanes,
    batch: &mut Batch,
) {
    let object = &context.objects[instance];
    let (view, settings) = (&context.view, context.settings);
    let mut tests = ClusterTests::default();
    if settings.cluster_culling {
        let back =
            settings.cull.drops_clockwise(object.mirrored).map(|clockwise| clockwise != object.mirrored);
        lanes.load(clusters);
        tests = ClusterTests::new(simd, view, object, lanes, back, context.cells.origin);
    }
    for (lane, cluster) in clusters.iter().enumerate() {
        let is = |mask: u32| mask >> lane & 1 == 1;
        let triangles = u64::from(cluster.triangles);
        let counts = &mut batch.counts;
        counts.clusters_in += 1;
        counts.triangles_in += triangles;
        let placement = match settings.cluster_culling {
            true if is(tests.outside) => Placement::Outside,
            true if is(tests.inside) => Placement::Inside,
            true => cull::place(view, object, cluster),
            false => Placement::Crossing,
        };
        if placement == Placement::Outside {
            counts.clusters_outside += 1;
            counts.triangles_in_outside_clusters += triangles;
            continue;
        }
        if is(tests.one_side) {
            counts.clusters_facing += 1;
            counts.triangles_in_facing_clusters += triangles;
            continue;
        }
        if is(tests.no_sample) {
            counts.clusters_no_sample += 1;
            counts.triangles_no_sample += triangles;
            continue;
        }
        let rect = [0, 1, 2, 3].map(|k| tests.rect[k][lane] as u16);
        if is(tests.inside) && !context.grid.draws_some_of(rect) {
            counts.clusters_elsewhere += 1;
            counts.triangles_elsewhere += triangles;
            continue;
        }
        if settings.last_stage == LastStage::Cull {
            continue;
        }
        let number = number + lane as u32;
        let small = is(tests.small) && settings.sorting == Sorting::Clusters;
        if small && context.grid.tiles_of(rect) <= MAX_TILES_PER_CLUSTER {
            counts.clusters_out += 1;
            let nearest = tests.nearest[lane];
            batch.bins.push_cluster(&context.grid, BinnedCluster { number, nearest, rect });
            continue;
        }
        let slot = number * MAX_TRIANGLES as u32;
        let (_, cluster) = context.cluster(number);
        // Compiled as a function of its own at this SIMD level; inlining it into the loop does not make it faster.
        simd.vectorize(
            #[inline(always)]
            || pass.bin_cluster(simd, context, object, &cluster, slot, placement, batch),
        );
    }
}
