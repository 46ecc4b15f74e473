//! An estimate of the work in each tile, from the bounds of some of the clusters: ranks that divide the picture among
//! themselves need it before anything is drawn.

use tercio_mesh::cluster::Cluster;

use crate::context::FrameContext;
use crate::conventions::SUBPIXELS;
use crate::view::{ObjectView, View};

/// At most about this many clusters are looked at, evenly spread over the scene.
const SAMPLES: u32 = 4096;

/// The work of a covered pixel in that of a triangle.
const WORK_OF_PIXEL: u64 = 2;

/// Estimates the work in each tile: triangles, and pixels that they cover, in units of a triangle. Tiles that seem to be
/// empty have 0. The same on every machine, and for every number of threads.
pub fn estimate(context: &FrameContext) -> Vec<u64> {
    let (grid, size) = (&context.grid, context.size());
    let step = context.clusters().div_ceil(SAMPLES).max(1);
    let mut triangles = vec![0u64; grid.count()];
    let mut pixels = vec![0u64; grid.count()];
    for number in (0..context.clusters()).step_by(step as usize) {
        let (instance, index) = context.locate(number);
        let cluster = &context.scene.instances[instance].mesh.clusters()[index];
        let Some([x0, x1, y0, y1]) = extent(&context.view, &context.objects[instance], cluster) else {
            continue;
        };
        let across = (x1 - x0 + 1) as u64 * (y1 - y0 + 1) as u64;
        let [column0, column1, row0, row1] = grid.tiles_that_need([x0, x1, y0, y1]);
        for (column, row) in (row0..=row1).flat_map(|row| (column0..=column1).map(move |c| (c, row))) {
            let tile = grid.number(column, row);
            let own = grid.rect(tile, size);
            let overlap = |a0: u32, a1: u32, b0: i32, b1: i32| {
                u64::from((a1.min(b1 as u32) + 1).saturating_sub(a0.max(b0 as u32)))
            };
            let covered = overlap(x0, x1, own.x0, own.x1) * overlap(y0, y1, own.y0, own.y1);
            let of_cluster = u64::from(cluster.triangles) * u64::from(step);
            // A cluster in several tiles is projected in each; its triangles are drawn where they lie.
            triangles[tile as usize] += of_cluster / 4 + of_cluster * covered * 3 / (across * 4);
            pixels[tile as usize] += covered * u64::from(step);
        }
    }
    let work = |(tile, (triangles, pixels)): (usize, (u64, u64))| {
        let own = grid.rect(tile as u32, size);
        let most = (own.x1 - own.x0 + 1) as u64 * (own.y1 - own.y0 + 1) as u64;
        triangles + pixels.min(most) * WORK_OF_PIXEL
    };
    triangles.into_iter().zip(pixels).enumerate().map(work).collect()
}

/// First and last column, first and last row of the pixels inside the picture that a cluster may reach, approximately;
/// `None` if there are none.
fn extent(view: &View, object: &ObjectView, cluster: &Cluster) -> Option<[u32; 4]> {
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
        let pixel = |at: f64| (at / w + f64::from(middle)) / f64::from(SUBPIXELS);
        let (first, last) = (pixel(center - reach).floor(), pixel(center + reach).floor());
        let reaches = last >= 0.0 && first < f64::from(size);
        reaches.then(|| [first.max(0.0) as u32, (last.max(0.0) as u32).min(size - 1)])
    };
    let [x0, x1] = along(&object.exact.x, view.middle[0], view.width)?;
    let [y0, y1] = along(&object.exact.y, view.middle[1], view.height)?;
    Some([x0, x1, y0, y1])
}
