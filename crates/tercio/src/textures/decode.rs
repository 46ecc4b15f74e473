//! Decoding pictures that nobody vouches for: sizes are compared with the limits before memory is taken.
//!
//! The format is that of the content, not of the name; only TGA has nothing to be recognised by. The first picture of a file
//! counts. Profiles, gamma values and orientations that a file states are ignored, as by other programs that draw textures.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use image::{ColorType, DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader, Limits};
use tercio_scene::texture::{Encoding, MAX_EDGE};
use tercio_scene::{Panorama, PanoramaError, Texture, srgb_to_linear};

use super::picture::{Picture, Pixels};
use crate::image::source::{Source, in_file, in_memory};

/// A larger file is not read.
const MAX_FILE_BYTES: u64 = 1 << 30;

/// Sizes are in the first bytes of a file, in most formats.
const HEAD_BYTES: u64 = 1 << 18;

/// Most memory for what precedes a picture in its file, such as compressed profiles.
const HEADER_BYTES: u64 = 1 << 26;

/// Memory of a decoder besides what grows with the picture.
const DECODER_BYTES: u64 = 1 << 24;

/// The formats of textures.
const FORMATS: [ImageFormat; 7] = [
    ImageFormat::Png,
    ImageFormat::Jpeg,
    ImageFormat::Gif,
    ImageFormat::Bmp,
    ImageFormat::Tga,
    ImageFormat::WebP,
    ImageFormat::Tiff,
];

/// Why a picture is not drawn.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TextureError {
    /// There is no such file.
    #[error("not found")]
    NotFound,
    /// It is a folder or a device.
    #[error("not a file")]
    NotAFile,
    /// The model names too many pictures.
    #[error("more than {most} are not looked for")]
    TooMany {
        /// Most names that are looked for.
        most: usize,
    },
    /// The model uses the picture in too many ways.
    #[error("more than {most} ways to use it are not drawn")]
    TooManyReadings {
        /// Most of them.
        most: usize,
    },
    /// The file could not be read.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// It is no picture, or of another format.
    #[error("expected a PNG, JPEG, GIF, BMP, TGA, WebP or TIFF picture, found {found}")]
    Format {
        /// What was found.
        found: String,
    },
    /// The file is too large.
    #[error("has {bytes} bytes, the limit is {limit}")]
    FileSize {
        /// Its size.
        bytes: u64,
        /// The largest size.
        limit: u64,
    },
    /// The picture has too many texels along an edge, or none.
    #[error("has {width}x{height} texels, expected 1 to {MAX_EDGE} along each edge")]
    Size {
        /// Texels in a row.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// It needs more memory than there is.
    #[error("needs {needed} bytes of memory, the limit leaves {left}")]
    Memory {
        /// Bytes that it needs while it is decoded.
        needed: u64,
        /// Bytes that the limit leaves.
        left: u64,
    },
    /// The content is damaged or uses what is not supported.
    #[error("broken or not supported: {reason}")]
    Broken {
        /// What the decoder says.
        reason: String,
    },
}

impl TextureError {
    fn ends_early() -> Self {
        Self::Broken { reason: "the file ends early".into() }
    }
}

impl From<ImageError> for TextureError {
    fn from(error: ImageError) -> Self {
        match error {
            ImageError::IoError(error) if error.kind() != io::ErrorKind::UnexpectedEof => Self::Io(error),
            error => Self::Broken { reason: error.to_string() },
        }
    }
}

/// What decoding a picture takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Needs {
    format: ImageFormat,
    /// Texels in a row and rows, from 1 to [`MAX_EDGE`].
    size: (u32, u32),
    file_bytes: u64,
    /// Bytes of a texture made of it.
    pub texture_bytes: u64,
    /// Most bytes that decoding takes in addition.
    pub decoding_bytes: u64,
}

/// Reads the head of a picture file.
///
/// # Errors
/// [`TextureError`] if it is no picture that can be decoded.
pub fn needs_of_file(path: &Path) -> Result<Needs, TextureError> {
    let file_bytes = path.metadata()?.len();
    if file_bytes > MAX_FILE_BYTES {
        return Err(TextureError::FileSize { bytes: file_bytes, limit: MAX_FILE_BYTES });
    }
    let format = |head: &[u8]| format_of(head, path);
    let mut head = Vec::new();
    File::open(path)?.take(HEAD_BYTES).read_to_end(&mut head)?;
    let format = format(&head)?;
    // A decoder may read all that it is given.
    let from_head = needs(in_memory(&head), format, file_bytes);
    match from_head {
        Err(TextureError::Broken { .. } | TextureError::Io(_)) if file_bytes > head.len() as u64 => {
            needs(in_file(File::open(path)?), format, file_bytes)
        }
        result => result,
    }
}

/// Decodes a picture file.
///
/// # Errors
/// [`TextureError`], also if it is no longer the file that `needs` was made from.
pub fn decode_file(path: &Path, needs: &Needs) -> Result<Picture, TextureError> {
    let mut bytes = Vec::new();
    File::open(path)?.take(needs.file_bytes).read_to_end(&mut bytes)?;
    decode(&bytes, needs)
}

