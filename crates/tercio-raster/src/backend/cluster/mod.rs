//! Draws a whole cluster into a tile: transform, triangle setup, coverage and depth tests.
//!
//! From its vertices to its pixels, the data of a cluster stays in registers and in the first-level cache. [`sieve`]
//! drops the triangles that reach no sample and sorts the others by size, so that from then on all lanes are used and
//! branches are predictable. [`setup`] computes edge functions and depth planes of 16 triangles, [`scan`] finds the
//! samples that triangles of a few pixels cover, 16 triangles at once, and [`depth_test`] keeps those samples that are
//! nearer than what was drawn before. Larger triangles are drawn one by one, stamp after stamp ([`stamps`]). Then the
//! winners are shaded from the projected vertices, 16 at a time ([`shade::winners`](super::shade::winners)).

mod depth_test;
mod scan;
mod setup;
mod sieve;
mod stamps;

use fearless_simd::Simd;
use tercio_mesh::cluster::{ClusterView, MAX_TRIANGLES};

use crate::backend::tally::Tally;
use crate::binning::BinnedCluster;
use crate::context::{FrameContext, NO_SLOT};
use crate::conventions::SAMPLE;
use crate::projection::{CornerTable, LocalVertices};
use crate::sampling::SampleCells;
use crate::screen::{PixelRect, ScreenTriangle};
use crate::settings::LastStage;
use crate::simd::{LANES, part, prefetch};
use crate::stats::BackEndCounts;
use depth_test::Covered;
pub use depth_test::Winners;
pub use setup::SmallTriangles;
use sieve::Keep;
pub use sieve::{Sieve, Size};
use stamps::Lanes;

use super::memory::TileMemory;
use super::visibility;

/// The memory for drawing a cluster, reused from cluster to cluster.
#[derive(Debug, Default)]
pub struct ClusterPass {
    /// The cluster's projected vertices.
    pub vertices: LocalVertices,
    sieve: Sieve,
    covered: Covered,
    /// The samples that the cluster won, which are to be shaded.
    pub winners: Winners,
}

impl ClusterPass {
    /// Draws a cluster into a tile and lists the samples that it won.
    #[inline(always)]
    pub fn draw<S: Simd, T: Tally>(
        &mut self,
        simd: S,
        context: &FrameContext,
        binned: &BinnedCluster,
        tile: &mut TileMemory,
        tally: &mut T,
    ) {
        let first_slot = binned.number * MAX_TRIANGLES as u32;
        let rect = tile.rect();
        let Self { vertices, sieve, covered, winners } = self;
        let number = binned.number;
        let corners = &project_and_sieve(simd, context, number, rect, SAMPLE, vertices, sieve, tally);
        winners.clear();
        if context.settings.last_stage == LastStage::Sieve {
            return;
        }

        for size in Size::ALL {
            for (numbers, lanes) in sieve.of_size(size) {
                if size == Size::Huge {
                    let numbers = &numbers[..lanes.count_ones() as usize];
                    let counts = tally.counts();
                    let before = counts.stamps;
                    draw_huge(simd, context, vertices, corners, numbers, first_slot, tile, winners, counts);
                    let stamps = counts.stamps - before;
                    if let Some(full) = tally.full() {
                        full.details.stamps_alone += stamps;
                    }
                    continue;
                }
                if let Some(full) = tally.full() {
                    full.details.set_ups += 1;
                }
                let of = &corners.look_up(simd, numbers);
                let triangles = SmallTriangles::new(simd, vertices, of, &SampleCells::CENTER, rect);
                match size {
                    Size::Tiny => scan::scan_tiny(simd, &triangles, lanes, numbers, tile, covered, tally),
                    Size::Small => scan::scan(simd, &triangles, lanes, numbers, tile, covered, tally),
                    Size::Medium => {
                        let setup = Lanes::<8>::new(simd, &triangles, tile);
                        let counts = tally.counts();
                        stamps::draw(
                            simd, context, &setup, lanes, first_slot, numbers, tile, winners, counts,
                        );
                    }
                    Size::Large | Size::Huge => {
                        let setup = Lanes::<LANES>::new(simd, &triangles, tile);
                        let counts = tally.counts();
                        stamps::draw(
                            simd, context, &setup, lanes, first_slot, numbers, tile, winners, counts,
                        );
                    }
                }
                if covered.is_nearly_full() {
                    covered.test(context, first_slot, tile, winners, tally.counts());
                }
            }
        }
        covered.test(context, first_slot, tile, winners, tally.counts());
    }
}

