//! Which clusters may be seen, and in which tiles, from the bounds of some of them: what ranks know of a frame before they
//! draw it.

use std::ops::Range;

use tercio_mesh::cluster::Cluster;

use crate::context::FrameContext;
use crate::conventions::SUBPIXELS;
use crate::view::{ObjectView, View};

/// The share of the box of a cluster on the screen that its triangles cover.
pub const COVERED_OF_BOX: f64 = 0.3;

/// The work of a covered pixel in that of a triangle.
pub const WORK_OF_PIXEL: f64 = 1.0;

/// The share of a cluster's work that is done even where it is hidden: only whole clusters are found to be.
pub const WORK_OF_HIDDEN: f64 = 0.5;

/// How much of a scene is looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Effort {
    /// At most about this many clusters, evenly spread over the scene; at least 1.
    pub clusters: u32,
    /// At most about so many tiles for all of them together: where clusters are large, fewer are looked at.
    pub visits: u64,
}

impl Effort {
    /// What is looked at to estimate the work in tiles.
    pub const OF_TILES: Self = Self { clusters: 4096, visits: 1 << 17 };

    /// What is looked at to divide the clusters among so many ranks: every rank does it, for some ranks in the time of some thousand
    /// triangles.
    pub fn of_clusters(ranks: usize) -> Self {
        let ranks = ranks as u64;
        Self { clusters: (8 * ranks).clamp(2048, 1 << 16) as u32, visits: (64 * ranks).max(1 << 14) }
    }
}

/// A cluster that may be visible.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Its number.
    pub number: u32,
    /// From the eye, in any unit.
    pub distance: f64,
    /// First and last column, first and last row of the pixels that it may reach, inside the picture.
    pub rect: [u32; 4],
    /// Its triangles.
    pub triangles: f64,
}

/// A cluster in one of the tiles that it may reach. It stands for [`Survey::step`] clusters like it, whose work this is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Visit {
    /// The tile.
    pub tile: u32,
    /// Triangles: those that lie in the tile, and a quarter of all, because a cluster in several tiles is projected in each.
    pub triangles: f64,
    /// Pixels of the tile inside the box of the cluster on the screen.
    pub pixels: f64,
    /// Pixels of the tile.
    pub of_tile: f64,
}

/// Some of the clusters that may be visible, front to back; those at equal distances in the order of their numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Survey {
    /// The clusters.
    pub seen: Vec<Seen>,
    /// How many clusters of the scene each of them stands for.
    pub step: f64,
    /// How many clusters were looked at, visible or not.
    pub looked_at: u32,
}

impl Survey {
    /// Looks at some of the clusters of a scene. The same on every machine.
    pub fn of(context: &FrameContext, effort: Effort) -> Self {
        let step = context.clusters().div_ceil(effort.clusters.max(1)).max(1);
        let mut seen = Vec::new();
        for number in (0..context.clusters()).step_by(step as usize) {
            let (instance, index) = context.locate(number);
            let cluster = &context.scene.instances[instance].mesh.clusters()[index];
            let object = &context.objects[instance];
            if let Some((distance, rect)) = extent(&context.view, object, cluster) {
                seen.push(Seen { distance, number, rect, triangles: f64::from(cluster.triangles) });
            }
        }
        let visits = |of: &Seen| {
            let [column0, column1, row0, row1] = context.grid.tiles_that_need(of.rect);
            u64::from(column1 - column0 + 1) * u64::from((row1 + 1).saturating_sub(row0))
        };
        let all = seen.iter().map(visits).sum::<u64>();
        let skipped = all.div_ceil(effort.visits.max(1)).max(1);
        let mut seen: Vec<Seen> = seen.into_iter().step_by(skipped as usize).collect();
        seen.sort_unstable_by(|a, b| a.distance.total_cmp(&b.distance).then(a.number.cmp(&b.number)));
        let looked_at = context.clusters().div_ceil(step);
        Self { seen, step: f64::from(step) * skipped as f64, looked_at }
    }

