//! Fragments, sent to the owners of their tiles, who make pixels from them.
//!
//! A message holds tiles: the number of a tile (4 bytes), the number of bytes of its fragments (8 bytes), and these bytes,
//! which are those of [`tercio_raster::frame::fragments`]. Numbers have the byte order of the machine. Tiles without fragments are left out.

use bytemuck::pod_read_unaligned;
use rayon::ThreadPool;
use tercio_raster::context::FrameContext;
use tercio_raster::frame::{FragmentsOfTile, TileFragments};
use tercio_raster::{Frame, Renderer};

use super::packet::PacketError;
use crate::comm::Communicator;
use crate::regions::Regions;
use crate::{ParallelError, RankReport};

/// Bytes before the fragments of a tile.
const TILE_HEAD: usize = 12;

/// Sends the fragments that this rank has drawn in some regions to their owners, and makes the pixels of its own regions from
/// those of all ranks.
///
/// `sees(rank)` returns whether a rank drew anything at all: the others send nothing and are not waited for. All ranks have to
/// agree on it. The threads of the pool merge.
///
/// # Errors
/// [`ParallelError::Comm`], [`ParallelError::Packet`], [`ParallelError::Fragments`].
pub fn exchange(
    comm: &mut impl Communicator,
    regions: &Regions,
    sees: impl Fn(usize) -> bool,
    drawn: &[TileFragments],
    (pool, renderer, context): (&ThreadPool, &mut Renderer, &FrameContext),
    frame: &mut Frame,
    report: &mut RankReport,
) -> Result<(), ParallelError> {
    let (rank, size) = (comm.rank(), comm.size());
    let stages = &mut report.stages;
    let others = |step: usize| (rank + step) % size;
    if sees(rank) {
        for to in (1..size).map(others).filter(|&to| to < regions.owners()) {
            let mut message = comm.buffer(to);
            stages.compose.time(|| {
                let of_owner = drawn.iter().filter(|of| regions.owner(of.tile.into()) == to);
                of_owner.for_each(|of_tile| pack(of_tile, &mut message));
            });
            report.pixels.fragment_bytes += message.len() as u64;
            comm.send(to, message)?;
        }
    }
    if rank >= regions.owners() {
        return Ok(());
    }
    let mut messages = Vec::new();
    for from in (1..size).map(|step| others(size - step)).filter(|&from| sees(from)) {
        messages.push((from, stages.wait.time(|| comm.receive(from))?));
    }
    let own = drawn.iter().map(|of| (of.tile, &of.bytes[..]));
    let mut parts: Vec<_> =
        own.filter(|of| regions.owner(of.0.into()) == rank).map(|of| (rank, of)).collect();
    for &(from, ref message) in &messages {
        let tiles = unpack(message).map_err(|source| ParallelError::Packet { from, source })?;
        parts.extend(tiles.into_iter().map(|of| (from, of)));
    }
    let tile = |tile: u64| FragmentsOfTile { tile: tile as u32, parts: Vec::new() };
    let mut tiles: Vec<FragmentsOfTile> = regions.numbers_of(rank).map(tile).collect();
    for (from, (tile, bytes)) in parts {
        let place = tiles.binary_search_by_key(&tile, |of| of.tile);
        let place = place.map_err(|_| ParallelError::Packet { from, source: PacketError::Tile { tile } })?;
        tiles[place].parts.push(bytes);
    }
    pool.install(|| stages.compose.time(|| renderer.merge(context, &tiles, frame)))?;
    messages.into_iter().for_each(|(from, message)| comm.give_back(from, message));
    Ok(())
}

/// Appends the fragments of a tile to a message.
fn pack(of_tile: &TileFragments, out: &mut Vec<u8>) {
    out.reserve(TILE_HEAD + of_tile.bytes.len());
    out.extend(of_tile.tile.to_ne_bytes());
    out.extend((of_tile.bytes.len() as u64).to_ne_bytes());
    out.extend_from_slice(&of_tile.bytes);
}

/// The tiles of a message.
fn unpack(message: &[u8]) -> Result<Vec<(u32, &[u8])>, PacketError> {
    let (mut tiles, mut rest) = (Vec::new(), message);
    while !rest.is_empty() {
        let short = PacketError::Short { at: message.len() - rest.len() };
        let (head, body) = rest.split_at_checked(TILE_HEAD).ok_or(short)?;
        let (tile, length): (u32, u64) = (pod_read_unaligned(&head[..4]), pod_read_unaligned(&head[4..]));
        let length = usize::try_from(length).map_err(|_| short)?;
        let (bytes, behind) = body.split_at_checked(length).ok_or(short)?;
        tiles.push((tile, bytes));
        rest = behind;
    }
    Ok(tiles)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_are_unpacked_as_they_were_packed() {
        let tiles = [(3, vec![1, 2, 3]), (5, Vec::new()), (u32::MAX, vec![0; 100])];
        let mut message = Vec::new();
        for (tile, bytes) in &tiles {
            pack(&TileFragments { tile: *tile, bytes: bytes.clone() }, &mut message);
        }
        let found = unpack(&message).unwrap();
        assert_eq!(found, tiles.each_ref().map(|(tile, bytes)| (*tile, &bytes[..])));
        assert_eq!(unpack(&message[..20]), Err(PacketError::Short { at: 15 }));
        assert_eq!(unpack(&message[..14]), Err(PacketError::Short { at: 0 }));
        let endless = [&7u32.to_ne_bytes()[..], &u64::MAX.to_ne_bytes()].concat();
        assert_eq!(unpack(&endless), Err(PacketError::Short { at: 0 }));
    }
}
