//! The work of every rank's renderer.

use tercio_parallel::Organisation;
use tercio_raster::{Frame, Outputs, Part, Settings, TileSet};
use tercio_scene::{Camera, Scene};

use super::traffic::Sharing;
use crate::predict::PredictError;
use crate::predict::counts::{Counters, count_into};

/// Counts a rank's part of a frame and draws it, with keys; `None` if the rank has neither clusters to draw nor regions
/// to own. `settings` are those of the whole frame.
///
/// # Errors
/// What makes the frame impossible to draw.
pub fn drawing(
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    sharing: &Sharing,
    rank: usize,
) -> Result<Option<(Counters, Frame)>, PredictError> {
    let owners = sharing.owners();
    let clusters = scene.instances.iter().map(|i| i.mesh.clusters().len() as u32).sum();
    let part = Part { number: rank as u32, of: sharing.ranks as u32 };
    let outputs = Outputs { keys: true, ..settings.outputs };
    let settings = Settings { outputs, ..settings.clone() };
    let settings = match sharing.organisation {
        Organisation::SortLast if part.range(clusters).is_empty() && rank >= owners => return Ok(None),
        Organisation::SortLast => Settings { clusters: part, ..settings },
        Organisation::SortFirst if rank >= owners => return Ok(None),
        Organisation::SortFirst => {
            let edge = settings.tile_edge();
            let tiles = TileSet::every(part.of, part.number, settings.tiles_of(edge));
            Settings { tiles, tile_size: Some(edge), ..settings }
        }
        other => return Err(PredictError::Organisation(other)),
    };
    let mut frame = Frame::default();
    let counted = count_into(scene, camera, &settings, 1, &mut frame)?;
    Ok(Some((counted.frame, frame)))
}
