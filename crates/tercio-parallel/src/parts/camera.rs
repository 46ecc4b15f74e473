//! The camera that frames all parts.

use std::cell::RefCell;

use tercio_scene::{Camera, Framing, Scene};

use crate::ParallelError;
use crate::comm::Communicator;
use crate::comm::collective::all_max;

/// The camera of [`Framing::camera_for_scene`] for the whole models of which the scene has parts, to the last bit. All ranks
/// have to call this with the same framing, and parts that were [numbered](super::number), so that they have the bounds of the
/// whole.
///
/// # Errors
/// [`ParallelError::Comm`].
pub fn camera_for_scene(
    comm: &mut impl Communicator,
    framing: &Framing,
    scene: &Scene,
) -> Result<Camera, ParallelError> {
    // All ranks know the same after every call, so they make the same calls.
    let state = RefCell::new((comm, None));
    let camera = framing.camera_for_reach(&scene.bounds(), |direction, from| {
        let (comm, failed) = &mut *state.borrow_mut();
        if failed.is_some() {
            return f64::NEG_INFINITY;
        }
        match all_max(*comm, [scene.reach(direction, from)]) {
            Ok([reach]) => reach,
            Err(error) => {
                *failed = Some(error);
                f64::NEG_INFINITY
            }
        }
    });
    match state.into_inner().1 {
        Some(error) => Err(error.into()),
        None => Ok(camera),
    }
}
