//! The rows of a picture as a stream of PNG: filtered and compressed, bands of rows in parallel.

use tercio_mesh::loops::prelude::*;

use super::deflate::{Block, Content, Counts, Written, checksum};

/// The rows of a band, which is a block with a code of its own. Bands do not depend on the number of threads.
const BAND: usize = 256;
/// One of so many rows is counted for the code of its band: no multiple of what repeats in pictures. More are where rows are short: one
/// of the number of [`PIXELS_COUNTED`] that a band has.
const COUNTED: usize = 13;
const PIXELS_COUNTED: usize = 1 << 15;
/// Pixels that are either the same as those above them, all of them, or written one by one. Shorter runs of zeros take few bits as bytes.
const CHUNK: usize = 16;
/// The filter of the first row: the difference from the pixel to the left.
const SUB: u8 = 1;
/// The filter of all others: the difference from the row above. Choosing one for each row takes longer than drawing the picture, and
/// saves little on surfaces.
const UP: u8 = 2;
/// Deflate, with a window of 32 KiB.
const HEADER: [u8; 2] = [0x78, 1];

/// How the pixels of a picture are written.
pub trait Layout {
    /// A pixel of the picture.
    type Pixel: Copy + PartialEq + Sync;
    /// Bytes of a pixel.
    const BYTES: usize;
    /// A pixel whose bytes are zeros.
    const ZERO: Self::Pixel;

    /// Writes the differences of the bytes of pixels from those of the pixels above them. False if this layout cannot hold the pixels.
    fn filter(pixels: &[Self::Pixel; CHUNK], above: &[Self::Pixel; CHUNK], to: &mut [u8]) -> bool;
}

/// Opaque pixels of 8 bits.
pub struct Rgb8;

impl Layout for Rgb8 {
    type Pixel = [u8; 4];
    const BYTES: usize = 3;
    const ZERO: [u8; 4] = [0, 0, 0, u8::MAX];

    #[inline(always)]
    fn filter(pixels: &[[u8; 4]; CHUNK], above: &[[u8; 4]; CHUNK], to: &mut [u8]) -> bool {
        let mut differences = [[0; 4]; CHUNK];
        let (all, above) = (pixels.as_flattened(), above.as_flattened());
        for ((to, a), b) in differences.as_flattened_mut().iter_mut().zip(all).zip(above) {
            *to = a.wrapping_sub(*b);
        }
        // Four pixels are three words.
        for (words, four) in to.as_chunks_mut::<12>().0.iter_mut().zip(differences.as_chunks::<4>().0) {
            let [a, b, c, d] = four.map(u32::from_le_bytes);
            let three = [a & 0xff_ffff | b << 24, b >> 8 & 0xffff | c << 16, c >> 16 & 0xff | d << 8];
            for (to, word) in words.as_chunks_mut::<4>().0.iter_mut().zip(three) {
                *to = word.to_le_bytes();
            }
        }
        pixels.iter().fold(u8::MAX, |all, pixel| all & pixel[3]) == u8::MAX
    }
}

/// Pixels of 8 bits with alpha.
pub struct Rgba8;

impl Layout for Rgba8 {
    type Pixel = [u8; 4];
    const BYTES: usize = 4;
    const ZERO: [u8; 4] = [0; 4];

    #[inline(always)]
    fn filter(pixels: &[[u8; 4]; CHUNK], above: &[[u8; 4]; CHUNK], to: &mut [u8]) -> bool {
        for ((to, a), b) in to.iter_mut().zip(pixels.as_flattened()).zip(above.as_flattened()) {
            *to = a.wrapping_sub(*b);
        }
        true
    }
}

