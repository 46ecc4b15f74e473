//! The front end, parallel over clusters: cull whole clusters and sort the others into the bins.
//!
//! [`cull`] places clusters, 16 at a time. Those that are small on the screen go into the bins as they are; the
//! back end projects them where they are drawn. Of the others [`triangles`] projects the vertices, tests the triangles
//! 16 at a time and sorts those that are left into the bins one by one, clipped where they cross the near plane or the
//! guard band.

mod cull;
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
use triangles::TrianglePass;

/// Where one batch of clusters goes.
pub struct Batch<'a> {
    /// Clusters and triangles, sorted into tiles.
    pub bins: &'a mut Bins,
    /// What happened to the rest.
    pub counts: FrontEndCounts,
}

/// Clusters that reach into more tiles than this have their triangles sorted one by one: each of the tiles would
/// transform all of them.
const MOST_TILES: u32 = 16;

/// Sorts a range of the scene's clusters into the bins of a batch.
#[inline(always)]
pub fn run<S: Simd>(
    simd: S,
    context: &FrameContext,
    clusters: Range<u32>,
    bins: &mut Bins,
) -> FrontEndCounts {
    bins.clear();
    let batch = &mut Batch { bins, counts: FrontEndCounts::default() };
    let mut pass = TrianglePass::default();
    let mut lanes = ClusterLanes::default();
    for (instance, number, range) in context.by_instance(clusters) {
        let mesh = &*context.scene.instances[instance].mesh;
        let sixteens = mesh.clusters()[range].chunks(LANES).zip((number..).step_by(LANES));
        for (clusters, number) in sixteens {
            sort_16(simd, context, instance, clusters, number, &mut pass, &mut lanes, batch);
        }
    }
    batch.bins.sort(&context.grid);
    batch.counts
}

/// Sorts at most 16 clusters of one instance, of which the first has this number in the frame.
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
        tests = ClusterTests::new(simd, view, object, lanes, back);
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
        if small && context.grid.tiles_of(rect) <= MOST_TILES {
            counts.clusters_out += 1;
            let nearest = tests.nearest[lane];
            batch.bins.push_cluster(&context.grid, BinnedCluster { number, nearest, rect });
            continue;
        }
        let slot = number * MAX_TRIANGLES as u32;
        let (_, cluster) = context.cluster(number);
        // Compiled on its own at this SIMD level; inlining it into the loop gains nothing.
        simd.vectorize(
            #[inline(always)]
            || pass.draw(simd, context, object, &cluster, slot, placement, batch),
        );
    }
}
