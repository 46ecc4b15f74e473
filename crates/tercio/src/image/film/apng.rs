//! Animated PNG through the `png` crate.

use std::io::Write;

use png::{BitDepth, ColorType, Compression, Encoder, Filter, Writer};

use super::Film;
use crate::image::ImageError;
use crate::image::png::write_error;

pub(super) fn begin<W: Write>(film: &Film, out: W) -> Result<Writer<W>, ImageError> {
    let mut encoder = Encoder::new(out, film.width, film.height);
    encoder.set_color(if film.is_translucent { ColorType::Rgba } else { ColorType::Rgb });
    encoder.set_depth(BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    encoder.set_compression(Compression::Fast);
    encoder.set_filter(Filter::Up);
    encoder.set_animated(film.pictures, film.plays.into()).map_err(write_error)?;
    // 16 bits each; all usual rates fit.
    let (mut pictures, mut seconds) = (film.rate.pictures, film.rate.seconds);
    while pictures.max(seconds) > u16::MAX.into() {
        (pictures, seconds) = ((pictures / 2).max(1), (seconds / 2).max(1));
    }
    encoder.set_frame_delay(seconds as u16, pictures as u16).map_err(write_error)?;
    encoder.write_header().map_err(write_error)
}

pub(super) fn append<W: Write>(out: &mut Writer<W>, samples: &[u8]) -> Result<(), ImageError> {
    out.write_image_data(samples).map_err(write_error)
}

pub(super) fn finish<W: Write>(out: Writer<W>) -> Result<(), ImageError> {
    out.finish().map_err(write_error)
}