    /// Passes every tile that each of the clusters, by its place in `seen`, may reach, in their order. The context may be one of another
    /// grid than that of the survey, of the same picture.
    pub fn visits(&self, context: &FrameContext, mut each: impl FnMut(usize, Visit)) {
        let (grid, size, step) = (&context.grid, context.size(), self.step);
        for (place, seen) in self.seen.iter().enumerate() {
            let Seen { rect: rect @ [x0, x1, y0, y1], triangles, .. } = *seen;
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
                let triangles = triangles * (0.25 + 0.75 * covered / across);
                each(place, Visit { tile, triangles, pixels: covered * step, of_tile });
            }
        }
    }

    /// Passes with every visit the triangles and the pixels that are estimated to be drawn: what is hidden by clusters in front counts
    /// less.
    pub fn work(&self, context: &FrameContext, mut each: impl FnMut(usize, Visit, f64, f64)) {
        let mut hidden = vec![0.0; context.grid.count()];
        self.visits(context, |place, visit| {
            let hidden = &mut hidden[visit.tile as usize];
            let seen: f64 = 1.0 - *hidden;
            let covered = seen * (visit.pixels * COVERED_OF_BOX);
            let triangles = visit.triangles * (WORK_OF_HIDDEN + (1.0 - WORK_OF_HIDDEN) * seen);
            *hidden = (*hidden + covered / visit.of_tile).min(1.0);
            each(place, visit, triangles, covered);
        });
    }

    /// Divides the clusters among `ranks`, at least 1: returns the rank of each. The picture is cut in two where the work on both
    /// sides is in the proportion of the ranks, across its longer side, and each part again.
    pub fn divide(&self, context: &FrameContext, ranks: usize) -> Vec<u32> {
        let sites = self.seen.iter().enumerate().map(|(place, seen)| {
            let [x0, x1, y0, y1] = seen.rect;
            Site { middle: [x0 + x1, y0 + y1], number: seen.number, place, work: 0.0 }
        });
        let mut sites: Vec<Site> = sites.collect();
        self.work(context, |place, _, triangles, pixels| {
            sites[place].work += triangles + pixels * WORK_OF_PIXEL;
        });
        let mut owners = vec![0; sites.len()];
        bisect(&mut sites, 0..ranks as u32, &mut owners);
        owners
    }
}

/// A cluster as it is divided.
#[derive(Clone, Copy)]
struct Site {
    /// Twice the middle of its pixels, across and down.
    middle: [u32; 2],
    number: u32,
    /// Its place in [`Survey::seen`].
    place: usize,
    work: f64,
}

/// Divides clusters among ranks, and sets the `owners` of their places.
fn bisect(sites: &mut [Site], ranks: Range<u32>, owners: &mut [u32]) {
    if ranks.len() <= 1 || sites.is_empty() {
        sites.iter().for_each(|site| owners[site.place] = ranks.start);
        return;
    }
    let length = |axis: usize| {
        let along = |site: &Site| site.middle[axis];
        let (first, last) = (sites.iter().map(along).min(), sites.iter().map(along).max());
        last.unwrap_or(0) - first.unwrap_or(0)
    };
    let axis = usize::from(length(1) > length(0));
    sites.sort_unstable_by_key(|site| (site.middle[axis], site.number));
    let half = ranks.len() as u32 / 2;
    let all: f64 = sites.iter().map(|site| site.work).sum();
    let share = all * f64::from(half) / ranks.len() as f64;
    let mut before = 0.0;
    let cut = sites.iter().position(|site| {
        before += site.work;
        before - site.work * 0.5 > share
    });
    let (first, second) = sites.split_at_mut(cut.unwrap_or(sites.len()));
    bisect(first, ranks.start..ranks.start + half, owners);
    bisect(second, ranks.start + half..ranks.end, owners);
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
