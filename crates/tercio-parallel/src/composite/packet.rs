//! Pixels, packed into bytes.
//!
//! A packet is a sequence of spans, whose number follows from its length. A span is a run of pixels in a row of one tile: a
//! maximal one of those that show something, or, if all pixels are sent, the whole row. It has the row-major index of the first
//! pixel in the picture (4 bytes); the number of pixels (2 bytes); then plane after plane their samples: keys, ties, 8-bit colour,
//! 16-bit colour, depth, linear colour, ids, normals, each if it is sent. Numbers have the byte order of the machine.

use std::slice::ChunksExact;

use bytemuck::pod_read_unaligned;
use tercio_raster::frame::Pixel;
use tercio_raster::screen::PixelRect;
use tercio_raster::{Frame, Outputs};

/// Bytes before the samples of a span.
pub const SPAN_HEAD: usize = 6;

/// Bytes of a key and of a tie, the first samples of a span that has keys and ties.
const KEY: usize = size_of::<u64>();
const TIE: usize = size_of::<u32>();

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
    /// The spans of a tile are not in the order of their pixels.
    #[error("a span begins at pixel {place}, before the end of the one before it")]
    Order {
        /// Index of its first pixel.
        place: usize,
    },
    /// A tile that is not sent to the receiver.
    #[error("tile {tile}, which nobody sends to this rank now")]
    Tile {
        /// The tile.
        tile: u32,
    },
}

/// Appends the pixels of a tile that have a key, and returns their number. The frame has keys and the planes that are sent.
pub fn pack_drawn(frame: &Frame, tile: PixelRect, planes: &Outputs, out: &mut Vec<u8>) -> u64 {
    let mut pixels = 0;
    for (mut at, end) in rows(frame, tile) {
        while let Some(skipped) = first_drawn(&frame.planes.keys[at..end]) {
            let first = at + skipped;
            let keys = &frame.planes.keys[first..end];
            let count = keys.iter().position(|&key| key == 0).unwrap_or(keys.len());
            at = first + count;
            put_span(frame, first, count, planes, out);
            pixels += count as u64;
        }
    }
    pixels
}

/// Appends all pixels of a tile, one span a row. The frame has keys, which are 0 where nothing is drawn, and the planes that are
/// sent.
pub fn pack_all(frame: &Frame, tile: PixelRect, planes: &Outputs, out: &mut Vec<u8>) {
    for (first, end) in rows(frame, tile) {
        put_span(frame, first, end - first, planes, out);
    }
}

/// Appends the pixels of a tile that differ from the background in any of the planes that are sent. `background` has the pixel
/// of each row of the picture.
pub fn pack_shown(frame: &Frame, tile: PixelRect, background: &[Pixel], planes: &Outputs, out: &mut Vec<u8>) {
    let mut differs = vec![false; (tile.x1 - tile.x0 + 1) as usize];
    for ((first, end), pixel) in rows(frame, tile).zip(&background[tile.y0 as usize..]) {
        frame.planes.differ_from(planes, first..end, pixel, &mut differs);
        let mut at = 0;
        while let Some(skipped) = differs[at..].iter().position(|&differs| differs) {
            let from = at + skipped;
            let count = differs[from..].iter().position(|&differs| !differs).unwrap_or(differs.len() - from);
            put_span(frame, first + from, count, planes, out);
            at = from + count;
        }
    }
}

/// Indices of the first pixel of each row of a tile, and the one behind the last.
fn rows(frame: &Frame, tile: PixelRect) -> impl Iterator<Item = (usize, usize)> + use<> {
    let width = frame.width as usize;
    (tile.y0..tile.y1 + 1).map(move |y| {
        let row = y as usize * width;
        (row + tile.x0 as usize, row + tile.x1 as usize + 1)
    })
}

