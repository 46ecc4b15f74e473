//! An estimate of the work in each tile, from the bounds of some of the clusters: ranks that divide the picture among
//! themselves need it before anything is drawn.

use tercio_mesh::cluster::Cluster;

use crate::context::FrameContext;
use crate::conventions::SUBPIXELS;
use crate::view::{ObjectView, View};

/// At most about this many clusters are looked at, evenly spread over the scene.
const SAMPLES: u32 = 4096;

/// At most about so many tiles are visited for all of them together: where clusters are large, fewer are looked at.
const MOST_VISITS: u64 = 1 << 17;

/// The work of a covered pixel in that of a triangle.
const WORK_OF_PIXEL: f64 = 1.0;

/// The share of a cluster's work that is done even where it is hidden: only whole clusters are found to be.
const WORK_OF_HIDDEN: f64 = 0.5;
/// The share of the box of a cluster on the screen that its triangles cover.
const COVERED_OF_BOX: f64 = 0.3;

/// A cluster that may be visible.
struct Found {
    /// In any unit.
    distance: f64,
    number: u32,
    /// First and last column, first and last row of pixels.
    rect: [u32; 4],
    triangles: f64,
}

/// Estimates the work in each tile: triangles that are not hidden, and pixels that they cover, in units of a triangle. Tiles
/// that seem to be empty have 0. The same on every machine, and for every number of threads.
pub fn estimate(context: &FrameContext) -> Vec<u64> {
    let (grid, size) = (&context.grid, context.size());
    let step = context.clusters().div_ceil(SAMPLES).max(1);
    let mut found = Vec::new();
    for number in (0..context.clusters()).step_by(step as usize) {
        let (instance, index) = context.locate(number);
        let cluster = &context.scene.instances[instance].mesh.clusters()[index];
        let object = &context.objects[instance];
        if let Some((distance, rect)) = extent(&context.view, object, cluster) {
            found.push(Found { distance, number, rect, triangles: f64::from(cluster.triangles) });
        }
    }
    let visits = |of: &Found| {
        let [column0, column1, row0, row1] = grid.tiles_that_need(of.rect);
        u64::from(column1 - column0 + 1) * u64::from((row1 + 1).saturating_sub(row0))
    };
    let skipped = found.iter().map(visits).sum::<u64>().div_ceil(MOST_VISITS).max(1);
    let mut found: Vec<Found> = found.into_iter().step_by(skipped as usize).collect();
    let step = f64::from(step) * skipped as f64;
    // Front to back, so that what is hidden counts less.
    found.sort_unstable_by(|a, b| a.distance.total_cmp(&b.distance).then(a.number.cmp(&b.number)));
    let mut work = vec![0.0; grid.count()];
    let (mut hidden, mut pixels) = (vec![0.0; grid.count()], vec![0.0; grid.count()]);
    for Found { rect: rect @ [x0, x1, y0, y1], triangles, .. } in found {
        let across = f64::from(x1 - x0 + 1) * f64::from(y1 - y0 + 1);
        let triangles = triangles * step;
        let [column0, column1, row0, row1] = grid.tiles_that_need(rect);
        for (column, row) in (row0..=row1).flat_map(|row| (column0..=column1).map(move |c| (c, row))) {
            let tile = grid.number(column, row);
            let own = grid.rect(tile, size);
            let overlap = |a0: u32, a1: u32, b0: i32, b1: i32| {
                f64::from((a1.min(b1 as u32) + 1).saturating_sub(a0.max(b0 as u32)))
            };
            let covered = overlap(x0, x1, own.x0, own.x1) * overlap(y0, y1, own.y0, own.y1);
            let of_tile = f64::from(own.x1 - own.x0 + 1) * f64::from(own.y1 - own.y0 + 1);
            let hidden = &mut hidden[tile as usize];
            let seen: f64 = 1.0 - *hidden;
            // A cluster in several tiles is projected in each; its triangles are drawn where they lie.
            let of_cluster = triangles * (0.25 + 0.75 * covered / across);
            work[tile as usize] += of_cluster * (WORK_OF_HIDDEN + (1.0 - WORK_OF_HIDDEN) * seen);
            let pixels = &mut pixels[tile as usize];
            *pixels = f64::min(*pixels + covered * step, of_tile);
            *hidden = (*hidden + seen * (covered * step * COVERED_OF_BOX / of_tile)).min(1.0);
        }
    }
    let sum = |(work, pixels): (f64, f64)| (work + pixels * WORK_OF_PIXEL).ceil() as u64;
    work.into_iter().zip(pixels).map(sum).collect()
}

/// The distance of a cluster, and the pixels inside the picture that it may reach, approximately; `None` if there are none.
fn extent(view: &View, object: &ObjectView, cluster: &Cluster) -> Option<(f64, [u32; 4])> {
    let middle: [f64; 3] =
        std::array::from_fn(|k| (f64::from(cluster.min[k]) + f64::from(cluster.max[k])) * 0.5);
    let half: [f64; 3] =
        std::array::from_fn(|k| (f64::from(cluster.max[k]) - f64::from(cluster.min[k])) * 0.5);
    let range = |row: &[f64; 4]| {
        let center = ((row[0] * middle[0] + row[1] * middle[1]) + row[2] * middle[2]) + row[3];
        let reach = (row[0].abs() * half[0] + row[1].abs() * half[1]) + row[2].abs() * half[2];
        (center, reach)
    };
    let (w, deviation) = range(&object.exact.w);
    let near = if view.perspective { f64::from(object.near) } else { 0.0 };
    if w + deviation <= near {
        return None;
    }
    // Where it crosses the near plane it may be anywhere.
    let crosses = w - deviation <= near;
    let along = |row: &[f64; 4], middle: i32, size: u32| {
        if crosses {
            return Some([0, size - 1]);
        }
        let (center, reach) = range(row);
        let pixel = |at: f64, w: f64| (at / w + f64::from(middle)) / f64::from(SUBPIXELS);
        // Bounds of a quotient: by the nearest point where they are away from the middle of the projection.
        let (low, high) = (center - reach, center + reach);
        let (nearest, farthest) = (w - deviation, w + deviation);
        let first = pixel(low, if low < 0.0 { nearest } else { farthest }).floor();
        let last = pixel(high, if high > 0.0 { nearest } else { farthest }).floor();
        let reaches = last >= 0.0 && first < f64::from(size);
        reaches.then(|| [first.max(0.0) as u32, (last.max(0.0) as u32).min(size - 1)])
    };
    let [x0, x1] = along(&object.exact.x, view.middle[0], view.width)?;
    let [y0, y1] = along(&object.exact.y, view.middle[1], view.height)?;
    let distance = if view.perspective { w } else { -range(&object.exact.d).0 };
    Some((distance, [x0, x1, y0, y1]))
}
