//! Merges the fragments of a tile that several ranks have drawn, without what they hide of each other, as bytes: a rank that hands on
//! what others have sent sends no more than can be seen.
//!
//! A fragment has its colour and its depth at each of its samples, and its owner decides at each sample which are seen: so what
//! is known here suffices to decide the same. At a sample, the opaque fragment with the largest [`wide_key`] is seen, and the others
//! that have larger keys. A fragment loses the samples at which it is not seen, and is left out if it has none then; nothing else of
//! it changes, because it is shaded before. What is left out hides nothing that what hides it does not hide, so that the picture
//! is the same however parts are merged. In blocks that one of the parts has finished nothing is left.
//!
//! Ranks write the opaque fragments of a tile pixel by pixel, row by row; merged parts have all of them in this order, those of a
//! pixel in the order of the parts, behind the records of finished blocks. So parts are merged in one pass, in which pixels of one
//! part alone are copied in runs. Only what is not opaque comes in another order from who draws it, and is looked up by a list of places.

use bytemuck::{bytes_of, pod_read_unaligned};

use super::{FragmentError, FragmentHead, FragmentLayout, TileFragment};
use crate::depth_bounds::BLOCK_BITS;
use crate::frame::wide_key;
use crate::sampling::MAX_SAMPLES;

/// Merges fragments of tiles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FragmentMerger {
    /// What the fragments have.
    pub layout: FragmentLayout,
    /// log2 of the distance of two rows of places.
    pub stride_bits: u32,
    /// Blocks across a tile.
    pub blocks_across: usize,
}

/// The place behind the last fragment.
const END: u32 = u32::MAX;

/// Why a part cannot be read in order.
enum Stop {
    /// Its fragments are not in the order of their places.
    Disordered,
    Invalid(FragmentError),
}

impl From<FragmentError> for Stop {
    fn from(error: FragmentError) -> Self {
        Self::Invalid(error)
    }
}

/// The fragments of a part that are not read yet.
struct Rest<'a> {
    bytes: &'a [u8],
    /// Where the next one begins.
    at: usize,
    /// Its number of bytes.
    length: usize,
    /// Its place, or [`END`].
    place: u32,
    /// If they are not in order: places and beginnings of those behind it, the last one first.
    later: Option<Vec<(u16, usize)>>,
}

/// Which blocks of a tile are finished.
struct FinishedBlocks {
    flags: Vec<bool>,
    any: bool,
}

impl FragmentMerger {
    /// Appends the fragments of the parts of a tile, without those that are not seen because of other parts.
    ///
    /// # Errors
    /// [`FragmentError`]; what is appended is not valid then.
    pub fn merge(&self, tile: u32, parts: &[&[u8]], out: &mut Vec<u8>) -> Result<(), FragmentError> {
        let begin = out.len();
        match self.merge_ordered(tile, parts, false, out) {
            Ok(()) => Ok(()),
            Err(Stop::Invalid(error)) => Err(error),
            Err(Stop::Disordered) => {
                out.truncate(begin);
                match self.merge_ordered(tile, parts, true, out) {
                    Err(Stop::Invalid(error)) => Err(error),
                    _ => Ok(()),
                }
            }
        }
    }

    /// The same; stops at what is not in order unless it `sorts`.
    fn merge_ordered(&self, tile: u32, parts: &[&[u8]], sorts: bool, out: &mut Vec<u8>) -> Result<(), Stop> {
        let mut finished = FinishedBlocks { flags: vec![false; self.blocks_across.pow(2)], any: false };
        let mut rests = Vec::with_capacity(parts.len());
        for &bytes in parts {
            let mut rest = Rest { bytes, at: 0, length: 0, place: 0, later: None };
            if sorts {
                self.sort(tile, &mut rest, &mut finished)?;
            } else {
                self.read_finished(tile, &mut rest, &mut finished)?;
                self.find_next(tile, &mut rest)?;
            }
            rests.push(rest);
        }
        finished.write(self.layout, out);
        let mut here = Vec::new();
        loop {
            // The next place, the place behind it, and the first part that has a fragment there.
            let (mut place, mut behind, mut first) = (END, END, 0);
            for (number, rest) in rests.iter().enumerate() {
                if rest.place < place {
                    (place, behind, first) = (rest.place, place, number);
                } else {
                    behind = behind.min(rest.place);
                }
            }
            if place == END {
                return Ok(());
            }
            if place < behind {
                self.copy_until(behind, tile, &mut rests[first], &finished, out)?;
                continue;
            }
            here.clear();
            for rest in rests.iter_mut().filter(|rest| rest.place == place) {
                while rest.place == place {
                    here.push(&rest.bytes[rest.at..rest.at + rest.length]);
                    self.advance(tile, rest)?;
                }
            }
            if !self.is_finished(place, &finished) {
                write_seen(self.layout, &here, out);
            }
        }
    }

    /// Copies the fragments of places before another one.
    fn copy_until(
        &self,
        end: u32,
        tile: u32,
        rest: &mut Rest,
        finished: &FinishedBlocks,
        out: &mut Vec<u8>,
    ) -> Result<(), Stop> {
        let mut run = rest.at..rest.at;
        while rest.place < end {
            if rest.at != run.end {
                out.extend_from_slice(&rest.bytes[run]);
                run = rest.at..rest.at;
            }
            if !self.is_finished(rest.place, finished) {
                run.end += rest.length;
            }
            self.advance(tile, rest)?;
        }
        out.extend_from_slice(&rest.bytes[run]);
        Ok(())
    }