/// The differences of the bytes of the first channels, the high byte of each first.
fn filter_16<const CHANNELS: usize>(pixels: &[[u16; 4]; CHUNK], above: &[[u16; 4]; CHUNK], to: &mut [u8]) {
    let pairs = pixels.iter().zip(above).flat_map(|(a, b)| a.iter().zip(b).take(CHANNELS));
    for (to, (a, b)) in to.as_chunks_mut::<2>().0.iter_mut().zip(pairs) {
        let ([a0, a1], [b0, b1]) = (a.to_be_bytes(), b.to_be_bytes());
        *to = [a0.wrapping_sub(b0), a1.wrapping_sub(b1)];
    }
}

/// Opaque pixels of 16 bits.
pub struct Rgb16;

impl Layout for Rgb16 {
    type Pixel = [u16; 4];
    const BYTES: usize = 6;
    const ZERO: [u16; 4] = [0, 0, 0, u16::MAX];

    fn filter(pixels: &[[u16; 4]; CHUNK], above: &[[u16; 4]; CHUNK], to: &mut [u8]) -> bool {
        filter_16::<3>(pixels, above, to);
        pixels.iter().all(|pixel| pixel[3] == u16::MAX)
    }
}

/// Pixels of 16 bits with alpha.
pub struct Rgba16;

impl Layout for Rgba16 {
    type Pixel = [u16; 4];
    const BYTES: usize = 8;
    const ZERO: [u16; 4] = [0; 4];

    fn filter(pixels: &[[u16; 4]; CHUNK], above: &[[u16; 4]; CHUNK], to: &mut [u8]) -> bool {
        filter_16::<4>(pixels, above, to);
        true
    }
}

/// The stream of a picture with rows of `width` pixels, in pieces; `None` if the layout cannot hold it.
pub fn compress<L: Layout>(pixels: &[L::Pixel], width: usize) -> Option<Vec<Vec<u8>>> {
    let band = BAND * width;
    let count = pixels.len().div_ceil(band);
    // What is to the left of the first row's pixels is above them, for the code.
    let left: Vec<_> = std::iter::once(L::ZERO).chain(pixels.iter().copied()).take(width).collect();
    let compress = |number: usize| {
        let begin = number * band;
        let own = &pixels[begin..pixels.len().min(begin + band)];
        let (first, above) = if number == 0 { (SUB, &*left) } else { (UP, &pixels[begin - width..begin]) };
        compress_band::<L>(own, first, above, number + 1 == count)
    };
    let written = (0..count).into_par_iter().map(compress).collect::<Option<Vec<_>>>()?;
    let checksum = checksum(&written).to_be_bytes();
    let mut pieces: Vec<_> = written.into_iter().map(|written| written.bytes).collect();
    if let Some(first) = pieces.first_mut() {
        first.splice(0..0, HEADER);
    }
    if let Some(last) = pieces.last_mut() {
        last.extend(checksum);
    }
    Some(pieces)
}

/// Compresses rows as long as `above`, which is above the first of them, whose filter is `first`.
fn compress_band<L: Layout>(
    pixels: &[L::Pixel],
    first: u8,
    above: &[L::Pixel],
    is_last: bool,
) -> Option<Written> {
    let width = above.len();
    let befores = std::iter::once((first, above)).chain(pixels.chunks_exact(width).map(|row| (UP, row)));
    let rows: Vec<_> = pixels.chunks_exact(width).zip(befores).collect();
    let mut counts = Counts::default();
    let mut bytes = vec![0; (width + CHUNK) * L::BYTES];
    let step = (pixels.len() / PIXELS_COUNTED).clamp(1, COUNTED);
    for &(row, (filter, above)) in rows.iter().rev().step_by(step) {
        bytes[0] = filter;
        add_row::<L>(row, above, &mut bytes, &mut counts);
    }
    let mut block = Block::new(&counts, is_last);
    for (row, (filter, above)) in rows {
        bytes[0] = filter;
        if !add_row::<L>(row, above, &mut bytes, &mut block) {
            return None;
        }
    }
    Some(block.finish(is_last))
}