/// Index of the first key of a drawn pixel. Many keys are skipped at a time.
fn first_drawn(keys: &[u64]) -> Option<usize> {
    const AT_ONCE: usize = 16;
    let nothing = |keys: &&[u64]| keys.iter().fold(0, |any, key| any | key) == 0;
    let skipped = keys.chunks_exact(AT_ONCE).take_while(nothing).count() * AT_ONCE;
    keys[skipped..].iter().position(|&key| key != 0).map(|k| skipped + k)
}

/// Precondition: `count` is at most 65,535; tiles are narrower.
fn put_head(first: usize, count: usize, out: &mut Vec<u8>) {
    out.extend((first as u32).to_ne_bytes());
    out.extend((count as u16).to_ne_bytes());
}

fn put_span(frame: &Frame, first: usize, count: usize, planes: &Outputs, out: &mut Vec<u8>) {
    out.reserve(SPAN_HEAD + count * planes.pixel_bytes());
    put_head(first, count, out);
    frame.planes.write_bytes(planes, first..first + count, out);
}

/// A span of a packet.
#[derive(Clone, Copy, Debug)]
struct Span<'a> {
    /// Index of its first pixel.
    first: usize,
    count: usize,
    /// Its samples.
    samples: &'a [u8],
}

impl<'a> Span<'a> {
    /// The keys of some of its pixels, from this one on, as bytes.
    fn keys(&self, from: usize, count: usize) -> ChunksExact<'a, u8> {
        self.samples[from * KEY..(from + count) * KEY].chunks_exact(KEY)
    }

    /// The ties of some of its pixels, of a packet that has ties.
    fn ties(&self, from: usize, count: usize) -> ChunksExact<'a, u8> {
        let ties = &self.samples[self.count * KEY..];
        ties[from * TIE..(from + count) * TIE].chunks_exact(TIE)
    }
}

/// The spans of a packet of a picture with so many pixels, up to the first that is not valid.
fn spans<'a>(
    bytes: &'a [u8],
    planes: &Outputs,
    pixels: usize,
) -> impl Iterator<Item = Result<Span<'a>, PacketError>> + use<'a> {
    let bytes_of_pixel = planes.pixel_bytes();
    let mut at = 0;
    std::iter::from_fn(move || {
        if at >= bytes.len() {
            return None;
        }
        let begin = std::mem::replace(&mut at, bytes.len());
        let Some(head) = bytes.get(begin..begin + SPAN_HEAD) else {
            return Some(Err(PacketError::Short { at: begin }));
        };
        let (place, count): (u32, u16) = (pod_read_unaligned(&head[..4]), pod_read_unaligned(&head[4..]));
        let (first, length) = (place as usize, usize::from(count));
        if length == 0 || first >= pixels || length > pixels - first {
            return Some(Err(PacketError::Span { at: begin, place, count }));
        }
        let body = begin + SPAN_HEAD;
        let Some(samples) = bytes.get(body..body + length * bytes_of_pixel) else {
            return Some(Err(PacketError::Short { at: begin }));
        };
        at = body + samples.len();
        Some(Ok(Span { first, count: length, samples }))
    })
}

/// The spans of a packet of one tile.
fn spans_in_order<'a>(bytes: &'a [u8], planes: &Outputs) -> Result<Vec<Span<'a>>, PacketError> {
    let spans = spans(bytes, planes, usize::MAX).collect::<Result<Vec<Span>, _>>()?;
    match spans.windows(2).find(|pair| pair[1].first < pair[0].first + pair[0].count) {
        Some(pair) => Err(PacketError::Order { place: pair[1].first }),
        None => Ok(spans),
    }
}

/// Number of pixels of a packet.
///
/// # Errors
/// [`PacketError`].
pub fn count_pixels(bytes: &[u8], planes: &Outputs) -> Result<u64, PacketError> {
    spans(bytes, planes, usize::MAX).map(|span| span.map(|span| span.count as u64)).sum()
}