/// A texture from the bytes of a picture file (PNG, JPEG, GIF, BMP, WebP or TIFF; TGA has no mark by which it could be
/// recognised). The first picture counts; profiles, gamma values and orientations are ignored.
///
/// `memory_limit` is the most bytes that decoding may take, with the texture; `None` for no limit.
///
/// ```
/// use tercio::scene::texture::Encoding;
///
/// let no_picture = tercio::texture_from_bytes(b"v 0 0 0", Encoding::Srgb, None);
/// assert!(no_picture.is_err());
/// ```
///
/// # Errors
/// [`TextureError`].
pub fn texture_from_bytes(
    bytes: &[u8],
    encoding: Encoding,
    memory_limit: Option<u64>,
) -> Result<Texture, TextureError> {
    let format = format_of(bytes, Path::new(""))?;
    let needs = needs(in_memory(bytes), format, bytes.len() as u64)?;
    needs.check(0, memory_limit)?;
    let picture = decode(bytes, &needs)?;
    if picture.ends_early {
        return Err(TextureError::ends_early());
    }
    Ok(picture.texture(encoding))
}

impl Needs {
    /// Compares the memory with what `taken` bytes leave of a limit.
    ///
    /// # Errors
    /// [`TextureError::Memory`].
    pub fn check(&self, taken: u64, limit: Option<u64>) -> Result<(), TextureError> {
        let needed = self.texture_bytes.saturating_add(self.decoding_bytes);
        match limit.map(|limit| limit.saturating_sub(taken)) {
            Some(left) if needed > left => Err(TextureError::Memory { needed, left }),
            _ => Ok(()),
        }
    }

    /// The same for several textures made of one picture, some of them perhaps of changed copies of it.
    pub fn of_textures(self, count: u64, adjusts: bool) -> Self {
        // 16 bits a channel, one copy at a time; colours without alpha are a second one.
        let copies = 2 * 8 * u64::from(self.size.0) * u64::from(self.size.1);
        Self {
            texture_bytes: self.texture_bytes.saturating_mul(count),
            decoding_bytes: self.decoding_bytes.saturating_add(if adjusts { copies } else { 0 }),
            ..self
        }
    }
}

/// Panoramas may have light brighter than white, too.
const PANORAMA_FORMATS: &[ImageFormat] =
    &[ImageFormat::Hdr, ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::WebP, ImageFormat::Tiff];

/// A panorama for [`Environment::new`](tercio_scene::Environment::new) from a picture file: Radiance HDR, or TIFF of floating-point numbers, in linear
/// light; PNG, JPEG, WebP or other TIFF, of which white is the light 1. It is twice as wide as high.
///
/// `memory_limit` is the most bytes that decoding may take; `None` for no limit.
///
/// # Errors
/// [`PanoramaFileError`].
pub fn panorama_from_file(
    path: impl AsRef<Path>,
    memory_limit: Option<u64>,
) -> Result<Panorama, PanoramaFileError> {
    let path = path.as_ref();
    let metadata = path.metadata().map_err(TextureError::from)?;
    if !metadata.is_file() {
        return Err(TextureError::NotAFile.into());
    }
    let file_bytes = metadata.len();
    if file_bytes > MAX_FILE_BYTES {
        return Err(TextureError::FileSize { bytes: file_bytes, limit: MAX_FILE_BYTES }.into());
    }
    // Decoding takes more than this, but the size of the picture is not known yet.
    if let Some(left) = memory_limit.filter(|&limit| file_bytes > limit) {
        return Err(TextureError::Memory { needed: file_bytes, left }.into());
    }
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(TextureError::from)?;
    file.take(file_bytes).read_to_end(&mut bytes).map_err(TextureError::from)?;
    panorama_from_bytes(bytes, memory_limit)
}

/// [`panorama_from_file`] of the bytes of a file.
fn panorama_from_bytes(mut bytes: Vec<u8>, memory_limit: Option<u64>) -> Result<Panorama, PanoramaFileError> {
    // The same format, by the name of its program or of its pixels; the decoder knows one of them.
    if bytes.starts_with(b"#?RGBE") {
        bytes.splice(..6, *b"#?RADIANCE");
    }
    let format = match image::guess_format(&bytes) {
        Ok(format) if PANORAMA_FORMATS.contains(&format) => format,
        Ok(format) => return Err(PanoramaFileError::Format { found: format!("{format:?}") }),
        Err(_) if bytes.is_empty() => {
            return Err(PanoramaFileError::Format { found: "an empty file".into() });
        }
        Err(_) => return Err(PanoramaFileError::Format { found: "none of these".into() }),
    };
    let needs = needs(in_memory(&bytes), format, bytes.len() as u64)?;
    needs.check(0, memory_limit)?;
    if ends_early(&bytes, format) {
        return Err(TextureError::ends_early().into());
    }
    let decoder = decoder(in_memory(&bytes), format, needs.decoding_bytes)?;
    let is_linear = matches!(decoder.color_type(), ColorType::Rgb32F | ColorType::Rgba32F);
    let image = DynamicImage::from_decoder(decoder).map_err(TextureError::from)?;
    let light = |v: f32| if is_linear { v } else { srgb_to_linear(f64::from(v)) as f32 };
    let pixels = image.into_rgb32f().pixels().map(|p| p.0.map(light)).collect();
    Ok(Panorama::new(needs.size.0 as usize, needs.size.1 as usize, pixels)?)
}

