//! Pixels that show something, packed into bytes.
//!
//! A packet is a sequence of spans, whose number follows from its length. A span is a longest row of neighbouring pixels
//! that show something, inside one region: the first pixel's place in the picture, row by row (4 bytes); how many
//! pixels (2 bytes); then plane after plane their samples: keys, 8-bit colour, 16-bit colour, depth, ids, normals, each
//! if it travels. All little-endian.

use tercio_raster::{Frame, Outputs};

use crate::regions::Region;

/// Bytes before the samples of a span.
pub const SPAN_HEAD: usize = 6;

/// Why bytes are no packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PacketError {
    /// The bytes end inside a span.
    #[error("byte {at}: the packet ends inside a span")]
    Short {
        /// Where the span begins.
        at: usize,
    },
    /// A span has no pixel or leaves the picture.
    #[error("byte {at}: {count} pixels from place {place} on are no span of the picture")]
    Span {
        /// Where the span begins.
        at: usize,
        /// Its first pixel.
        place: u32,
        /// Its pixels.
        count: u16,
    },
}

/// A value of a plane as bytes.
trait Sample: Copy {
    const BYTES: usize;
    fn put(self, out: &mut Vec<u8>);
    /// From exactly [`Sample::BYTES`] bytes.
    fn get(bytes: &[u8]) -> Self;
}

macro_rules! number {
    ($($t:ty),*) => {$(
        impl Sample for $t {
            const BYTES: usize = size_of::<$t>();
            #[inline(always)]
            fn put(self, out: &mut Vec<u8>) {
                out.extend_from_slice(&self.to_le_bytes());
            }
            #[inline(always)]
            fn get(bytes: &[u8]) -> Self {
                let mut own = [0; size_of::<$t>()];
                own.copy_from_slice(bytes);
                Self::from_le_bytes(own)
            }
        }
    )*};
}
number!(u8, u16, u32, u64, f32);

impl<T: Sample + Default, const N: usize> Sample for [T; N] {
    const BYTES: usize = N * T::BYTES;
    #[inline(always)]
    fn put(self, out: &mut Vec<u8>) {
        self.into_iter().for_each(|v| v.put(out));
    }
    #[inline(always)]
    fn get(bytes: &[u8]) -> Self {
        let mut own = [T::default(); N];
        own.iter_mut().zip(bytes.chunks_exact(T::BYTES)).for_each(|(v, b)| *v = T::get(b));
        own
    }
}

/// Bytes of a pixel on its way.
pub fn pixel_bytes(planes: &Outputs) -> usize {
    let Outputs { color, color16, depth, ids, normals, keys } = *planes;
    let bytes = [(keys, 8), (color, 4), (color16, 8), (depth, 4), (ids, 4), (normals, 12)];
    bytes.into_iter().filter(|b| b.0).map(|b| b.1).sum()
}

/// Appends the pixels of a region that show something, and returns how many they are. The frame has keys; it has the
/// planes that travel.
pub fn pack(frame: &Frame, region: &Region, planes: &Outputs, out: &mut Vec<u8>) -> u64 {
    let mut pixels = 0;
    for y in region.y.clone() {
        let row = y as usize * frame.width as usize;
        let (mut at, end) = (row + region.x.start as usize, row + region.x.end as usize);
        while let Some(skipped) = first_shown(&frame.keys[at..end]) {
            let first = at + skipped;
            // A span's length is a 16-bit number; regions are narrower than that.
            let most = (end - first).min(usize::from(u16::MAX));
            let count = frame.keys[first..first + most].iter().position(|&key| key == 0).unwrap_or(most);
            at = first + count;
            put_span(frame, first, count, planes, out);
            pixels += count as u64;
        }
    }
    pixels
}

/// The first key that shows something. Most of a picture that a rank has drawn alone shows nothing, so that is skipped
/// many keys at a time.
fn first_shown(keys: &[u64]) -> Option<usize> {
    const AT_ONCE: usize = 16;
    let nothing = |keys: &&[u64]| keys.iter().fold(0, |any, key| any | key) == 0;
    let skipped = keys.chunks_exact(AT_ONCE).take_while(nothing).count() * AT_ONCE;
    keys[skipped..].iter().position(|&key| key != 0).map(|k| skipped + k)
}

