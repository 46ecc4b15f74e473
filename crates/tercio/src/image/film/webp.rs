//! Animated WebP, lossless: the container by hand, around frames of the `image-webp` crate, which encodes single pictures only.
//! Source: the WebP Container Specification (Google, developers.google.com/speed/webp/docs/riff_container).

use std::fs::File;
use std::io::{self, Read as _, Seek as _, SeekFrom, Write};

use super::Film;
use crate::image::{ImageError, Picture, PictureFormat, webp};

/// Bits of the flags of `VP8X`.
const ALPHA: u8 = 1 << 4;
const ANIMATION: u8 = 1 << 1;
/// The flag of a frame that replaces what is below it.
const NO_BLENDING: u8 = 1 << 1;

/// A frame is shown for at most so many milliseconds.
const LONGEST: u64 = (1 << 24) - 1;

/// Bytes of a picture's file before its chunk of pixels.
const BEFORE_PIXELS: usize = 12;

/// A file's head holds its length, so the frames wait in a file without a name until all are there.
#[derive(Debug)]
pub(super) struct Waiting<W> {
    out: W,
    film: Film,
    frames: File,
    bytes: u64,
}

pub(super) fn begin<W: Write>(film: &Film, out: W) -> Result<Waiting<W>, ImageError> {
    Ok(Waiting { out, film: *film, frames: tempfile::tempfile()?, bytes: 0 })
}

/// A chunk `ANMF` with the picture in it.
pub(super) fn encode(film: &Film, picture: &Picture, number: u32) -> Result<Vec<u8>, ImageError> {
    let mut file = Vec::new();
    webp::write_with_alpha(picture, film.is_translucent, &mut file)?;
    // RIFF, a length, WEBP; then the chunk VP8L, with its head.
    let pixels = file.get(BEFORE_PIXELS..).filter(|pixels| pixels.starts_with(b"VP8L"));
    let pixels =
        pixels.ok_or_else(|| ImageError::Io(io::Error::other("the encoder wrote another kind of file")))?;
    let mut chunk = Vec::with_capacity(pixels.len() + 24);
    chunk.extend(b"ANMF");
    chunk.extend((pixels.len() as u32 + 16).to_le_bytes());
    // At the upper left corner.
    chunk.extend([0; 6]);
    chunk.extend(three(film.width - 1));
    chunk.extend(three(film.height - 1));
    // Rounding errors do not add up.
    let end = |pictures: u32| {
        let rate = film.rate;
        (u64::from(pictures) * 2000 * u64::from(rate.seconds) + u64::from(rate.pictures))
            / (2 * u64::from(rate.pictures.max(1)))
    };
    chunk.extend(three((end(number + 1) - end(number)).min(LONGEST) as u32));
    chunk.push(NO_BLENDING);
    chunk.extend(pixels);
    // The encoder pads its chunk, so this one has an even length, too.
    Ok(chunk)
}

/// The lower three bytes, the least first.
fn three(value: u32) -> [u8; 3] {
    let [a, b, c, _] = value.to_le_bytes();
    [a, b, c]
}

impl<W: Write> Waiting<W> {
    pub fn append(&mut self, chunk: &[u8]) -> Result<(), ImageError> {
        self.bytes += chunk.len() as u64;
        if self.bytes + 44 > u64::from(u32::MAX) {
            return Err(ImageError::CannotHold {
                format: PictureFormat::WebP,
                what: "more than 4 GiB: choose fewer or smaller pictures",
            });
        }
        Ok(self.frames.write_all(chunk)?)
    }

    pub fn finish(mut self) -> Result<(), ImageError> {
        let (film, out) = (&self.film, &mut self.out);
        let mut head = Vec::with_capacity(44);
        head.extend(b"RIFF");
        // What follows, of which 36 bytes are before the frames.
        head.extend((self.bytes as u32 + 36).to_le_bytes());
        head.extend(b"WEBPVP8X\x0a\0\0\0");
        head.extend([ANIMATION | if film.is_translucent { ALPHA } else { 0 }, 0, 0, 0]);
        head.extend(three(film.width - 1));
        head.extend(three(film.height - 1));
        // No background, as browsers have none.
        head.extend(b"ANIM\x06\0\0\0\0\0\0\0");
        head.extend(film.plays.to_le_bytes());
        out.write_all(&head)?;
        self.frames.seek(SeekFrom::Start(0))?;
        let mut block = vec![0; 1 << 16];
        loop {
            match self.frames.read(&mut block)? {
                0 => return Ok(out.flush()?),
                read => out.write_all(&block[..read])?,
            }
        }
    }
}