    /// Goes on to the next fragment.
    #[inline(always)]
    fn advance(&self, tile: u32, rest: &mut Rest) -> Result<(), Stop> {
        match &mut rest.later {
            None => rest.at += rest.length,
            Some(later) => {
                rest.at = later.pop().map_or(rest.bytes.len(), |(_, at)| at);
                rest.place = 0;
            }
        }
        self.find_next(tile, rest)
    }

    /// Finds out what is next, of which the beginning is known.
    #[inline(always)]
    fn find_next(&self, tile: u32, rest: &mut Rest) -> Result<(), Stop> {
        let (place, mask, length) = match self.head(tile, rest)? {
            Some((head, length)) => (u32::from(head.place), head.mask, length),
            None => (END, 1, 0),
        };
        if mask == 0 || place < rest.place {
            return Err(Stop::Disordered);
        }
        (rest.place, rest.length) = (place, length);
        Ok(())
    }

    /// The head of what is next, and its number of bytes.
    #[inline(always)]
    fn head(&self, tile: u32, rest: &Rest) -> Result<Option<(FragmentHead, usize)>, FragmentError> {
        let bytes = &rest.bytes[rest.at..];
        if bytes.is_empty() {
            return Ok(None);
        }
        let short = FragmentError::Short { tile, at: rest.at };
        let (head, _) = bytes.split_at_checked(size_of::<FragmentHead>()).ok_or(short)?;
        let head: FragmentHead = pod_read_unaligned(head);
        let length = self.layout.bytes(head.mask.count_ones() as usize);
        if length > bytes.len() { Err(short) } else { Ok(Some((head, length))) }
    }

    /// Reads records of finished blocks.
    fn read_finished(
        &self,
        tile: u32,
        rest: &mut Rest,
        all: &mut FinishedBlocks,
    ) -> Result<(), FragmentError> {
        while let Some((head, length)) = self.head(tile, rest)?
            && head.mask == 0
        {
            let first = usize::from(head.place);
            let flags = all.flags.get_mut(first..first.saturating_add(head.primitive as usize));
            let blocks = flags.ok_or(FragmentError::Blocks { tile, at: rest.at, first: head.place })?;
            blocks.fill(true);
            all.any = true;
            rest.at += length;
        }
        Ok(())
    }

    /// Reads records of finished blocks among the fragments, and makes a list of these.
    fn sort(&self, tile: u32, rest: &mut Rest, all: &mut FinishedBlocks) -> Result<(), Stop> {
        let mut places = Vec::new();
        loop {
            self.read_finished(tile, rest, all)?;
            let Some((head, length)) = self.head(tile, rest)? else { break };
            places.push((head.place, rest.at));
            rest.at += length;
        }
        // Those of a pixel stay in order.
        places.sort_unstable();
        places.reverse();
        rest.later = Some(places);
        self.advance(tile, rest)
    }

    /// Is a place in a finished block?
    #[inline(always)]
    fn is_finished(&self, place: u32, finished: &FinishedBlocks) -> bool {
        if !finished.any {
            return false;
        }
        let (row, column) = (place >> self.stride_bits, place & ((1 << self.stride_bits) - 1));
        let [row, column] = [row, column].map(|at| (at >> BLOCK_BITS) as usize);
        finished.flags.get(row * self.blocks_across + column).is_some_and(|&is_finished| is_finished)
    }
}

impl FinishedBlocks {
    /// Appends their records.
    fn write(&self, layout: FragmentLayout, out: &mut Vec<u8>) {
        let mut first = 0;
        for run in self.flags.chunk_by(|a, b| a == b) {
            if run[0] {
                write_finished(layout, first, run.len(), out);
            }
            first += run.len();
        }
    }
}

/// Appends the record of a run of finished blocks.
pub fn write_finished(layout: FragmentLayout, first: usize, count: usize, out: &mut Vec<u8>) {
    let head = FragmentHead { primitive: count as u32, place: first as u16, mask: 0, color: [0.0; 4] };
    let end = out.len() + layout.bytes(0);
    out.extend_from_slice(bytes_of(&head));
    out.resize(end, 0);
}

/// Appends those of some fragments of a pixel that are seen, with the samples at which they are.
fn write_seen(layout: FragmentLayout, here: &[&[u8]], out: &mut Vec<u8>) {
    // The largest key of an opaque fragment at each sample.
    let mut nearest = [0; MAX_SAMPLES];
    for (fragment, _) in here.iter().filter_map(|bytes| TileFragment::read(layout, bytes)) {
        if fragment.is_opaque() {
            for (sample, depth) in fragment.samples() {
                nearest[sample] = wide_key(depth, fragment.primitive).max(nearest[sample]);
            }
        }
    }
    for &bytes in here {
        let Some((fragment, _)) = TileFragment::read(layout, bytes) else { continue };
        let least = u128::from(!fragment.is_opaque());
        let mut seen = 0;
        for (sample, depth) in fragment.samples() {
            let is_seen = wide_key(depth, fragment.primitive) >= nearest[sample].saturating_add(least);
            seen |= u16::from(is_seen) << sample;
        }
        if seen == fragment.head.mask {
            out.extend_from_slice(bytes);
        } else if seen != 0 {
            let head = FragmentHead { mask: seen, ..fragment.head };
            out.extend_from_slice(bytes_of(&head));
            out.extend_from_slice(&bytes[size_of::<FragmentHead>()..layout.bytes(0)]);
            for (_, depth) in fragment.samples().filter(|(sample, _)| seen >> sample & 1 == 1) {
                out.extend_from_slice(&depth.to_ne_bytes());
            }
        }
    }
}
