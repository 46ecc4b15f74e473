//! Drawn pixels, packed into bytes.
//!
//! A packet is a sequence of spans, whose number follows from its length. A span is a maximal run of drawn pixels in
//! a row of one region: the row-major index of the first pixel in the picture (4 bytes); the number of pixels (2
//! bytes); then plane after plane their samples: keys, 8-bit colour, 16-bit colour, depth, linear colour, ids, normals,
//! each if it is sent. Numbers have the byte order of the machine.

use bytemuck::pod_read_unaligned;
use tercio_raster::{Frame, Outputs};

use crate::regions::Region;

/// Bytes before the samples of a span.
pub const SPAN_HEAD: usize = 6;

/// Why bytes are not a packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PacketError {
    /// The bytes end inside a span or tile.
    #[error("byte {at}: the message ends inside a span or tile")]
    Short {
        /// Its offset.
        at: usize,
    },
    /// A span has no pixel or leaves the picture.
    #[error("byte {at}: {count} pixels from pixel {place} on are not a span inside the picture")]
    Span {
        /// Offset of the span.
        at: usize,
        /// Index of its first pixel.
        place: u32,
        /// Its number of pixels.
        count: u16,
    },
    /// Fragments of a tile that the receiver does not own.
    #[error("fragments of tile {tile}, which another rank owns, or which is of another round")]
    Tile {
        /// The tile.
        tile: u32,
    },
}

/// Appends the drawn pixels of a region, and returns their number. The frame has keys and the planes that are sent.
pub fn pack(frame: &Frame, region: &Region, planes: &Outputs, out: &mut Vec<u8>) -> u64 {
    let mut pixels = 0;
    for y in region.y.clone() {
        let row = y as usize * frame.width as usize;
        let (mut at, end) = (row + region.x.start as usize, row + region.x.end as usize);
        while let Some(skipped) = first_shown(&frame.planes.keys[at..end]) {
            let first = at + skipped;
            // A span's length is a 16-bit number; regions are narrower than that.
            let most = (end - first).min(usize::from(u16::MAX));
            let count =
                frame.planes.keys[first..first + most].iter().position(|&key| key == 0).unwrap_or(most);
            at = first + count;
            put_span(frame, first, count, planes, out);
            pixels += count as u64;
        }
    }
    pixels
}

/// Index of the first key of a drawn pixel. Most of a picture that a rank has drawn alone is empty, so many keys are
/// skipped at a time.
fn first_shown(keys: &[u64]) -> Option<usize> {
    const AT_ONCE: usize = 16;
    let nothing = |keys: &&[u64]| keys.iter().fold(0, |any, key| any | key) == 0;
    let skipped = keys.chunks_exact(AT_ONCE).take_while(nothing).count() * AT_ONCE;
    keys[skipped..].iter().position(|&key| key != 0).map(|k| skipped + k)
}

fn put_span(frame: &Frame, first: usize, count: usize, planes: &Outputs, out: &mut Vec<u8>) {
    out.reserve(SPAN_HEAD + count * planes.pixel_bytes());
    out.extend((first as u32).to_ne_bytes());
    out.extend((count as u16).to_ne_bytes());
    frame.planes.write_bytes(planes, first..first + count, out);
}

/// Counts of the pixels of a packet.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Unpacked {
    /// All pixels.
    pub pixels: u64,
    /// Pixels that were written.
    pub written: u64,
}

/// Writes the pixels of a packet into a frame that has the planes that are sent. With `composed`, only those whose
/// key is larger than the frame's; then the keys must be among the planes.
///
/// # Errors
/// [`PacketError`]; the spans before the error are written.
pub fn unpack(
    bytes: &[u8],
    planes: &Outputs,
    composed: bool,
    frame: &mut Frame,
) -> Result<Unpacked, PacketError> {
    let pixels = frame.width as usize * frame.height as usize;
    let bytes_a_pixel = planes.pixel_bytes();
    let (mut at, mut done) = (0, Unpacked::default());
    let mut wins: Vec<bool> = Vec::new();
    while at < bytes.len() {
        let head = bytes.get(at..at + SPAN_HEAD).ok_or(PacketError::Short { at })?;
        let (place, count) = (pod_read_unaligned(&head[..4]), pod_read_unaligned(&head[4..]));
        let (first, length) = (place as usize, usize::from(count));
        if length == 0 || first >= pixels || length > pixels - first {
            return Err(PacketError::Span { at, place, count });
        }
        let body = at + SPAN_HEAD;
        let end = body + length * bytes_a_pixel;
        let samples = bytes.get(body..end).ok_or(PacketError::Short { at })?;
        wins.clear();
        if composed {
            let own = &frame.planes.keys[first..first + length];
            let keys = samples.chunks_exact(size_of::<u64>()).map(pod_read_unaligned::<u64>);
            wins.extend(own.iter().zip(keys).map(|(&own, key)| key > own));
        } else {
            wins.resize(length, true);
        }
        done.pixels += length as u64;
        done.written += wins.iter().map(|&w| u64::from(w)).sum::<u64>();
        frame.planes.read_bytes(planes, samples, &wins, first);
        at = end;
    }
    Ok(done)
}

#[cfg(test)]
mod tests;