/// Appends a packet that has keys without these, and without its ties, each unless `wanted` has it. Returns its number of pixels.
///
/// # Errors
/// [`PacketError`]; the spans before the error are appended.
pub fn without_keys(
    bytes: &[u8],
    planes: &Outputs,
    wanted: &Outputs,
    out: &mut Vec<u8>,
) -> Result<u64, PacketError> {
    let ties = if planes.ties { TIE } else { 0 };
    let mut pixels = 0;
    for span in spans(bytes, planes, usize::MAX) {
        let Span { first, count, samples } = span?;
        put_head(first, count, out);
        let (keys, rest) = samples.split_at(count * KEY);
        let (ties, rest) = rest.split_at(count * ties);
        for part in
            [wanted.keys.then_some(keys), wanted.ties.then_some(ties), Some(rest)].into_iter().flatten()
        {
            out.extend_from_slice(part);
        }
        pixels += count as u64;
    }
    Ok(pixels)
}

/// A packet without the pixels in which nothing is drawn, whose keys are 0: what [`pack_drawn`] gives.
///
/// # Errors
/// [`PacketError`].
pub fn only_drawn(bytes: &[u8], planes: &Outputs) -> Result<Vec<u8>, PacketError> {
    let mut out = Vec::new();
    for span in spans(bytes, planes, usize::MAX) {
        let Span { first, count, samples } = span?;
        let keys: Vec<u64> = samples[..count * KEY].chunks_exact(KEY).map(pod_read_unaligned).collect();
        let mut at = 0;
        for run in keys.chunk_by(|a, b| (*a == 0) == (*b == 0)) {
            let begin = at;
            at += run.len();
            if run[0] == 0 {
                continue;
            }
            put_head(first + begin, run.len(), &mut out);
            let mut plane = 0;
            for bytes in planes.plane_bytes() {
                let of_run = plane + begin * bytes..plane + at * bytes;
                out.extend_from_slice(&samples[of_run]);
                plane += count * bytes;
            }
        }
    }
    Ok(out)
}

/// Writes the pixels of a packet into a frame that has the planes that are sent.
///
/// # Errors
/// [`PacketError`]; the spans before the error are written.
pub fn unpack(bytes: &[u8], planes: &Outputs, frame: &mut Frame) -> Result<(), PacketError> {
    let pixels = frame.width as usize * frame.height as usize;
    for span in spans(bytes, planes, pixels) {
        let Span { first, count, samples } = span?;
        frame.planes.read_bytes(planes, samples, first..first + count);
    }
    Ok(())
}

/// Counts of pixels that were merged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Merged {
    /// Pixels of the second packet.
    pub pixels: u64,
    /// Those of them that are visible.
    pub won: u64,
}

/// Where the pixels of a piece of a merged span come from.
#[derive(Clone, Copy)]
enum Source {
    /// A span of one packet, from this pixel of it on.
    One { span: usize, from: usize, is_second: bool },
    /// Spans of both, each from a pixel on, and the first of the flags that say whether the second wins.
    Both { spans: [usize; 2], from: [usize; 2], flags: usize },
}

