//! Estimates of the work in each tile, and of each cluster, from the bounds of some of the clusters: ranks that divide the picture, or
//! the scene, among themselves need them before anything is drawn.

use crate::cluster_set::{self, ClusterSet};
use crate::context::FrameContext;
use crate::survey::{Effort, Survey, WORK_OF_PIXEL};

/// Estimates the work in each tile: triangles that are not hidden, and pixels that they cover, in units of a triangle. Tiles
/// that seem to be empty have 0. The same on every machine, and for every number of threads.
pub fn estimate(context: &FrameContext) -> Vec<u64> {
    let survey = Survey::of(context, Effort::OF_TILES);
    let mut work = vec![(0.0, 0.0); context.grid.count()];
    survey.work(context, |_, visit, triangles, _| {
        let (work, pixels) = &mut work[visit.tile as usize];
        *work += triangles;
        *pixels = f64::min(*pixels + visit.pixels, visit.of_tile);
    });
    let sum = |(work, pixels): (f64, f64)| (work + pixels * WORK_OF_PIXEL).ceil() as u64;
    work.into_iter().map(sum).collect()
}

/// Divides the clusters among `parts` ranks, at least 1. The same on every machine, and for every number of threads.
pub fn divide_clusters(context: &FrameContext, parts: usize) -> Vec<ClusterSet> {
    let survey = Survey::of(context, Effort::of_clusters(parts));
    let ranks = survey.divide(context, parts);
    let mut seen: Vec<(u32, u32)> = survey.seen.iter().map(|seen| seen.number).zip(ranks).collect();
    seen.sort_unstable();
    let clusters = context.clusters();
    let stands_for = survey.step as u32;
    // Clusters that were not looked at are of the rank of their nearest neighbours that are seen. Those in between are probably outside
    // the picture.
    let (mut sets, mut others, mut done) = (vec![Vec::new(); parts], Vec::new(), 0);
    for (place, &(first, rank)) in seen.iter().enumerate() {
        let next = seen.get(place + 1).map_or(clusters, |next| next.0);
        let begin = done.max(first.saturating_sub(stands_for - 1));
        others.push(done..begin);
        done = next.min(first.saturating_add(stands_for));
        sets[rank as usize].push(begin..done);
    }
    others.push(done..clusters);
    for (set, others) in sets.iter_mut().zip(cluster_set::divide(&others, parts)) {
        set.extend(others);
    }
    sets.into_iter().map(ClusterSet::from_iter).collect()
}
