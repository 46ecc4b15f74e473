//! The work of every rank's renderer.

use tercio_parallel::Organisation;
use tercio_raster::{ClusterSet, Frame, Outputs, Settings, TileSet};
use tercio_scene::{Camera, Scene};

use super::traffic::Sharing;
use crate::predict::PredictError;
use crate::predict::counts::{Counters, TileWork, count_into};

/// What a rank has drawn.
pub struct Drawing {
    /// Its work, of which that for pixels is that of the tiles in which there may be something, if there are several ranks.
    pub counters: Counters,
    /// The work in each of these tiles, if several threads share it.
    pub tiles: Vec<TileWork>,
    /// The numbers of these tiles.
    pub touched: Vec<u32>,
    /// The picture, with keys.
    pub frame: Frame,
}

/// Counts a rank's part of a frame and draws it. `settings` are those of the whole frame; `owners` has the owner of each tile
/// in sort-first, `clusters` those of each rank in sort-last. The rank has some threads.
///
/// # Errors
/// What makes the frame impossible to draw.
pub fn drawing(
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    sharing: &Sharing,
    owners: &[u32],
    clusters: &[ClusterSet],
    (rank, threads): (usize, usize),
) -> Result<Drawing, PredictError> {
    let outputs = Outputs { keys: true, ..settings.outputs };
    let settings = Settings { outputs, tile_size: Some(sharing.edge), ..settings.clone() };
    let settings = match sharing.organisation {
        Organisation::SortLast => Settings { clusters: clusters[rank].clone(), ..settings },
        Organisation::SortFirst => {
            let tiles = TileSet::from_fn(owners.len(), |tile| owners[tile as usize] as usize == rank);
            Settings { tiles, ..settings }
        }
        other => return Err(PredictError::Organisation(other)),
    };
    let mut frame = Frame::default();
    let counted = count_into(scene, camera, &settings, threads, &mut frame)?;
    let is_touched = |tile: &u32| counted.tiles[*tile as usize].counters.tiles_used > 0;
    let touched: Vec<u32> = (0..counted.tiles.len() as u32).filter(is_touched).collect();
    // One rank draws the whole picture. What several have not touched, rank 0 clears when it collects.
    let pixels = match sharing.ranks {
        1 => counted.frame.pixels,
        _ => touched.iter().map(|&tile| sharing.pixels_of(tile)).sum(),
    };
    let of_threads: &[u32] = if threads > 1 { &touched } else { &[] };
    let tiles = of_threads.iter().map(|&tile| counted.tiles[tile as usize]).collect();
    Ok(Drawing { counters: Counters { pixels, ..counted.frame }, tiles, touched, frame })
}
