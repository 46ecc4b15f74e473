//! JPEG through the `image` crate, which has the decoder for textures: baseline, without subsampling of chroma.
//! Its arithmetic, of integers and single divisions, gives the same bytes on every machine.

use std::io::Write;

use image::codecs::jpeg::{JpegDecoder, JpegEncoder};
use image::{ColorType, ExtendedColorType, ImageDecoder as _, ImageError as Reason};

use super::png::{rgba, samples};
use super::source::in_memory;
use super::{ImageError, JPEG_MAX_SIZE, Picture, PictureFormat, Pixels};

/// The format, for messages.
const JPEG: PictureFormat = PictureFormat::Jpeg { quality: PictureFormat::JPEG_QUALITY };
/// A picture has as many pixels at most when it is read.
const READ_LIMIT: u64 = 1 << 30;
/// How far from its end a file has its last marker: some programs append something.
const TAIL: usize = 1 << 16;

pub(super) fn write(picture: &Picture, quality: u8, out: &mut dyn Write) -> Result<(), ImageError> {
    let cannot_hold = |what| Err(ImageError::CannotHold { format: JPEG, what });
    if matches!(picture.pixels, Pixels::Sixteen(_)) {
        return cannot_hold("16 bits a component");
    }
    if !picture.is_opaque() {
        return cannot_hold("transparency");
    }
    if picture.width.max(picture.height) > JPEG_MAX_SIZE {
        return cannot_hold("more than 65535 pixels a side");
    }
    let mut encoder = JpegEncoder::new_with_quality(out, quality.clamp(1, 100));
    let (width, height) = (picture.width, picture.height);
    let written = encoder.encode(&samples(picture, true), width, height, ExtendedColorType::Rgb8);
    written.map_err(|error| match error {
        Reason::IoError(error) => ImageError::Io(error),
        other => ImageError::Io(std::io::Error::other(other)),
    })
}

pub(super) fn read(bytes: &[u8]) -> Result<Picture<'static>, ImageError> {
    let malformed = |reason: String| ImageError::Malformed { format: JPEG, reason };
    // The decoder would fill in what is missing.
    let tail = &bytes[bytes.len().saturating_sub(TAIL)..];
    if !tail.windows(2).any(|marker| marker == [0xff, 0xd9]) {
        return Err(malformed("it has no end".into()));
    }
    let decoder = JpegDecoder::new(in_memory(bytes)).map_err(|e| malformed(e.to_string()))?;
    let (width, height) = decoder.dimensions();
    let channels = match decoder.color_type() {
        ColorType::L8 => 1,
        ColorType::Rgb8 => 3,
        other => return Err(malformed(format!("its colours are {other:?}"))),
    };
    if u64::from(width) * u64::from(height) > READ_LIMIT {
        return Err(malformed("too large".into()));
    }
    let mut values = vec![0; width as usize * height as usize * channels];
    decoder.read_image(&mut values).map_err(|e| malformed(e.to_string()))?;
    Ok(Picture { width, height, pixels: Pixels::Eight(rgba(&values, channels, u8::MAX).into()) })
}