/// Projects the vertices of a cluster, given by its number in the frame, and sorts the triangles that reach samples of
/// `rect`; the samples of a pixel are at least `origin` sub-pixels from its borders. Counts both, and returns the corners
/// of the cluster's triangles.
#[expect(clippy::too_many_arguments, reason = "a struct would only rename them")]
#[inline(always)]
pub fn project_and_sieve<'a, S: Simd, T: Tally>(
    simd: S,
    context: &FrameContext<'a>,
    number: u32,
    rect: PixelRect,
    origin: i32,
    vertices: &mut LocalVertices,
    sieve: &mut Sieve,
    tally: &mut T,
) -> CornerTable<'a> {
    let (instance, cluster) = context.cluster(number);
    let object = &context.objects[instance];
    let corners = CornerTable::new(&cluster);
    vertices.project(simd, object, &cluster);
    let keep = Keep { rect, origin, cull: context.settings.cull, mirrored: object.mirrored };
    sieve.sort(simd, vertices, &corners, cluster.triangles(), &keep);
    if let Some(full) = tally.full() {
        full.cluster(number, &cluster);
    }
    let counts = tally.counts();
    counts.vertices_transformed += cluster.vertices() as u64;
    counts.triangles_in += cluster.triangles() as u64;
    counts.triangles_drawn += sieve.len();
    corners
}

/// Draws [`Size::Huge`] triangles, one by one.
#[expect(clippy::too_many_arguments, reason = "one call site; a struct would only rename them")]
#[inline(never)]
fn draw_huge<S: Simd>(
    simd: S,
    context: &FrameContext,
    vertices: &LocalVertices,
    corners: &CornerTable,
    numbers: &[u8],
    first_slot: u32,
    tile: &mut TileMemory,
    winners: &mut Winners,
    counts: &mut BackEndCounts,
) {
    for &number in numbers {
        let v = corners.of(number).map(|corner| vertices.vertex(corner));
        let triangle = ScreenTriangle::new(v, first_slot + u32::from(number));
        // A triangle without area covers nothing, and its edge functions are not defined.
        if triangle.area() == 0 {
            continue;
        }
        visibility::draw(simd, context, &triangle, tile, Some((winners, number)), counts);
    }
}

/// Prefetches the head of a cluster that will be drawn soon.
#[inline(always)]
pub fn prefetch_head(context: &FrameContext, binned: &BinnedCluster) {
    let (_, cluster) = context.cluster(binned.number);
    prefetch(cluster.first_line());
}

/// Prefetches the vertices and triangles of a cluster that will be drawn soon.
#[inline(always)]
pub fn prefetch_body(context: &FrameContext, binned: &BinnedCluster) {
    let (_, cluster) = context.cluster(binned.number);
    prefetch(&cluster.hot_lines()[1..]);
}

/// Prefetches the primitive numbers of some slots: drawing does not read them, and where triangles are small nearly every pixel is
/// of another cluster.
#[inline(always)]
pub fn prefetch_primitives(context: &FrameContext, slots: impl Iterator<Item = u32> + Clone) {
    // Elsewhere nothing is prefetched.
    if !cfg!(target_arch = "x86_64") {
        return;
    }
    let triangles = slots
        .filter(|&slot| slot != NO_SLOT)
        .map(|slot| (slot / MAX_TRIANGLES as u32, slot as usize % MAX_TRIANGLES));
    // The head tells where the numbers are. Neighbours are often of the same cluster.
    let mut known = NO_SLOT;
    for (number, _) in triangles.clone() {
        if number != known {
            prefetch(context.cluster(number).1.first_line());
            known = number;
        }
    }
    let mut known: Option<(u32, ClusterView)> = None;
    for (number, triangle) in triangles {
        let cluster = match known {
            Some((known, cluster)) if known == number => cluster,
            _ => context.cluster(number).1,
        };
        known = Some((number, cluster));
        prefetch(cluster.primitive_lines(triangle));
    }
}

/// Occlusion test: is everything drawn in a cluster's part of a tile nearer than the cluster can be?
#[inline(always)]
pub fn is_hidden<S: Simd>(simd: S, binned: &BinnedCluster, tile: &TileMemory) -> bool {
    let rect = binned.pixels().intersect(tile.rect());
    part(
        simd,
        #[inline(always)]
        || tile.all_nearer(simd, rect, binned.nearest),
    )
}
