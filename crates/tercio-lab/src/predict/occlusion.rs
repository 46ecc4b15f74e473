//! The samples that the renderer looks at to find out whether a cluster is hidden.
//!
//! A cluster is hidden in a tile if all samples that it may reach there show something nearer. They are compared 16 at a
//! time, row by row, until one is found that does not. So a hidden cluster takes time for all of its samples, which is much for
//! loose triangles: each is a cluster of its own, and nothing is known of it but its box. The renderer does not count
//! these comparisons; they follow from the boxes.

use tercio_raster::binning::Sorted;
use tercio_raster::context::FrameContext;
use tercio_raster::screen::PixelRect;
use tercio_raster::{Renderer, Settings};
use tercio_scene::{Camera, Scene};

use super::PredictError;

/// Samples of a stamp, side by side.
const STAMP: u64 = 16;

/// For each tile of a frame, the stamps of all clusters that are sorted into it as a whole.
///
/// # Errors
/// What makes the frame impossible to draw.
pub fn stamps(
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    threads: usize,
) -> Result<Vec<u64>, PredictError> {
    let context = FrameContext::new(scene, camera, settings, threads)?;
    let mut sorted = Sorted::default();
    Renderer::new().sort(&context, &mut sorted);
    Ok((0..context.grid.count() as u32).map(|tile| of_tile(&context, &sorted, tile)).collect())
}

/// Of the clusters that are sorted into a tile. All samples of a row of pixels are compared one after another, and those around the
/// tile that the filter needs are, too.
fn of_tile(context: &FrameContext, sorted: &Sorted, tile: u32) -> u64 {
    let own = context.grid.rect(tile, context.size());
    let in_memory = own.grow(context.grid.halo as i32).intersect(context.picture());
    let of_cluster = |pixels: PixelRect| {
        if pixels.is_empty() {
            return 0;
        }
        let [across, down] = [pixels.x1 - pixels.x0 + 1, pixels.y1 - pixels.y0 + 1].map(|n| n as u64);
        (across * context.cells.count as u64).div_ceil(STAMP) * down
    };
    sorted.clusters_of(tile).map(|cluster| of_cluster(cluster.pixels().intersect(in_memory))).sum()
}

#[cfg(test)]
mod tests {
    use tercio_raster::{Filter, SamplePattern, Sampling};

    use super::*;
    use crate::predict::calibrate::prepare;
    use crate::predict::views;

    const SIZE: (u32, u32) = (200, 150);

    fn soup() -> (Scene, Camera) {
        let (scene, bounds) = prepare(tercio_mesh::builtin::make("builtin:soup@3k").unwrap());
        (scene, views::camera(&bounds, SIZE, 0, 1))
    }

    fn in_tiles(edge: u32) -> Settings {
        Settings { tile_size: Some(edge), ..Settings::one_sample(SIZE.0, SIZE.1) }
    }

    /// There are as many clusters as the renderer counts, and their boxes are those of the triangles.
    #[test]
    fn boxes_of_loose_triangles_are_those_of_their_corners() {
        let (scene, camera) = soup();
        let settings = in_tiles(64);
        let mut renderer = Renderer::new();
        let stats = renderer.render(&scene, &camera, &settings).unwrap().stats;
        let context = FrameContext::new(&scene, &camera, &settings, 1).unwrap();
        let mut sorted = Sorted::default();
        renderer.sort(&context, &mut sorted);
        let tiles = 0..context.grid.count() as u32;
        let found: Vec<PixelRect> =
            tiles.flat_map(|tile| sorted.clusters_of(tile).map(|c| c.pixels())).collect();
        assert_eq!(found.len() as u64, stats.binning.cluster_entries);

        // By plain projection of the corners: a triangle that reaches a sample lies in the box of its cluster, except those
        // that are sorted one by one; and the boxes are not much larger than what is in them.
        let boxes = crate::predict::boxes::boxes(&scene, &camera, SIZE).unwrap().boxes;
        let visible = boxes.iter().filter(|b| b.visible);
        let exact: Vec<[u32; 4]> =
            visible.map(|b| [b.pixels.x0, b.pixels.x1, b.pixels.y0, b.pixels.y1].map(|v| v as u32)).collect();
        let area = |b: &[u32; 4]| f64::from(b[1] - b[0] + 1) * f64::from(b[3] - b[2] + 1);
        let mut whole: Vec<[u32; 4]> =
            found.iter().map(|b| [b.x0, b.x1, b.y0, b.y1].map(|v| v as u32)).collect();
        whole.sort_unstable();
        whole.dedup();
        let contains =
            |a: &[u32; 4], b: &[u32; 4]| a[0] <= b[0] && a[1] >= b[1] && a[2] <= b[2] && a[3] >= b[3];
        let alone = exact.iter().filter(|e| !whole.iter().any(|own| contains(own, e))).count() as u64;
        assert!(exact.len() > 2000 && alone <= stats.frontend.triangles_apart, "{alone} of {}", exact.len());
        let sum = |of: &[[u32; 4]]| of.iter().map(area).sum::<f64>();
        assert!(sum(&whole) < 4.0 * sum(&exact), "{} for {}", sum(&whole), sum(&exact));
    }

    /// Sample by sample: those of a row of a cluster are counted, and after every 16 of them a stamp begins.
    #[test]
    fn stamps_are_those_of_all_samples_that_are_compared() {
        let (scene, camera) = soup();
        let [one, four, sixteen] =
            [SamplePattern::Center, SamplePattern::Sparse4, SamplePattern::Sparse16].map(Sampling::of);
        let wide = Sampling { filter: Filter::Tent, ..four };
        let mut sums = Vec::new();
        for sampling in [one, four, sixteen, wide] {
            let settings = Settings { sampling, ..in_tiles(32) };
            let context = FrameContext::new(&scene, &camera, &settings, 1).unwrap();
            let mut sorted = Sorted::default();
            Renderer::new().sort(&context, &mut sorted);
            let (halo, each) = (context.grid.halo, settings.sampling.pattern.count());
            let by_sample: Vec<u64> = (0..context.grid.count() as u32)
                .map(|tile| {
                    let (left, top) = context.grid.corner(tile);
                    let has = |at: i32, first: u32, end: u32| {
                        at + halo as i32 >= first as i32 && at < (first + 32 + halo) as i32 && at < end as i32
                    };
                    let mut stamps = 0u64;
                    for cluster in sorted.clusters_of(tile) {
                        let [x0, x1, y0, y1] = cluster.rect.map(i32::from);
                        for _ in (y0..=y1).filter(|&y| has(y, top, SIZE.1)) {
                            let of_row = (x0..=x1).filter(|&x| has(x, left, SIZE.0)).flat_map(|_| 0..each);
                            stamps += of_row.enumerate().filter(|(k, _)| k.is_multiple_of(16)).count() as u64;
                        }
                    }
                    stamps
                })
                .collect();
            assert_eq!(stamps(&scene, &camera, &settings, 1).unwrap(), by_sample, "{sampling:?}");
            sums.push(by_sample.iter().sum::<u64>());
        }
        assert!(
            sums[..3].is_sorted() && sums[1] > sums[0] && sums[3] > sums[1] && sums[0] > 10_000,
            "{sums:?}"
        );
    }
}