/// Adds a row: the filter, which is the first of `bytes`, and the differences, for which there is room after it. False if the layout
/// cannot hold it.
fn add_row<L: Layout>(
    row: &[L::Pixel],
    above: &[L::Pixel],
    bytes: &mut [u8],
    content: &mut impl Content,
) -> bool {
    // The zeros that are not added yet, and the bytes after them; zeros at the ends of these are added as zeros, too.
    let (mut zeros, mut written) = (0, 1);
    let mut add = |chunk: &[L::Pixel; CHUNK], above: &[L::Pixel; CHUNK], length: usize| {
        // Without leaving at the first difference, so that this is vectorised.
        let is_same = chunk.iter().zip(above).fold(true, |all, (a, b)| all & (a == b));
        if is_same {
            if written > 0 {
                zeros = add_bytes(zeros, &bytes[..written], content);
                written = 0;
            }
            zeros += length;
            return true;
        }
        let is_held = L::filter(chunk, above, &mut bytes[written..][..CHUNK * L::BYTES]);
        written += length;
        is_held
    };
    let ((chunks, rest), (above, rest_above)) = (row.as_chunks(), above.as_chunks());
    for (chunk, above) in chunks.iter().zip(above) {
        if !add(chunk, above, CHUNK * L::BYTES) {
            return false;
        }
    }
    if !rest.is_empty() {
        let mut padded = [[L::ZERO; CHUNK]; 2];
        padded[0][..rest.len()].copy_from_slice(rest);
        padded[1][..rest.len()].copy_from_slice(rest_above);
        if !add(&padded[0], &padded[1], rest.len() * L::BYTES) {
            return false;
        }
    }
    let zeros = add_bytes(zeros, &bytes[..written], content);
    if zeros > 0 {
        content.zeros(zeros);
    }
    true
}

/// Adds zeros and the bytes after them, but for the zeros at the end of these, whose number is returned.
fn add_bytes(zeros: usize, bytes: &[u8], content: &mut impl Content) -> usize {
    let Some(last) = bytes.iter().rposition(|&byte| byte != 0) else { return zeros + bytes.len() };
    if zeros > 0 {
        let first = bytes.iter().position(|&byte| byte != 0).unwrap_or_default();
        content.zeros(zeros + first);
        content.bytes(&bytes[first..=last]);
    } else {
        content.bytes(&bytes[..=last]);
    }
    bytes.len() - last - 1
}

#[cfg(test)]
mod tests {
    use std::io::Read;

    use super::*;

    /// What a decoder that shares no code with the encoder, and checks the checksum, finds in the stream.
    fn rows<L: Layout>(pixels: &[L::Pixel], width: usize) -> Option<Vec<u8>> {
        let stream = compress::<L>(pixels, width)?.concat();
        let mut filtered = Vec::new();
        let mut decoder = flate2::read::ZlibDecoder::new(&*stream);
        decoder.read_to_end(&mut filtered).unwrap();
        assert_eq!(decoder.total_in(), stream.len() as u64);
        let (row, mut all) = (width * L::BYTES, Vec::<u8>::new());
        assert_eq!(filtered.len(), pixels.len() / width * (row + 1));
        for filtered in filtered.chunks(row + 1) {
            let begin = all.len();
            for k in 0..row {
                let before = match filtered[0] {
                    SUB => {
                        if k < L::BYTES {
                            0
                        } else {
                            all[begin + k - L::BYTES]
                        }
                    }
                    UP => {
                        if begin == 0 {
                            0
                        } else {
                            all[begin + k - row]
                        }
                    }
                    other => panic!("filter {other}"),
                };
                all.push(before.wrapping_add(filtered[k + 1]));
            }
        }
        Some(all)
    }

