//! The shadow maps of all parts.

use tercio_raster::{Settings, ShadowArea, ShadowMaps};
use tercio_scene::{Camera, Scene};

use crate::ParallelError;
use crate::comm::Communicator;
use crate::comm::collective::all_reduce_arrays;

/// Texels that are sent at a time, so that messages take little memory: 1 MiB.
const BLOCK: usize = 1 << 18;

/// The maps of [`ShadowMaps::draw`] for the whole models of which the scene has parts, to the last bit, on all ranks. Every rank
/// draws those of its own parts; at every texel the surface that is nearest to the light counts. All ranks have to call this with
/// the same arguments, except for the triangles of the parts, which were [numbered](super::number).
///
/// Draws in the rayon pool it is called in.
///
/// # Errors
/// As [`ShadowMaps::draw`], and [`ParallelError::Comm`].
pub fn shadow_maps(
    comm: &mut impl Communicator,
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    (size, area): (u32, ShadowArea),
) -> Result<ShadowMaps, ParallelError> {
    let mut maps = ShadowMaps::draw(scene, camera, settings, (size, area))?;
    for texels in maps.nearness_mut() {
        for block in texels.chunks_mut(BLOCK) {
            // The order of 0 and -0 does not depend on the order of ranks.
            let nearest = |a: f32, b: f32| if b.total_cmp(&a).is_gt() { b } else { a };
            all_reduce_arrays(comm, block, nearest)?;
        }
    }
    Ok(maps)
}
