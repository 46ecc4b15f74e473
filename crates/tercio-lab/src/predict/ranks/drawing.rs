//! What every rank's renderer does.

use tercio_parallel::Organisation;
use tercio_raster::{Part, Settings, TileSet};
use tercio_scene::{Camera, Scene};

use super::traffic::Sharing;
use crate::predict::PredictError;
use crate::predict::counters::{Counters, count};

/// Counts every rank's part of a frame, all of it by [`count`]; nothing where a rank has neither clusters to draw nor
/// regions to own. `settings` say how the whole frame is drawn.
///
/// # Errors
/// A camera that makes no view.
pub fn drawing(
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    sharing: &Sharing,
) -> Result<Vec<Counters>, PredictError> {
    let owners = sharing.owners();
    let clusters = scene.instances.iter().map(|i| i.mesh.clusters().len() as u32).sum();
    let of_rank = |rank: usize| {
        let part = Part { number: rank as u32, of: sharing.ranks as u32 };
        let settings = match sharing.organisation {
            Organisation::SortLast if part.range(clusters).is_empty() && rank >= owners => {
                return Ok(Counters::default());
            }
            Organisation::SortLast => Settings { clusters: part, ..settings.clone() },
            Organisation::SortFirst if rank >= owners => return Ok(Counters::default()),
            Organisation::SortFirst => {
                let edge = settings.tile_edge();
                let tiles = settings.width.div_ceil(edge) as usize * settings.height.div_ceil(edge) as usize;
                let tiles = TileSet::every(part.of, part.number, tiles);
                Settings { tiles, tile_size: Some(edge), ..settings.clone() }
            }
            other => return Err(PredictError::Organisation(other)),
        };
        Ok(count(scene, camera, &settings, 1)?.frame)
    };
    (0..sharing.ranks).map(of_rank).collect()
}
