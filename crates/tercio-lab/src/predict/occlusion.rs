//! The samples that the renderer looks at to find out whether a cluster is hidden.
//!
//! A cluster is hidden in a tile if all samples that it may reach there show something nearer. They are compared 16 at a
//! time, until one is found that does not. So a hidden cluster takes time for all of its samples, which is much for
//! loose triangles: each is a cluster of its own, and nothing is known of it but its box. The renderer does not count
//! these comparisons; they follow from the boxes, in the message that ranks send each other in sort-middle.

use tercio_raster::binning::{Numbering, Sorted};
use tercio_raster::context::FrameContext;
use tercio_raster::{Renderer, Settings};
use tercio_scene::{Camera, Scene};

use super::PredictError;
use super::choose::rates::{BIN_CLUSTER, BIN_HEAD, BIN_TILE};

/// Bytes of the message's header, of that of a tile, and of a cluster ([`Sorted::write_bytes`]).
const HEAD: usize = BIN_HEAD as usize;
const TILE_HEAD: usize = BIN_TILE as usize;
const CLUSTER: usize = BIN_CLUSTER as usize;
/// Samples of a stamp, side by side.
const STAMP: u32 = 16;

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
    let grid = &context.grid;
    let (mut sorted, mut message) = (Sorted::default(), Vec::new());
    Renderer::new().sort(&context, &mut sorted);
    let all: Vec<u32> = (0..grid.count() as u32).collect();
    sorted.write_bytes(grid, &all, &mut Numbering::default(), &mut message);
    let edge = 1u32 << grid.shift;
    let mut stamps = vec![0; all.len()];
    for (tile, [x0, x1, y0, y1]) in clusters(&message) {
        let (left, top) = grid.corner(tile);
        let across = (x1.min(left + edge - 1) + 1).saturating_sub(x0.max(left));
        let down = (y1.min(top + edge - 1) + 1).saturating_sub(y0.max(top));
        if let Some(sum) = stamps.get_mut(tile as usize) {
            *sum += u64::from(across.div_ceil(STAMP)) * u64::from(down);
        }
    }
    Ok(stamps)
}

/// The clusters of a message, each with its tile: first and last column, first and last row.
fn clusters(message: &[u8]) -> impl Iterator<Item = (u32, [u32; 4])> {
    let number = |at: usize| {
        let bytes = message.get(at..at + 4).and_then(|b| b.try_into().ok());
        bytes.map_or(0, u32::from_ne_bytes)
    };
    // Of the header: the number of tiles with entries, and at its end that of clusters, which end the message.
    let (tiles, entries) = (number(HEAD - 16) as usize, number(HEAD - 4) as usize);
    let first = message.len().saturating_sub(entries * CLUSTER);
    let tiles = (0..tiles).map(move |k| HEAD + k * TILE_HEAD);
    let of_tiles = tiles.flat_map(move |at| std::iter::repeat_n(number(at), number(at + 8) as usize));
    let boxes = message[first..].as_chunks::<CLUSTER>().0.iter();
    of_tiles.zip(boxes.map(|c| [8, 10, 12, 14].map(|at| u32::from(u16::from_ne_bytes([c[at], c[at + 1]])))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::predict::calibrate::prepare;
    use crate::predict::views;

    /// The message holds as many clusters as the renderer counts, and their boxes are those of the triangles.
    #[test]
    fn boxes_of_loose_triangles_are_those_of_their_corners() {
        let (scene, bounds) = prepare(tercio_mesh::builtin::make("builtin:soup@3k").unwrap());
        let (width, height) = (200, 150);
        let camera = views::camera(&bounds, (width, height), 0, 1);
        let settings = Settings { tile_size: Some(64), ..Settings::one_sample(width, height) };
        let mut renderer = Renderer::new();
        let stats = renderer.render(&scene, &camera, &settings).unwrap().stats;
        let context = FrameContext::new(&scene, &camera, &settings, 1).unwrap();
        let (mut sorted, mut message) = (Sorted::default(), Vec::new());
        renderer.sort(&context, &mut sorted);
        let all: Vec<u32> = (0..context.grid.count() as u32).collect();
        sorted.write_bytes(&context.grid, &all, &mut Numbering::default(), &mut message);
        let found: Vec<_> = clusters(&message).collect();
        assert_eq!(found.len() as u64, stats.binning.cluster_entries);

        // By plain projection of the corners: a triangle that reaches a sample lies in the box of its cluster, except those
        // that are sorted one by one; and the boxes are not much larger than what is in them.
        let boxes = crate::predict::boxes::boxes(&scene, &camera, (width, height)).unwrap().boxes;
        let visible = boxes.iter().filter(|b| b.visible);
        let exact: Vec<[u32; 4]> =
            visible.map(|b| [b.pixels.x0, b.pixels.x1, b.pixels.y0, b.pixels.y1].map(|v| v as u32)).collect();
        let area = |b: &[u32; 4]| f64::from(b[1] - b[0] + 1) * f64::from(b[3] - b[2] + 1);
        let mut whole: Vec<[u32; 4]> = found.iter().map(|f| f.1).collect();
        whole.sort_unstable();
        whole.dedup();
        let contains =
            |a: &[u32; 4], b: &[u32; 4]| a[0] <= b[0] && a[1] >= b[1] && a[2] <= b[2] && a[3] >= b[3];
        let alone = exact.iter().filter(|e| !whole.iter().any(|own| contains(own, e))).count() as u64;
        assert!(exact.len() > 2000 && alone <= stats.frontend.triangles_apart, "{alone} of {}", exact.len());
        let sum = |of: &[[u32; 4]]| of.iter().map(area).sum::<f64>();
        assert!(sum(&whole) < 4.0 * sum(&exact), "{} for {}", sum(&whole), sum(&exact));

        let of_tiles: u64 = stamps(&scene, &camera, &settings, 1).unwrap().iter().sum();
        // At least a stamp for 16 of the boxes' samples inside tiles, at most one for each.
        let samples: f64 = found
            .iter()
            .map(|f| {
                let (left, top) = context.grid.corner(f.0);
                let [x0, x1, y0, y1] = f.1;
                area(&[x0.max(left), x1.min(left + 63), y0.max(top), y1.min(top + 63)])
            })
            .sum();
        assert!((of_tiles as f64) >= samples / 16.0 && (of_tiles as f64) <= samples, "{of_tiles} {samples}");
    }
}