/// Merges two packets of a tile, which have keys, of a picture of this width, into what packing their composite would give:
/// where both have a pixel, the one with the larger key is kept, of equal ones that with the larger tie if there are ties.
///
/// # Errors
/// [`PacketError`], of the first packet if its spans are not valid, else of the second one.
pub fn merge(
    first: &[u8],
    second: &[u8],
    planes: &Outputs,
    width: u32,
) -> Result<(Vec<u8>, Merged), PacketError> {
    let packets = [spans_in_order(first, planes)?, spans_in_order(second, planes)?];
    let mut out = Vec::with_capacity(first.len().max(second.len()));
    let mut merged =
        Merged { pixels: packets[1].iter().map(|span| span.count as u64).sum(), ..Merged::default() };
    // In each packet the next span, and the next pixel of it.
    let mut next = [(0, 0); 2];
    // The run of neighbouring pixels that is being put together.
    let (mut run, mut pieces, mut second_wins) = (0..0, Vec::<(Source, usize)>::new(), Vec::<bool>::new());
    let mut put = |run: &std::ops::Range<usize>, pieces: &mut Vec<(Source, usize)>, wins: &mut Vec<bool>| {
        if !run.is_empty() {
            put_head(run.start, run.len(), &mut out);
            put_pieces(&packets, planes, pieces, wins, &mut out);
        }
        pieces.clear();
        wins.clear();
    };
    loop {
        // The pixels of each packet that come next.
        let rest = [0, 1].map(|k| match packets[k].get(next[k].0) {
            Some(span) => span.first + next[k].1..span.first + span.count,
            None => usize::MAX..usize::MAX,
        });
        let start = rest[0].start.min(rest[1].start);
        if start == usize::MAX {
            break;
        }
        let is_next = [rest[0].start == start, rest[1].start == start];
        let behind = |k: usize| if is_next[k] { rest[k].end } else { rest[k].start };
        let end = behind(0).min(behind(1));
        // Runs end with a row, and are no longer than a 16-bit number.
        let is_longer = run.len() + (end - start) > usize::from(u16::MAX);
        if start != run.end || start.is_multiple_of(width.max(1) as usize) || is_longer {
            put(&run, &mut pieces, &mut second_wins);
            run = start..start;
        }
        let source = match is_next {
            [true, true] => {
                let spans = [0, 1].map(|k| (&packets[k][next[k].0], next[k].1));
                let flags = second_wins.len();
                if planes.ties {
                    let [own, theirs] = spans.map(|(span, from)| {
                        let ties = span.ties(from, end - start).map(pod_read_unaligned::<u32>);
                        span.keys(from, end - start).map(pod_read_unaligned::<u64>).zip(ties)
                    });
                    second_wins.extend(own.zip(theirs).map(|(own, theirs)| theirs > own));
                } else {
                    let [own, theirs] =
                        spans.map(|(span, from)| span.keys(from, end - start).map(pod_read_unaligned::<u64>));
                    second_wins.extend(own.zip(theirs).map(|(own, theirs)| theirs > own));
                }
                merged.won += second_wins[flags..].iter().map(|&wins| u64::from(wins)).sum::<u64>();
                Source::Both { spans: [next[0].0, next[1].0], from: [next[0].1, next[1].1], flags }
            }
            [is_first, _] => {
                let (span, from) = next[usize::from(!is_first)];
                merged.won += if is_first { 0 } else { (end - start) as u64 };
                Source::One { span, from, is_second: !is_first }
            }
        };
        pieces.push((source, end - start));
        run.end = end;
        for k in (0..2).filter(|&k| is_next[k]) {
            next[k].1 += end - start;
            if next[k].1 == packets[k][next[k].0].count {
                next[k] = (next[k].0 + 1, 0);
            }
        }
    }
    put(&run, &mut pieces, &mut second_wins);
    Ok((out, merged))
}

/// Appends the samples of a merged span, plane by plane.
fn put_pieces(
    packets: &[Vec<Span>; 2],
    planes: &Outputs,
    pieces: &[(Source, usize)],
    second_wins: &[bool],
    out: &mut Vec<u8>,
) {
    // Bytes per pixel of the planes before this one.
    let mut before = 0;
    for bytes in planes.plane_bytes() {
        let samples = |packet: usize, span: usize, from: usize, count: usize| {
            let Span { count: of_span, samples, .. } = packets[packet][span];
            let first = before * of_span + from * bytes;
            &samples[first..first + count * bytes]
        };
        for &(source, count) in pieces {
            match source {
                Source::One { span, from, is_second } => {
                    out.extend_from_slice(samples(usize::from(is_second), span, from, count));
                }
                Source::Both { spans, from, flags } => {
                    let [own, theirs] =
                        [0, 1].map(|k| samples(k, spans[k], from[k], count).chunks_exact(bytes));
                    for ((own, theirs), &second) in own.zip(theirs).zip(&second_wins[flags..]) {
                        out.extend_from_slice(if second { theirs } else { own });
                    }
                }
            }
        }
        before += bytes;
    }
}

#[cfg(test)]
mod tests;