/// Why a picture file is no panorama.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PanoramaFileError {
    /// It is no picture, or of another format.
    #[error("expected a Radiance HDR, PNG, JPEG, WebP or TIFF picture, found {found}")]
    Format {
        /// What was found.
        found: String,
    },
    /// It could not be decoded.
    #[error(transparent)]
    Picture(#[from] TextureError),
    /// It has another shape, or light that cannot be reflected.
    #[error(transparent)]
    Panorama(#[from] PanoramaError),
}

fn format_of(head: &[u8], path: &Path) -> Result<ImageFormat, TextureError> {
    let has_extension = |wanted| path.extension().is_some_and(|e| e.eq_ignore_ascii_case(wanted));
    match image::guess_format(head) {
        Ok(format) if FORMATS.contains(&format) => Ok(format),
        Ok(format) => Err(TextureError::Format { found: format!("{format:?}") }),
        Err(_) if head.is_empty() => Err(TextureError::Format { found: "an empty file".into() }),
        Err(_) if has_extension("tga") => Ok(ImageFormat::Tga),
        Err(_) => Err(TextureError::Format { found: "none of these".into() }),
    }
}

/// A decoder that has read the head and takes no more than `bytes`.
fn decoder(source: Source<'_>, format: ImageFormat, bytes: u64) -> Result<impl ImageDecoder, TextureError> {
    let mut reader = ImageReader::with_format(source, format);
    let mut limits = Limits::no_limits();
    limits.max_alloc = Some(bytes);
    reader.limits(limits);
    Ok(reader.into_decoder()?)
}

fn needs(source: Source<'_>, format: ImageFormat, file_bytes: u64) -> Result<Needs, TextureError> {
    let decoder = decoder(source, format, HEADER_BYTES)?;
    let (width, height) = decoder.dimensions();
    let edges = 1..=MAX_EDGE;
    if !edges.contains(&width) || !edges.contains(&height) {
        return Err(TextureError::Size { width, height });
    }
    // Decoders hold the file twice, and of progressive pictures numbers of 16 bits; then there are the decoded picture, its
    // texels with four channels, and normals made of it.
    let texels = u64::from(width) * u64::from(height);
    let decoding_bytes = DECODER_BYTES + 2 * file_bytes + 4 * decoder.total_bytes() + 16 * texels;
    let texture_bytes = Texture::needed_bytes(width, height);
    Ok(Needs { format, size: (width, height), file_bytes, texture_bytes, decoding_bytes })
}

/// Does a JPEG end early? Its decoder makes what is missing grey, and no error.
fn ends_early(bytes: &[u8], format: ImageFormat) -> bool {
    // Segments up to the first scan have a length; a picture within one of them has an end of its own.
    const START_OF_SCAN: u8 = 0xda;
    const END: [u8; 2] = [0xff, 0xd9];
    let mut rest = match format {
        ImageFormat::Jpeg => bytes.get(2..).unwrap_or_default(),
        _ => return false,
    };
    loop {
        // Bytes that fill up come before a marker.
        match rest {
            [0xff, 0xff, ..] => rest = &rest[1..],
            [0xff, START_OF_SCAN, ..] => break !rest.windows(2).any(|pair| pair == END),
            [0xff, _, high, low, ..] => {
                let length = usize::from(u16::from_be_bytes([*high, *low]));
                rest = rest.get(2 + length.max(2)..).unwrap_or_default();
            }
            [] => break true,
            // What that is, the decoder knows.
            _ => break false,
        }
    }
}

fn decode(bytes: &[u8], needs: &Needs) -> Result<Picture, TextureError> {
    let decoder = decoder(in_memory(bytes), needs.format, needs.decoding_bytes)?;
    if decoder.dimensions() != needs.size || decoder.total_bytes() > needs.decoding_bytes / 4 {
        return Err(TextureError::Broken { reason: "the file has changed while it was read".into() });
    }
    let is_wide = matches!(
        decoder.color_type(),
        ColorType::L16
            | ColorType::La16
            | ColorType::Rgb16
            | ColorType::Rgba16
            | ColorType::Rgb32F
            | ColorType::Rgba32F
    );
    let image = DynamicImage::from_decoder(decoder)?;
    let pixels = if is_wide {
        Pixels::Sixteen(image.into_rgba16().into_raw())
    } else {
        Pixels::Eight(image.into_rgba8().into_raw())
    };
    let mut picture = Picture::new(needs.size, pixels);
    picture.ends_early = ends_early(bytes, needs.format);
    Ok(picture)
}

#[cfg(test)]
mod tests;
