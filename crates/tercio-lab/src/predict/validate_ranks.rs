//! Ranks in one process, predicted against measured: [`tercio_parallel`] draws, and what its ranks count and send has to
//! be what is reckoned here from coverage alone.
//!
//! What is reckoned, and by which rules:
//!
//! * sort-last deals out consecutive clusters, rank r of n those from `C * r / n` on; sort-first gives every rank all;
//! * region k of the picture, row by row, belongs to rank k modulo the ranks;
//! * a row of neighbouring pixels of one region that show something travels as 6 bytes and 4 for every pixel's colour,
//!   and 8 for its key where it is yet to be composed;
//! * what a rank's renderer counts follows from its part of the clusters or tiles ([`super::counters`]);
//! * ranks without clusters send nothing to be composed, ranks without regions take nothing and have nothing to collect.
//!
//! Times are of ranks with one thread each. A stage is charged by what it does; its costs are fitted to other models
//! ([`RankCosts`]), those of drawing come from the machine's description.

use serde::Serialize;
use tercio_mesh::Aabb;
use tercio_parallel::{FrameReport, Organisation, ParallelError, RankReport, Ranks, draw_frames};
use tercio_raster::Settings;
use tercio_raster::frontend::clip::clip_triangle;
use tercio_raster::view::{ObjectView, ScreenVertex, View};
use tercio_scene::{Camera, Scene};

use super::counters::Counters;
use super::measure::Clock;
use super::validate::TOLERANCE;
use super::{PredictError, views};
use crate::machines::Machine;
use crate::simulators::sorting::{Assignment, Regions};

mod times;

pub use times::{RankCosts, StageSeconds};

/// Bytes before the pixels of a row, of a pixel's key and of its colour.
const ROW_BYTES: u64 = 6;
const KEY_BYTES: u64 = 8;
const COLOR_BYTES: u64 = 4;

/// Why ranks could not be compared.
#[derive(Debug, thiserror::Error)]
pub enum RanksError {
    /// There is no prediction.
    #[error(transparent)]
    Predict(#[from] PredictError),
    /// The ranks could not draw.
    #[error(transparent)]
    Parallel(#[from] ParallelError),
}

/// What is counted of a rank.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct RankCounts {
    /// Triangles that it meets.
    pub triangles: u64,
    /// Pixels that it sends to be composed.
    pub sent: u64,
    /// Pixels that it composes.
    pub compared: u64,
    /// Pixels of its regions that show something in the end.
    pub visible: u64,
    /// Messages that it sends.
    pub messages: u64,
    /// Their bytes.
    pub bytes: u64,
}

impl RankCounts {
    /// What a rank counted itself.
    pub fn measured(report: &RankReport) -> Self {
        Self {
            triangles: report.frame.frontend.triangles_in,
            sent: report.pixels.sent,
            compared: report.pixels.compared,
            visible: report.pixels.visible,
            messages: report.traffic.sent_messages,
            bytes: report.traffic.sent_bytes,
        }
    }