    /// Noise, a colour, and rows that change in the middle.
    fn pictures(width: usize, height: usize) -> [Vec<[u16; 4]>; 3] {
        let mut state = 1_u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 16) as u16
        };
        let noise: Vec<[u16; 4]> = (0..width * height).map(|_| [next(), next(), next(), next()]).collect();
        let flat = vec![[0xffff, 0x8123, 0, 0xfffe]; width * height];
        let mut mixed = flat.clone();
        for (k, pixel) in mixed.iter_mut().enumerate() {
            if k % width > width / 3 && k % width < width * 3 / 4 && k / width % 40 != 7 {
                *pixel = noise[k].map(|v| v >> 13 << 8);
            }
        }
        [noise, flat, mixed]
    }

    #[test]
    fn streams_have_the_pixels() {
        for (width, height) in
            [(1, 1), (1, 600), (15, 255), (16, 256), (17, 257), (100, 513), (700, 9), (4000, 2)]
        {
            for wide in pictures(width, height) {
                let opaque: Vec<[u16; 4]> = wide.iter().map(|&[r, g, b, _]| [r, g, b, u16::MAX]).collect();
                let eight = |pixels: &[[u16; 4]]| {
                    pixels.iter().map(|p| p.map(|v| (v >> 8) as u8)).collect::<Vec<_>>()
                };
                let bytes = |pixels: &[[u16; 4]], channels: usize| -> Vec<u8> {
                    pixels.iter().flat_map(|p| p[..channels].to_vec()).flat_map(u16::to_be_bytes).collect()
                };
                let high = |bytes: Vec<u8>| -> Vec<u8> { bytes.into_iter().step_by(2).collect() };
                assert!(rows::<Rgb8>(&eight(&opaque), width) == Some(high(bytes(&opaque, 3))));
                assert!(rows::<Rgba8>(&eight(&wide), width) == Some(high(bytes(&wide, 4))));
                assert!(rows::<Rgb16>(&opaque, width) == Some(bytes(&opaque, 3)));
                assert!(rows::<Rgba16>(&wide, width) == Some(bytes(&wide, 4)));
                for place in [0, wide.len() / 2, wide.len() - 1] {
                    let mut one = opaque.clone();
                    one[place][3] = 0x7fff;
                    assert!(compress::<Rgb16>(&one, width).is_none());
                    assert!(compress::<Rgb8>(&eight(&one), width).is_none());
                }
            }
        }
    }

    /// Bands are as long as runs of zeros can be, and a surface on a background takes no more than from the encoder of a library.
    #[test]
    fn streams_are_short() {
        let (width, height) = (1200, 700);
        let shade = |k: usize| {
            let [x, y] = [k % width, k / width].map(|v| v as f32 / 350.0);
            let (x, y) = (x - 1.7, y - 1.0);
            match x * x + y * y {
                d if d < 0.9 => {
                    let light =
                        ((1.0 - d).sqrt() * 0.7 + x * 0.2 + (x * 90.0).sin() * (y * 70.0).cos() * 0.1)
                            * 200.0;
                    [light, light * 0.9, light * 0.8].map(|v| v.clamp(0.0, 255.0) as u8)
                }
                _ => [240, 245, 250],
            }
        };
        let colors: Vec<[u8; 3]> = (0..width * height).map(shade).collect();
        let pixels: Vec<[u8; 4]> = colors.iter().map(|&[r, g, b]| [r, g, b, 255]).collect();
        let own = compress::<Rgb8>(&pixels, width).unwrap().concat().len();
        let mut file = Vec::new();
        let mut encoder = ::png::Encoder::new(&mut file, width as u32, height as u32);
        encoder.set_color(::png::ColorType::Rgb);
        encoder.set_compression(::png::Compression::Fast);
        encoder.set_filter(::png::Filter::Up);
        encoder.write_header().unwrap().write_image_data(colors.as_flattened()).unwrap();
        assert!(own < file.len(), "{own} bytes, not fewer than {}", file.len());
        let flat = compress::<Rgb8>(&vec![[240, 245, 250, 255]; width * height], width).unwrap().concat();
        assert!(flat.len() < 700 * 8, "{}", flat.len());
    }
}
