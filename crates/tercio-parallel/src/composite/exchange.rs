//! Parts of tiles, sent between ranks and merged, in the rounds of a strategy.
//!
//! A message holds tiles: the number of a tile (4 bytes), the number of bytes of its content (8 bytes), and these bytes: a
//! [packet](super::packet) with keys, or [fragments](tercio_raster::frame::fragments). Numbers have the byte order of the machine.
//! Tiles in which nothing was drawn are left out.

use std::collections::BTreeMap;

use bytemuck::pod_read_unaligned;
use tercio_mesh::loops::prelude::*;
use tercio_raster::Outputs;
use tercio_raster::frame::FragmentMerger;

use super::packet::{self, Merged, PacketError};
use super::strategy::{Composition, Shared};
use crate::comm::Communicator;
use crate::{ParallelError, RankReport};

/// Bytes before the content of a tile.
pub const TILE_HEAD: usize = 12;

/// The contents of tiles, by number.
pub type Parts = BTreeMap<u32, Vec<u8>>;

/// What the parts of a tile are.
#[derive(Clone, Copy, Debug)]
pub enum Content {
    /// Packets of these planes, which include keys, of a picture of this width.
    Pixels {
        /// The planes.
        planes: Outputs,
        /// Pixels.
        width: u32,
    },
    /// Fragments.
    Fragments(FragmentMerger),
}

impl Content {
    /// Adds other ranks' parts of a tile to its own; `is_owned` if this rank does not hand them on. It decides then what is seen of
    /// fragments when it makes pixels of them: until then they are only listed.
    fn merge(&self, tile: &mut Incoming, is_owned: bool) -> Result<Merged, ParallelError> {
        let Incoming { tile, own, theirs } = tile;
        let mut sum = Merged::default();
        match self {
            Self::Fragments(merger) if !is_owned => {
                let own_and_theirs = [&own[..]].into_iter().chain(theirs.iter().map(|(_, bytes)| *bytes));
                let parts: Vec<&[u8]> = own_and_theirs.filter(|part| !part.is_empty()).collect();
                let mut merged = Vec::with_capacity(parts.iter().map(|part| part.len()).sum());
                match parts[..] {
                    [only] => merged.extend_from_slice(only),
                    _ => merger.merge(*tile, &parts, &mut merged)?,
                }
                *own = merged;
            }
            Self::Fragments(_) => theirs.iter().for_each(|(_, bytes)| own.extend_from_slice(bytes)),
            Self::Pixels { planes, width } => {
                for &(from, bytes) in &*theirs {
                    let merged = packet::merge(own, bytes, planes, *width);
                    let (both, of) = merged.map_err(|source| ParallelError::Packet { from, source })?;
                    *own = both;
                    sum = Merged { pixels: sum.pixels + of.pixels, won: sum.won + of.won };
                }
            }
        }
        Ok(sum)
    }
}

/// Brings all parts of the shared tiles to one rank each ([`Composition::owners`]): this rank has `parts`, and gets those of the
/// tiles that it owns, merged. Ranks that have none of the tiles need not call this.
///
/// # Errors
/// [`ParallelError::Comm`], [`ParallelError::Packet`], [`ParallelError::Fragments`].
pub fn exchange(
    comm: &mut impl Communicator,
    composition: Composition,
    shared: &Shared,
    mut parts: Parts,
    content: Content,
    report: &mut RankReport,
) -> Result<Parts, ParallelError> {
    let Ok(place) = shared.ranks.binary_search(&comm.rank()) else { return Ok(parts) };
    let owners = composition.owners(shared);
    let is_owned = |tile: u32| shared.tiles.binary_search(&tile).is_ok_and(|at| owners[at] == place);
    let stages = &mut report.stages;
    let mut last_sender = comm.rank();
    for round in composition.rounds(shared, place) {
        for (to, tiles) in round.sends {
            let to = shared.ranks[to];
            let mut message = comm.buffer(to);
            let sent = stages.compose.time(|| put_all(&tiles, &mut parts, content, &mut message));
            report.pixels.sent +=
                sent.map_err(|source| ParallelError::Packet { from: comm.rank(), source })?;
            if matches!(content, Content::Fragments(_)) {
                report.pixels.fragment_bytes += message.len() as u64;
            }
            comm.send(to, message)?;
        }
        let mut messages = Vec::new();
        for from in round.receives {
            let from = shared.ranks[from];
            messages.push((from, stages.wait.time(|| comm.receive(from))?));
        }
        let merged =
            stages.compose.time(|| take_in(&mut parts, &messages, shared.tiles, is_owned, content))?;
        report.pixels.compared += merged.pixels;
        report.pixels.won += merged.won;
        messages.iter().for_each(|(from, _)| last_sender = *from);
        messages.into_iter().for_each(|(from, message)| comm.give_back(from, message));
    }
    match parts.keys().find(|tile| !is_owned(**tile)) {
        Some(&tile) => Err(ParallelError::Packet { from: last_sender, source: PacketError::Tile { tile } }),
        None => Ok(parts),
    }
}

