//! GIF through the `gif` crate. Every picture has a palette of its own.

use std::io::Write;

use gif::{Encoder, EncodingError, Frame, Repeat};

use super::Film;
use super::palette::Palette;
use crate::image::{ImageError, Picture, Pixels};

pub(super) fn begin<W: Write>(film: &Film, out: W) -> Result<Encoder<W>, ImageError> {
    let mut encoder = Encoder::new(out, film.width as u16, film.height as u16, &[]).map_err(write_error)?;
    // The format counts how often it is shown again.
    match film.plays {
        0 => encoder.set_repeat(Repeat::Infinite),
        1 => Ok(()),
        plays => encoder.set_repeat(Repeat::Finite(plays - 1)),
    }
    .map_err(write_error)?;
    Ok(encoder)
}

pub(super) fn encode(film: &Film, picture: &Picture, number: u32) -> Frame<'static> {
    let pixels: &[[u8; 4]] = match &picture.pixels {
        Pixels::Eight(pixels) => pixels,
        Pixels::Sixteen(_) => &[],
    };
    let palette = Palette::of(pixels);
    let indices = palette.dithered(pixels, picture.width as usize);
    let mut frame = Frame::from_palette_pixels(
        film.width as u16,
        film.height as u16,
        indices,
        palette.colors().as_flattened(),
        None,
    );
    // Hundredths of a second; rounding errors do not add up.
    let end = |pictures: u32| {
        (u64::from(pictures) * 200 * u64::from(film.rate.seconds) + u64::from(film.rate.pictures))
            / (2 * u64::from(film.rate.pictures.max(1)))
    };
    frame.delay = (end(number + 1) - end(number)).min(u16::MAX.into()) as u16;
    frame.make_lzw_pre_encoded();
    frame
}

pub(super) fn append<W: Write>(out: &mut Encoder<W>, frame: &Frame) -> Result<(), ImageError> {
    out.write_lzw_pre_encoded_frame(frame).map_err(write_error)
}

pub(super) fn finish<W: Write>(out: Encoder<W>) -> Result<(), ImageError> {
    // Writes the trailer.
    Ok(out.into_inner().map_err(write_error)?.flush()?)
}

fn write_error(error: EncodingError) -> ImageError {
    match error {
        EncodingError::Io(error) => ImageError::Io(error),
        other => ImageError::Io(std::io::Error::other(other)),
    }
}