    fn by_name(&self) -> [(&'static str, u64); 6] {
        [
            ("triangles", self.triangles),
            ("pixels sent", self.sent),
            ("pixels compared", self.compared),
            ("pixels visible", self.visible),
            ("messages", self.messages),
            ("bytes", self.bytes),
        ]
    }
}

/// Counts every rank's part of a frame without drawing it.
///
/// # Errors
/// A camera that makes no view.
pub fn predict_counts(
    scene: &Scene,
    camera: &Camera,
    (width, height): (u32, u32),
    edge: u32,
    ranks: usize,
    organisation: Organisation,
) -> Result<Vec<RankCounts>, PredictError> {
    let view = View::new(camera, &scene.bounds(), width, height)?;
    let regions = Regions { width, height, edge, owners: ranks, assignment: Assignment::Interleaved };
    let owners = usize::try_from(regions.count()).unwrap_or(usize::MAX).min(ranks);
    let columns = u64::from(width.div_ceil(edge));
    let owner_of = |x: u32, y: u32| regions.owner(u64::from(y / edge) * columns + u64::from(x / edge));
    let place = |x: u32, y: u32| y as usize * width as usize + x as usize;
    // Rows of pixels to each owner, and pixels.
    let rows_of = |shown: &[bool]| {
        let mut found = vec![(0u64, 0u64); ranks];
        for y in 0..height {
            for x in (0..width).filter(|&x| shown[place(x, y)]) {
                let owner = owner_of(x, y);
                found[owner].0 += u64::from(x % edge == 0 || !shown[place(x - 1, y)]);
                found[owner].1 += 1;
            }
        }
        found
    };

    let clusters: usize = scene.instances.iter().map(|i| i.mesh.clusters.len()).sum();
    let mut counts = vec![RankCounts::default(); ranks];
    let mut shown_by_any = vec![false; width as usize * height as usize];
    match organisation {
        Organisation::SortFirst => {
            let triangles = each_sample(scene, &view, 0..clusters, |x, y| {
                shown_by_any[place(x, y)] = true;
            });
            counts[..owners].iter_mut().for_each(|c| c.triangles = triangles);
        }
        Organisation::SortLast => {
            for rank in 0..ranks {
                let own = clusters * rank / ranks..clusters * (rank + 1) / ranks;
                let has_clusters = !own.is_empty();
                let mut shown = vec![false; shown_by_any.len()];
                counts[rank].triangles = each_sample(scene, &view, own, |x, y| {
                    shown[place(x, y)] = true;
                });
                shown_by_any.iter_mut().zip(&shown).for_each(|(any, own)| *any |= own);
                for (to, (rows, pixels)) in rows_of(&shown).into_iter().enumerate().take(owners) {
                    if has_clusters && to != rank {
                        counts[rank].sent += pixels;
                        counts[rank].messages += 1;
                        counts[rank].bytes += rows * ROW_BYTES + pixels * (KEY_BYTES + COLOR_BYTES);
                        counts[to].compared += pixels;
                    }
                }
            }
        }
    }
    for (rank, (rows, pixels)) in rows_of(&shown_by_any).into_iter().enumerate().take(owners) {
        counts[rank].visible = pixels;
        if rank > 0 {
            counts[rank].messages += 1;
            counts[rank].bytes += rows * ROW_BYTES + pixels * COLOR_BYTES;
        }
    }
    Ok(counts)
}

/// Calls `emit` for every sample of the picture that a triangle of some clusters covers, counted through the instances,
/// and returns how many triangles there are.
fn each_sample(
    scene: &Scene,
    view: &View,
    clusters: std::ops::Range<usize>,
    mut emit: impl FnMut(u32, u32),
) -> u64 {
    let (mut triangles, mut first) = (0, 0);
    for instance in &scene.instances {
        let (object, mesh): (ObjectView, _) = (view.object(instance), &*instance.mesh);
        for (_, cluster) in (first..).zip(&mesh.clusters).filter(|(number, _)| clusters.contains(number)) {
            let corner = |k: usize, t: usize| mesh.position(mesh.corner_places(cluster, t)[k]);
            for t in cluster.triangle_range() {
                triangles += 1;
                let positions = [corner(0, t), corner(1, t), corner(2, t)];
                let projected = positions.map(|p| object.project(p));
                if projected.iter().all(|v| v.inside) {
                    fill(projected, view, &mut emit);
                } else {
                    clip_triangle(&object, positions, projected, |piece| fill(piece, view, &mut emit));
                }
            }
        }
        first += mesh.clusters.len();
    }
    triangles
}

/// The samples of one triangle: right of all edges that run clockwise round it, on an edge only if that runs upwards or
/// level to the right.
fn fill(corners: [ScreenVertex; 3], view: &View, emit: &mut impl FnMut(u32, u32)) {
    use tercio_raster::conventions::{SAMPLE, SUBPIXELS};
    let mut p = corners.map(|v| [i64::from(v.x), i64::from(v.y)]);
    let side =
        |a: [i64; 2], b: [i64; 2], s: [i64; 2]| (b[0] - a[0]) * (s[1] - a[1]) - (b[1] - a[1]) * (s[0] - a[0]);
    let area = side(p[0], p[1], p[2]);
    if area == 0 {
        return;
    }
    if area < 0 {
        p.swap(1, 2);
    }
    // Pixels, a few more than needed, whose samples may lie between the least and the greatest coordinate.
    let pixels = |k: usize, size: u32| {
        let (a, b, c) = (p[0][k], p[1][k], p[2][k]);
        let pixel = |coordinate: i64| coordinate.div_euclid(i64::from(SUBPIXELS));
        pixel(a.min(b).min(c)).max(0)..=pixel(a.max(b).max(c)).min(i64::from(size) - 1)
    };
    for y in pixels(1, view.height) {
        for x in pixels(0, view.width) {
            let sample = [x, y].map(|c| c * i64::from(SUBPIXELS) + i64::from(SAMPLE));
            let covered = (0..3).all(|k| {
                let (a, b) = (p[k], p[(k + 1) % 3]);
                let owns_edge = b[1] < a[1] || b[1] == a[1] && b[0] > a[0];
                side(a, b, sample) >= i64::from(!owns_edge)
            });
            if covered {
                emit(x as u32, y as u32);
            }
        }
    }
}

/// One model, size and way to share it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Model.
    pub model: String,
    /// Pixels across and down.
    pub size: (u32, u32),
    /// Ranks.
    pub ranks: usize,
    /// How they share a frame.
    pub organisation: Organisation,
    /// Messages of a frame, summed over the views.
    pub messages: u64,
    /// Their bytes.
    pub bytes: u64,
    /// Counters that differ: rank, name, ours, the rank's.
    pub differing: Vec<(usize, &'static str, u64, u64)>,
    /// Counters that were compared.
    pub compared: usize,
    /// Predicted seconds of a frame, stage by stage, the mean of the views.
    pub predicted: StageSeconds,
    /// Measured ones.
    pub measured: StageSeconds,
}

impl Row {
    /// Predicted over measured, less 1, of the whole frame.
    pub fn error(&self) -> f64 {
        self.predicted.frame / self.measured.frame - 1.0
    }