/// Moves the parts of some tiles into a message, and returns their number of pixels.
fn put_all(
    tiles: &[u32],
    parts: &mut Parts,
    content: Content,
    message: &mut Vec<u8>,
) -> Result<u64, PacketError> {
    let mut pixels = 0;
    for (tile, bytes) in tiles.iter().filter_map(|tile| parts.remove_entry(tile)) {
        if let Content::Pixels { planes, .. } = &content {
            pixels += packet::count_pixels(&bytes, planes)?;
        }
        put(tile, &bytes, message);
    }
    Ok(pixels)
}

/// A tile, its content, and that of other ranks.
struct Incoming<'a> {
    tile: u32,
    own: Vec<u8>,
    theirs: Vec<(usize, &'a [u8])>,
}

/// Merges the tiles of messages into those that this rank has.
fn take_in(
    parts: &mut Parts,
    messages: &[(usize, Vec<u8>)],
    tiles: &[u32],
    is_owned: impl Fn(u32) -> bool + Sync,
    content: Content,
) -> Result<Merged, ParallelError> {
    let mut incoming: BTreeMap<u32, Vec<(usize, &[u8])>> = BTreeMap::new();
    for &(from, ref message) in messages {
        let malformed = |source| ParallelError::Packet { from, source };
        for (tile, bytes) in take_apart(message).map_err(malformed)? {
            if tiles.binary_search(&tile).is_err() {
                return Err(malformed(PacketError::Tile { tile }));
            }
            incoming.entry(tile).or_default().push((from, bytes));
        }
    }
    let mut work: Vec<Incoming> = Vec::new();
    for (tile, theirs) in incoming {
        work.push(Incoming { tile, own: parts.remove(&tile).unwrap_or_default(), theirs });
    }
    let merge = |tile: &mut Incoming| content.merge(tile, is_owned(tile.tile));
    let merged: Result<Vec<Merged>, ParallelError> = work.par_iter_mut().with_max_len(1).map(merge).collect();
    parts.extend(work.into_iter().map(|Incoming { tile, own, .. }| (tile, own)));
    let add = |a: Merged, b: Merged| Merged { pixels: a.pixels + b.pixels, won: a.won + b.won };
    Ok(merged?.into_iter().fold(Merged::default(), add))
}

/// Appends a tile to a message.
fn put(tile: u32, bytes: &[u8], out: &mut Vec<u8>) {
    out.reserve(TILE_HEAD + bytes.len());
    out.extend(tile.to_ne_bytes());
    out.extend((bytes.len() as u64).to_ne_bytes());
    out.extend_from_slice(bytes);
}

/// The tiles of a message.
fn take_apart(message: &[u8]) -> Result<Vec<(u32, &[u8])>, PacketError> {
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
    fn tiles_are_taken_apart_as_they_were_put_together() {
        let tiles = [(3, vec![1, 2, 3]), (5, Vec::new()), (u32::MAX, vec![0; 100])];
        let mut message = Vec::new();
        for (tile, bytes) in &tiles {
            put(*tile, bytes, &mut message);
        }
        let found = take_apart(&message).unwrap();
        assert_eq!(found, tiles.each_ref().map(|(tile, bytes)| (*tile, &bytes[..])));
        assert_eq!(take_apart(&message[..20]), Err(PacketError::Short { at: 15 }));
        assert_eq!(take_apart(&message[..14]), Err(PacketError::Short { at: 0 }));
        let endless = [&7u32.to_ne_bytes()[..], &u64::MAX.to_ne_bytes()].concat();
        assert_eq!(take_apart(&endless), Err(PacketError::Short { at: 0 }));
    }

    #[test]
    fn tiles_that_nobody_sends_are_refused() {
        let mut message = Vec::new();
        put(4, &[1], &mut message);
        let content = Content::Fragments(FragmentMerger::default());
        let take =
            |tiles: &[u32]| take_in(&mut Parts::new(), &[(2, message.clone())], tiles, |_| true, content);
        assert!(take(&[4]).is_ok());
        let error = take(&[3, 5]).unwrap_err().to_string();
        assert!(error.contains("rank 2") && error.contains("tile 4"), "{error}");
    }
}
