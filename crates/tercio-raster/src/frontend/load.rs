//! An estimate of the work in each tile, from the bounds of some of the clusters: ranks that divide the picture among
//! themselves need it before anything is drawn.

use crate::context::FrameContext;
use crate::survey::{COVERED_OF_BOX, Effort, Survey};

/// At most about this many clusters are looked at, and so many tiles visited for all of them together.
const EFFORT: Effort = Effort { clusters: 4096, visits: 1 << 17 };

/// The work of a covered pixel in that of a triangle.
const WORK_OF_PIXEL: f64 = 1.0;

/// The share of a cluster's work that is done even where it is hidden: only whole clusters are found to be.
const WORK_OF_HIDDEN: f64 = 0.5;

/// Estimates the work in each tile: triangles that are not hidden, and pixels that they cover, in units of a triangle. Tiles
/// that seem to be empty have 0. The same on every machine, and for every number of threads.
pub fn estimate(context: &FrameContext) -> Vec<u64> {
    let survey = Survey::of(context, EFFORT);
    let tiles = context.grid.count();
    let mut work = vec![0.0; tiles];
    let (mut hidden, mut pixels) = (vec![0.0; tiles], vec![0.0; tiles]);
    // Front to back, so that what is hidden counts less.
    survey.visits(context, |_, visit| {
        let hidden = &mut hidden[visit.tile as usize];
        let seen: f64 = 1.0 - *hidden;
        work[visit.tile as usize] += visit.triangles * (WORK_OF_HIDDEN + (1.0 - WORK_OF_HIDDEN) * seen);
        let pixels = &mut pixels[visit.tile as usize];
        *pixels = f64::min(*pixels + visit.pixels, visit.of_tile);
        *hidden = (*hidden + seen * (visit.pixels * COVERED_OF_BOX / visit.of_tile)).min(1.0);
    });
    let sum = |(work, pixels): (f64, f64)| (work + pixels * WORK_OF_PIXEL).ceil() as u64;
    work.into_iter().zip(pixels).map(sum).collect()
}
