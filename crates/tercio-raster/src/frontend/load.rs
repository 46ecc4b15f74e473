//! Estimates of the work in each tile, and of each cluster, from the bounds of some of the clusters: ranks that divide the picture, or
//! the scene, among themselves need them before anything is drawn.

use crate::ClusterSet;
use crate::context::FrameContext;
use crate::settings::Part;
use crate::survey::{Effort, Survey, WORK_OF_PIXEL};

/// At most about this many clusters are looked at, and so many tiles visited for all of them together.
const EFFORT: Effort = Effort { clusters: 4096, visits: 1 << 17 };

/// The same where the clusters are divided: every rank does it, in the time of some thousand triangles.
const EFFORT_OF_CLUSTERS: Effort = Effort { clusters: 2048, visits: 1 << 14 };

/// Estimates the work in each tile: triangles that are not hidden, and pixels that they cover, in units of a triangle. Tiles
/// that seem to be empty have 0. The same on every machine, and for every number of threads.
pub fn estimate(context: &FrameContext) -> Vec<u64> {
    let survey = Survey::of(context, EFFORT);
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
    let survey = Survey::of(context, EFFORT_OF_CLUSTERS);
    let clusters = context.clusters();
    if survey.seen.is_empty() {
        let part = |number| Part { number: number as u32, of: parts as u32 }.range(clusters).into();
        return (0..parts).map(part).collect();
    }
    let ranks = survey.divide(context, parts);
    let mut seen: Vec<(u32, u32)> = survey.seen.iter().map(|seen| seen.number).zip(ranks).collect();
    seen.sort_unstable();
    // Each is of the same rank as those that follow it.
    seen[0].0 = 0;
    let mut ranges = vec![Vec::new(); parts];
    for (place, &(first, rank)) in seen.iter().enumerate() {
        let next = seen.get(place + 1).map_or(clusters, |next| next.0);
        ranges[rank as usize].push(first..next);
    }
    ranges.into_iter().map(ClusterSet::from_iter).collect()
}
