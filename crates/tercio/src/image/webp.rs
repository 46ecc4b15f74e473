//! Lossless WebP through the `image-webp` crate.

use std::io::Write;

use image_webp::{ColorType, EncodingError, WebPDecoder, WebPEncoder};

use super::png::{rgba, samples};
use super::source::in_memory;
use super::{ImageError, Picture, PictureFormat, Pixels, WEBP_MAX_SIZE};

pub(super) fn write(picture: &Picture, out: &mut dyn Write) -> Result<(), ImageError> {
    let cannot_hold = |what| Err(ImageError::CannotHold { format: PictureFormat::WebP, what });
    if matches!(picture.pixels, Pixels::Sixteen(_)) {
        return cannot_hold("16 bits a component");
    }
    if picture.width.max(picture.height) > WEBP_MAX_SIZE {
        return cannot_hold("more than 16384 pixels a side");
    }
    write_with_alpha(picture, !picture.is_opaque(), out)
}

/// Writes 8 bits a component, with or without alpha.
pub(super) fn write_with_alpha(
    picture: &Picture,
    alpha: bool,
    out: &mut dyn Write,
) -> Result<(), ImageError> {
    let color = if alpha { ColorType::Rgba8 } else { ColorType::Rgb8 };
    let encoder = WebPEncoder::new(out);
    encoder.encode(&samples(picture, !alpha), picture.width, picture.height, color).map_err(|e| match e {
        EncodingError::IoError(e) => ImageError::Io(e),
        other => ImageError::Io(std::io::Error::other(other)),
    })
}

pub(super) fn read(bytes: &[u8]) -> Result<Picture<'static>, ImageError> {
    let malformed = |reason: String| ImageError::Malformed { format: PictureFormat::WebP, reason };
    let mut decoder = WebPDecoder::new(in_memory(bytes)).map_err(|e| malformed(e.to_string()))?;
    let (width, height) = decoder.dimensions();
    let size = decoder.output_buffer_size().ok_or_else(|| malformed("too large".into()))?;
    let mut values = vec![0; size];
    decoder.read_image(&mut values).map_err(|e| malformed(e.to_string()))?;
    let channels = if decoder.has_alpha() { 4 } else { 3 };
    Ok(Picture { width, height, pixels: Pixels::Eight(rgba(&values, channels, u8::MAX).into()) })
}
