//! PNG: chunks and reading through the `png` crate, the pixels of pictures in memory with an encoder of our own, which needs one pass
//! over them and skips what is the same as the row above.

mod deflate;
mod huffman;
mod rows;

use std::borrow::Cow;
use std::io::{self, Write};

use png::{BitDepth, ColorType, Compression, Decoder, Encoder, Filter, Limits, Transformations, Writer};
use tercio_mesh::loops::prelude::*;

use self::rows::{Rgb8, Rgb16, Rgba8, Rgba16, compress};
use super::source::in_memory;
use super::{ImageError, Picture, PictureFormat, Pixels};
use crate::bands::MAX_PIXELS_IN_MEMORY;

/// The largest picture to be read: 32768 x 32768 pixels of 8 bytes. Larger ones can be drawn, in bands.
const READ_LIMIT: usize = (1 << 30) * 8 + (1 << 20);

fn malformed(reason: impl ToString) -> ImageError {
    ImageError::Malformed { format: PictureFormat::Png, reason: reason.to_string() }
}

pub(super) fn write(picture: &Picture, out: &mut dyn Write) -> Result<(), ImageError> {
    let size = [picture.width, picture.height];
    let is_16 = matches!(picture.pixels, Pixels::Sixteen(_));
    if u64::from(size[0]) * u64::from(size[1]) > MAX_PIXELS_IN_MEMORY {
        // The same bytes as from a picture that is drawn in bands.
        return write_parts(out, size, picture.is_opaque(), is_16, |write| {
            parts(picture).try_for_each(|part| write(&part))
        });
    }
    let width = picture.width as usize;
    let expected = Picture::pixel_count(picture.width, picture.height);
    if expected.is_none_or(|expected| expected == 0 || expected != picture.pixels.len()) {
        let [width, height] = size;
        let reason = format!("{width}x{height} pixels expected, {} found", picture.pixels.len());
        return Err(ImageError::Io(io::Error::new(io::ErrorKind::InvalidInput, reason)));
    }
    let opaque = match &picture.pixels {
        Pixels::Eight(p) => compress::<Rgb8>(p, width),
        Pixels::Sixteen(p) => compress::<Rgb16>(p, width),
    };
    let is_opaque = opaque.is_some();
    let translucent = || match &picture.pixels {
        Pixels::Eight(p) => compress::<Rgba8>(p, width),
        Pixels::Sixteen(p) => compress::<Rgba16>(p, width),
    };
    let mut writer = header(out, size, is_opaque, is_16)?;
    for piece in opaque.or_else(translucent).unwrap_or_default() {
        writer.write_chunk(png::chunk::IDAT, &piece).map_err(write_error)?;
    }
    writer.finish().map_err(write_error)
}

/// A picture in parts below each other, so that not all of it is copied at a time.
fn parts<'a>(picture: &'a Picture) -> impl Iterator<Item = Picture<'a>> {
    const ROWS: usize = 128;
    let (width, height) = (picture.width as usize, picture.height as usize);
    (0..height).step_by(ROWS).map(move |first| {
        let rows = ROWS.min(height - first);
        let range = first * width..(first + rows) * width;
        let pixels = match &picture.pixels {
            Pixels::Eight(p) => Pixels::Eight(Cow::Borrowed(&p[range])),
            Pixels::Sixteen(p) => Pixels::Sixteen(Cow::Borrowed(&p[range])),
        };
        Picture { width: picture.width, height: rows as u32, pixels }
    })
}

/// Writes everything before the pixels.
fn header(
    out: &mut dyn Write,
    [width, height]: [u32; 2],
    opaque: bool,
    is_16: bool,
) -> Result<Writer<&mut dyn Write>, ImageError> {
    let mut encoder = Encoder::new(out, width, height);
    encoder.set_color(if opaque { ColorType::Rgb } else { ColorType::Rgba });
    encoder.set_depth(if is_16 { BitDepth::Sixteen } else { BitDepth::Eight });
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    encoder.set_compression(Compression::Fast);
    // Choosing a filter for each row takes longer than drawing the picture, and saves little on surfaces.
    encoder.set_filter(Filter::Up);
    encoder.write_header().map_err(write_error)
}

/// Writes a picture of this width and height in parts below each other, without alpha if it is `opaque`, with 16 bits if
/// `is_16`. `draw` passes the parts, of the width and the depth of the picture, to its argument.
pub(crate) fn write_parts<E: From<ImageError>>(
    out: &mut dyn Write,
    size: [u32; 2],
    opaque: bool,
    is_16: bool,
    draw: impl FnOnce(&mut dyn FnMut(&Picture) -> Result<(), ImageError>) -> Result<(), E>,
) -> Result<(), E> {
    const CHUNK: usize = 1 << 20;
    let mut out = KeepsError { out, error: None };
    let write = || -> Result<(), E> {
        let mut writer = header(&mut out, size, opaque, is_16)?;
        let mut rows = writer.stream_writer_with_size(CHUNK).map_err(write_error)?;
        draw(&mut |part| Ok(rows.write_all(&samples(part, opaque))?))?;
        rows.finish().map_err(write_error)?;
        Ok(writer.finish().map_err(write_error)?)
    };
    let written = write();
    match out.error {
        Some(error) => Err(ImageError::Io(error).into()),
        None => written,
    }
}

/// Keeps the first error of a writer: the encoder of a stream changes the kind of errors, and ignores that of its last
/// chunk.
struct KeepsError<'a> {
    out: &'a mut dyn Write,
    error: Option<io::Error>,
}

