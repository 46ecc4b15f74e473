//! What ranks find out about their parts before they have clusters.

use tercio_mesh::Aabb;

use super::PartsError;
use crate::ParallelError;
use crate::comm::Communicator;
use crate::comm::collective::all_max;

/// The bounds of those of all ranks. All ranks have to call this.
///
/// # Errors
/// [`ParallelError::Comm`].
pub fn bounds_of_all(comm: &mut impl Communicator, own: &Aabb) -> Result<Aabb, ParallelError> {
    // The least coordinate is minus the largest of the negative ones; empty bounds reach from infinity to minus infinity.
    let (min, max) = (-own.min, own.max);
    let all = all_max(comm, [min.x, min.y, min.z, max.x, max.y, max.z])?;
    Ok(Aabb { min: [-all[0], -all[1], -all[2]].into(), max: [all[3], all[4], all[5]].into() })
}

/// Fails on all ranks if a rank passes another number than rank 0; `what` says then what it has in place of that of rank 0.
///
/// # Errors
/// [`PartsError::Differs`], [`ParallelError::Comm`].
pub fn agree(comm: &mut impl Communicator, number: u64, what: &'static str) -> Result<(), ParallelError> {
    let blocks = comm.all_gather(number.to_le_bytes().to_vec())?;
    match blocks.iter().position(|block| *block != blocks[0]) {
        Some(rank) => Err(PartsError::Differs { rank, what }.into()),
        None => Ok(()),
    }
}