fn put_span(frame: &Frame, first: usize, count: usize, planes: &Outputs, out: &mut Vec<u8>) {
    fn put<T: Sample>(plane: &[T], travels: bool, first: usize, count: usize, out: &mut Vec<u8>) {
        if travels {
            plane[first..first + count].iter().for_each(|s| s.put(out));
        }
    }
    out.reserve(SPAN_HEAD + count * pixel_bytes(planes));
    (first as u32).put(out);
    (count as u16).put(out);
    put(&frame.keys, planes.keys, first, count, out);
    put(&frame.color, planes.color, first, count, out);
    put(&frame.color16, planes.color16, first, count, out);
    put(&frame.depth, planes.depth, first, count, out);
    put(&frame.ids, planes.ids, first, count, out);
    put(&frame.normals, planes.normals, first, count, out);
}

/// What became of the pixels of a packet.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Unpacked {
    /// All.
    pub pixels: u64,
    /// Those that were written.
    pub written: u64,
}

/// Writes the pixels of a packet into a frame that has the planes that travel. With `composed`, only those whose key is
/// larger than the frame's; the keys must travel then.
///
/// # Errors
/// [`PacketError`]; the spans before it are written.
pub fn unpack(
    bytes: &[u8],
    planes: &Outputs,
    composed: bool,
    frame: &mut Frame,
) -> Result<Unpacked, PacketError> {
    let pixels = frame.width as usize * frame.height as usize;
    let bytes_a_pixel = pixel_bytes(planes);
    let (mut at, mut done) = (0, Unpacked::default());
    let mut wins: Vec<bool> = Vec::new();
    while at < bytes.len() {
        let head = bytes.get(at..at + SPAN_HEAD).ok_or(PacketError::Short { at })?;
        let (place, count) = (u32::get(&head[..4]), u16::get(&head[4..]));
        let (first, length) = (place as usize, usize::from(count));
        if length == 0 || first >= pixels || length > pixels - first {
            return Err(PacketError::Span { at, place, count });
        }
        let body = at + SPAN_HEAD;
        let end = body + length * bytes_a_pixel;
        let samples = bytes.get(body..end).ok_or(PacketError::Short { at })?;
        wins.clear();
        if composed {
            let own = &frame.keys[first..first + length];
            wins.extend(own.iter().zip(samples.chunks_exact(u64::BYTES)).map(|(&k, b)| u64::get(b) > k));
        } else {
            wins.resize(length, true);
        }
        done.pixels += length as u64;
        done.written += wins.iter().map(|&w| u64::from(w)).sum::<u64>();
        take_span(samples, planes, &wins, first, frame);
        at = end;
    }
    Ok(done)
}

fn take_span(mut samples: &[u8], planes: &Outputs, wins: &[bool], first: usize, frame: &mut Frame) {
    fn take<T: Sample>(plane: &mut [T], travels: bool, wins: &[bool], first: usize, samples: &mut &[u8]) {
        if travels {
            let (own, rest) = samples.split_at(wins.len() * T::BYTES);
            *samples = rest;
            let plane = plane[first..first + wins.len()].iter_mut();
            for ((place, bytes), &wins) in plane.zip(own.chunks_exact(T::BYTES)).zip(wins) {
                if wins {
                    *place = T::get(bytes);
                }
            }
        }
    }
    take(&mut frame.keys, planes.keys, wins, first, &mut samples);
    take(&mut frame.color, planes.color, wins, first, &mut samples);
    take(&mut frame.color16, planes.color16, wins, first, &mut samples);
    take(&mut frame.depth, planes.depth, wins, first, &mut samples);
    take(&mut frame.ids, planes.ids, wins, first, &mut samples);
    take(&mut frame.normals, planes.normals, wins, first, &mut samples);
}

#[cfg(test)]
mod tests;