impl KeepsError<'_> {
    fn keep<T>(&mut self, result: io::Result<T>) -> io::Result<T> {
        result.map_err(|error| {
            let copy = io::Error::new(error.kind(), error.to_string());
            self.error.get_or_insert(error);
            copy
        })
    }
}

impl Write for KeepsError<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.out.write(bytes);
        self.keep(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        let flushed = self.out.flush();
        self.keep(flushed)
    }
}

pub(super) fn write_error(error: png::EncodingError) -> ImageError {
    match error {
        png::EncodingError::IoError(e) => ImageError::Io(e),
        other => ImageError::Io(io::Error::other(other)),
    }
}

/// [`samples`] of a picture that is opaque, without alpha; `None` if it is not. Reads a picture of 8 bits only once.
pub(super) fn opaque_samples(picture: &Picture) -> Option<Vec<u8>> {
    match &picture.pixels {
        Pixels::Eight(p) => {
            let (samples, alpha) = without_alpha(p, picture.width as usize);
            (alpha == u8::MAX).then_some(samples)
        }
        Pixels::Sixteen(_) => picture.is_opaque().then(|| samples(picture, true)),
    }
}

/// Samples in the layout of PNG and PPM: 16 bits with the high byte first, without alpha if `opaque`.
pub(super) fn samples(picture: &Picture, opaque: bool) -> Vec<u8> {
    let channels = if opaque { 3 } else { 4 };
    let row = picture.width as usize;
    match &picture.pixels {
        Pixels::Eight(p) if !opaque => p.as_flattened().to_vec(),
        Pixels::Eight(p) => without_alpha(p, row).0,
        Pixels::Sixteen(p) => {
            let mut bytes = vec![0; p.len() * channels * 2];
            bytes.par_chunks_mut(row * channels * 2).zip(p.par_chunks(row)).for_each(|(bytes, p)| {
                let values = p.iter().flat_map(|p| &p[..channels]);
                bytes.as_chunks_mut::<2>().0.iter_mut().zip(values).for_each(|(b, v)| *b = v.to_be_bytes());
            });
            bytes
        }
    }
}

/// The colours of pixels in rows of a length, and the bits that all their alphas have.
fn without_alpha(pixels: &[[u8; 4]], row: usize) -> (Vec<u8>, u8) {
    let mut bytes = vec![0; pixels.len() * 3];
    let rows = bytes.par_chunks_mut(row * 3).zip(pixels.par_chunks(row));
    let alpha = rows.map(|(bytes, pixels)| drop_alpha(pixels, bytes)).reduce(|| u8::MAX, |a, b| a & b);
    (bytes, alpha)
}

/// Copies the colours of pixels, and returns the bits that all their alphas have.
fn drop_alpha(pixels: &[[u8; 4]], bytes: &mut [u8]) -> u8 {
    // Four pixels are three words.
    let (fours, rest) = pixels.as_chunks::<4>();
    let (words, rest_of_bytes) = bytes.as_chunks_mut::<12>();
    let mut all = u32::MAX;
    for (words, four) in words.iter_mut().zip(fours) {
        let [a, b, c, d] = four.map(u32::from_le_bytes);
        all &= a & b & c & d;
        let three = [a & 0xff_ffff | b << 24, b >> 8 & 0xffff | c << 16, c >> 16 & 0xff | d << 8];
        for (to, word) in words.as_chunks_mut::<4>().0.iter_mut().zip(three) {
            *to = word.to_le_bytes();
        }
    }
    for (to, pixel) in rest_of_bytes.as_chunks_mut::<3>().0.iter_mut().zip(rest) {
        *to = [pixel[0], pixel[1], pixel[2]];
        all &= u32::from_le_bytes(*pixel);
    }
    all.to_le_bytes()[3]
}

pub(super) fn read(bytes: &[u8]) -> Result<Picture<'static>, ImageError> {
    let mut decoder = Decoder::new_with_limits(in_memory(bytes), Limits { bytes: READ_LIMIT });
    decoder.set_transformations(Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(malformed)?;
    let size =
        reader.output_buffer_size().filter(|&s| s <= READ_LIMIT).ok_or_else(|| malformed("too large"))?;
    let mut samples = vec![0; size];
    let info = reader.next_frame(&mut samples).map_err(malformed)?;
    // Damage after the pixels is damage too.
    reader.finish().map_err(malformed)?;
    samples.truncate(info.buffer_size());
    let channels = info.color_type.samples();
    let (width, height) = (info.width, info.height);
    let pixels = if info.bit_depth == BitDepth::Sixteen {
        let values: Vec<u16> = samples.as_chunks().0.iter().map(|&b| u16::from_be_bytes(b)).collect();
        Pixels::Sixteen(rgba(&values, channels, u16::MAX).into())
    } else {
        Pixels::Eight(rgba(&samples, channels, u8::MAX).into())
    };
    Ok(Picture { width, height, pixels })
}

/// Four channels from 1 (grey), 2 (grey, alpha), 3 or 4.
pub(super) fn rgba<T: Copy>(values: &[T], channels: usize, opaque: T) -> Vec<[T; 4]> {
    let pixel = |v: &[T]| match *v {
        [grey] => [grey, grey, grey, opaque],
        [grey, alpha] => [grey, grey, grey, alpha],
        [r, g, b] => [r, g, b, opaque],
        [r, g, b, a, ..] => [r, g, b, a],
        [] => [opaque; 4],
    };
    values.chunks_exact(channels.max(1)).map(pixel).collect()
}
