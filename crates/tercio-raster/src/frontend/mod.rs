//! The front end, parallel over clusters: cull, transform, snap, drop what reaches no sample, clip, bin.
//!
//! [`cull`] places whole clusters, [`transform`] brings their vertices to the screen, [`triangles`] looks at
//! their triangles 16 at a time and hands the survivors to the bins; [`clip`] is for the few that cross the
//! near plane or the guard band.

pub mod clip;
pub mod cull;
pub mod transform;
pub mod triangles;

use std::ops::Range;

use fearless_simd::Simd;
use tercio_mesh::cluster::MAX_TRIANGLES;

use crate::binning::Bins;
use crate::context::FrameContext;
use crate::stats::FrontEndCounts;
use cull::Placement;
use triangles::ClusterPass;

/// What one batch of clusters made.
#[derive(Debug, Default)]
pub struct Batch {
    /// The triangles, sorted into tiles.
    pub bins: Bins,
    /// What happened to the rest.
    pub counts: FrontEndCounts,
}

/// Draws a range of the scene's clusters into the bins of a batch.
#[inline(always)]
pub fn run<S: Simd>(simd: S, context: &FrameContext, clusters: Range<u32>, batch: &mut Batch) {
    batch.bins.clear();
    batch.counts = FrontEndCounts::default();
    let mut pass = ClusterPass::default();
    for number in clusters {
        let (instance, index) = context.locate(number);
        let mesh = &*context.scene.instances[instance].mesh;
        let cluster = &mesh.clusters[index];
        let object = &context.objects[instance];
        let triangles = u64::from(cluster.triangles);
        let counts = &mut batch.counts;
        counts.clusters_in += 1;
        counts.triangles_in += triangles;
        let mut placement = Placement::Crossing;
        if context.settings.cluster_culling {
            placement = cull::place(&context.view, object, cluster);
            if placement == Placement::Outside {
                counts.clusters_outside += 1;
                counts.triangles_in_outside_clusters += triangles;
                continue;
            }
            let dropped = context.settings.cull.drops_clockwise(object.mirrored);
            if placement == Placement::Inside
                && dropped.is_some_and(|clockwise| {
                    cull::shows_one_side(&context.view, object, cluster, clockwise != object.mirrored)
                })
            {
                counts.clusters_facing += 1;
                counts.triangles_in_facing_clusters += triangles;
                continue;
            }
        }
        let first_slot = number * MAX_TRIANGLES as u32;
        // Compiled on its own at this SIMD level; inlining it into the loop gains nothing.
        simd.vectorize(
            #[inline(always)]
            || pass.draw(simd, context, object, mesh, cluster, first_slot, placement, batch),
        );
    }
    batch.bins.sort(&context.grid);
}
