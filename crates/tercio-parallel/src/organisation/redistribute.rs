//! Sort-middle: what the front ends of a group's ranks have sorted into tiles is sent to the tiles' owners.
//!
//! Clusters travel as their numbers, bounds and depths, 16 bytes for about a hundred triangles, because every rank has the
//! meshes; triangles that were binned one by one as they are on the screen ([`Sorted::write_bytes`]). Of many ranks most have
//! nothing for each other: then they first learn who sends to whom.

use tercio_raster::binning::{Numbering, Sorted};
use tercio_raster::context::FrameContext;

use crate::comm::{Communicator, Group};
use crate::composite::Touched;
use crate::{ParallelError, RankReport};

/// Up to so many ranks send each other messages without content too: that takes fewer messages than to learn who sends any.
pub const FEW: usize = 8;

/// Exchanges bins between the ranks of a group: afterwards `sorted` has what all of them sorted into this rank's tiles.
/// `owners` has the owner of each tile, a rank of the group.
///
/// # Errors
/// [`ParallelError::Comm`], [`ParallelError::Bins`].
pub fn redistribute(
    group: &mut Group<'_, impl Communicator>,
    owners: &[u32],
    context: &FrameContext,
    sorted: &mut Sorted,
    report: &mut RankReport,
) -> Result<(), ParallelError> {
    let (own, count) = (group.rank(), group.size());
    let stages = &mut report.stages;
    let tiles = tiles_of_owners(owners, count);
    let mut numbering = Numbering::default();
    let are_few = count <= FEW;
    let mut withheld = Vec::new();
    // Every rank begins with the next one, so that no rank gets all messages at once.
    for to in (1..count).map(|step| (own + step) % count) {
        let mut message = group.buffer(to);
        let tiles = &tiles[to];
        stages.redistribute.time(|| sorted.write_bytes(&context.grid, tiles, &mut numbering, &mut message));
        report.bin_bytes += message.len() as u64;
        if are_few {
            group.send(to, message)?;
        } else if !message.is_empty() {
            withheld.push((to, message));
        }
    }
    let mut senders = None;
    if !are_few {
        let mut is_sent = vec![false; count];
        withheld.iter().for_each(|(to, _)| is_sent[*to] = true);
        senders = Some(Touched::gather(group, count, |to| is_sent[to as usize], &mut stages.wait)?);
    }
    for (to, message) in withheld {
        group.send(to, message)?;
    }
    let mut messages = Vec::new();
    for from in (1..count).map(|step| (own + count - step) % count) {
        if senders.as_ref().is_none_or(|sends| sends.is_touched(from, own as u32)) {
            messages.push((from, stages.wait.time(|| group.receive(from))?));
        }
    }
    let bytes = messages.iter().map(|(_, message)| &message[..]);
    let read = stages.redistribute.time(|| sorted.read_bytes(context, bytes));
    let wrong = |(number, source): (usize, _)| ParallelError::Bins {
        from: group.outer_rank(messages[number].0),
        source,
    };
    read.map_err(wrong)?;
    messages.into_iter().for_each(|(from, message)| group.give_back(from, message));
    Ok(())
}

/// The tiles of each of so many owners, in order.
pub fn tiles_of_owners(owners: &[u32], count: usize) -> Vec<Vec<u32>> {
    let mut tiles = vec![Vec::new(); count];
    for (tile, &owner) in (0..).zip(owners) {
        tiles[owner as usize].push(tile);
    }
    tiles
}