    /// All counters equal, and the frame's time within [`TOLERANCE`].
    pub fn holds(&self) -> bool {
        self.differing.is_empty() && self.error().abs() <= TOLERANCE
    }
}

/// How much is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// Views round the model.
    pub views: u32,
    /// Frames of a view, of which the fastest counts.
    pub frames: u32,
    /// Processors that the ranks share.
    pub processors: usize,
    /// Which clock times whole frames. By processor time a frame is put together from the stages of its ranks, which
    /// then never wait for a processor that other programs have; stages are timed by it always.
    pub clock: Clock,
}

/// The settings that frames are drawn with.
fn settings((width, height): (u32, u32)) -> Settings {
    Settings::new(width, height)
}

/// Draws one view some times; the first, which takes memory, is left out.
fn measure(
    scene: &Scene,
    camera: &Camera,
    size: (u32, u32),
    ranks: usize,
    organisation: Organisation,
    frames: u32,
) -> Result<Vec<FrameReport>, ParallelError> {
    let cameras = vec![*camera; frames.max(1) as usize + 1];
    let ranks = Ranks { count: ranks, threads: 1, organisation };
    let mut reports = draw_frames(ranks, scene, &cameras, &settings(size), |_, _| {})?;
    reports.remove(0);
    Ok(reports)
}

/// Compares one model at one size on some ranks.
///
/// # Errors
/// [`RanksError`].
pub fn compare(
    machine: &Machine,
    costs: &RankCosts,
    (name, scene, bounds): (&str, &Scene, &Aabb),
    size: (u32, u32),
    (ranks, organisation): (usize, Organisation),
    o: Options,
) -> Result<Row, RanksError> {
    let mut row = Row {
        model: name.into(),
        size,
        ranks,
        organisation,
        messages: 0,
        bytes: 0,
        differing: Vec::new(),
        compared: 0,
        predicted: StageSeconds::default(),
        measured: StageSeconds::default(),
    };
    let views = o.views.max(1);
    for view in 0..views {
        let camera = views::camera(bounds, size, view, views);
        let reports = measure(scene, &camera, size, ranks, organisation, o.frames)?;
        let edge = settings(size).tile_edge();
        let ours = predict_counts(scene, &camera, size, edge, ranks, organisation)?;
        if let Some(report) = reports.first() {
            row.messages += report.messages;
            row.bytes += report.bytes;
        }
        let drawing = times::drawing(scene, &camera, size, ranks, organisation)?;
        for report in &reports {
            for (rank, ((ours, drawn), theirs)) in ours.iter().zip(&drawing).zip(&report.ranks).enumerate() {
                let sent = ours.by_name().into_iter().zip(RankCounts::measured(theirs).by_name());
                let drawn = drawn.comparable().into_iter().zip(Counters::counted(&theirs.frame));
                for ((name, ours), (_, theirs)) in sent.chain(drawn) {
                    row.compared += 1;
                    if ours != theirs {
                        row.differing.push((rank, name, ours, theirs));
                    }
                }
            }
        }
        let predicted =
            times::predict(machine, costs, &ours, &drawing, size, edge, organisation, o.processors);
        row.predicted.add(predicted, f64::from(views));
        row.measured.add(StageSeconds::measured(&reports, o.clock, o.processors), f64::from(views));
    }
    Ok(row)
}

#[cfg(test)]
mod tests;
