//! Do the parts of a scene make whole models? Otherwise the picture would be wrong.

use bytemuck::{Pod, Zeroable, cast_slice, pod_read_unaligned};
use tercio_scene::{Instance, Scene};

use super::PartsError;
use crate::ParallelError;
use crate::comm::{CommError, Communicator};

/// A rank's part of an instance.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Held {
    first: u64,
    triangles: u64,
    /// Triangles of the whole model.
    of: u64,
    /// 1 if the instance may be less than opaque.
    translucent: u64,
    /// 1 if the triangles have the numbers of the whole model, and need not be a range.
    numbered: u64,
}

/// Checks that the shares of all ranks are ranges of the triangles of the same models, without gaps, in the order of the ranks,
/// or have the numbers of the whole and are as many as it has; and that ranks agree on what is opaque. All ranks have to call this if any instance of their scenes has a share.
///
/// # Errors
/// [`PartsError`] on all ranks, [`ParallelError::Comm`].
pub fn check(comm: &mut impl Communicator, scene: &Scene) -> Result<(), ParallelError> {
    let held = |(number, instance): (usize, &Instance)| {
        // They are of the triangles of a mesh, and the ranks exchange these.
        if instance.edges.as_ref().is_some_and(|edges| edges.sides.is_some()) {
            return Err(PartsError::Edges { instance: number });
        }
        let share = instance.share.ok_or(PartsError::Whole { instance: number })?;
        let (first, triangles, of) =
            (share.first_triangle, instance.mesh.triangle_count() as u64, share.triangles);
        let (translucent, numbered) = (instance.is_translucent().into(), share.has_whole_numbers.into());
        Ok(Held { first, triangles, of, translucent, numbered })
    };
    let own: Vec<Held> = scene.instances.iter().enumerate().map(held).collect::<Result<_, PartsError>>()?;
    let blocks = comm.all_gather(cast_slice(&own).to_vec())?;
    let read = |block: &Vec<u8>| block.chunks_exact(size_of::<Held>()).map(pod_read_unaligned).collect();
    let all: Vec<Vec<Held>> = blocks.iter().map(read).collect();
    if let Some(rank) = all.iter().position(|held| held.len() != own.len()) {
        let reason = format!("parts of {} instances, expected {}", all[rank].len(), own.len());
        return Err(CommError::Transport { rank, reason }.into());
    }
    for (instance, Held { of, translucent, numbered, .. }) in all[0].iter().copied().enumerate() {
        let mut next = 0u64;
        for (rank, held) in all.iter().map(|held| held[instance]).enumerate() {
            let end = next.saturating_add(held.triangles);
            let is_complete = rank + 1 < all.len() || end == of;
            let first = if numbered > 0 { 0 } else { next };
            if (held.first, held.of, held.numbered) != (first, of, numbered) || !is_complete {
                let Held { first, triangles, of, .. } = held;
                return Err(PartsError::Share { instance, rank, first, triangles, of }.into());
            }
            if held.translucent != translucent {
                return Err(PartsError::Translucency { instance, rank }.into());
            }
            next = end;
        }
    }
    Ok(())
}
