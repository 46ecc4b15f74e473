//! Picture files: writing, reading, comparing.
//!
//! [`Picture`] is what a viewer shows, in PNG, PPM, WebP or JPEG; [`npy`] stores arrays of numbers (depth, primitive
//! numbers, normals) for programs. [`OutputFile`] replaces a file only when the new one is complete.

mod compare;
pub mod film;
mod identity;
mod jpeg;
pub mod npy;
mod output;
mod partial;
pub(crate) mod png;
mod ppm;
mod quality;
pub(crate) mod source;
mod stream;
mod webp;

use std::borrow::Cow;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::{fmt, fs};

use tercio_mesh::loops::prelude::*;
use tercio_raster::Frame;

pub use compare::{Difference, compare};
pub use identity::FileIdentity;
pub use output::{Destination, OutputFile};
pub use partial::remove_partial_files;
pub use quality::{Similarity, similarity};
pub use stream::StandardStream;

/// The largest width and height of a WebP picture.
pub const WEBP_MAX_SIZE: u32 = 16384;
/// The largest width and height of a JPEG picture.
pub const JPEG_MAX_SIZE: u32 = 65535;

/// A format of picture files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum PictureFormat {
    /// 8 or 16 bits, with transparency.
    Png,
    /// Portable pixmap (P6), 8 or 16 bits, without transparency.
    Ppm,
    /// Lossless WebP, 8 bits, with transparency, at most 16384 pixels per side.
    WebP,
    /// JPEG, baseline, 8 bits, without transparency, at most 65535 pixels per side. Chroma is not subsampled: thin coloured lines
    /// stay sharp.
    Jpeg {
        /// 1 (small files) to 100 (good pictures), the scale of the Independent JPEG Group.
        quality: u8,
    },
}

impl PictureFormat {
    /// The quality of JPEG pictures where none is given.
    pub const JPEG_QUALITY: u8 = 90;
    /// All formats; JPEG with its default quality.
    pub const ALL: [Self; 4] = [Self::Png, Self::Ppm, Self::WebP, Self::Jpeg { quality: Self::JPEG_QUALITY }];

    /// The name, which is also the extension of its files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Png => "png",
            Self::Ppm => "ppm",
            Self::WebP => "webp",
            Self::Jpeg { .. } => "jpeg",
        }
    }

    /// The format of a file name, by its extension in any case.
    pub fn from_path(path: impl AsRef<Path>) -> Option<Self> {
        path.as_ref().extension()?.to_str()?.to_ascii_lowercase().parse().ok()
    }
}

impl fmt::Display for PictureFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for PictureFormat {
    type Err = String;

    fn from_str(s: &str) -> Result<Self, String> {
        let s = if s == "jpg" { "jpeg" } else { s };
        Self::ALL.into_iter().find(|f| f.name() == s).ok_or_else(|| {
            let names: Vec<_> = Self::ALL.iter().map(|f| f.name()).collect();
            format!("expected one of {}, found \"{s}\"", names.join(", "))
        })
    }
}

/// Why a picture could not be written or read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImageError {
    /// The system's reason.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// The file name does not have the extension of a picture format.
    #[error("the extension of a picture must be .png, .ppm, .webp or .jpg")]
    UnknownExtension,
    /// The content is of no supported format.
    #[error("not a picture that tercio reads (PNG, PPM, WebP, JPEG)")]
    UnknownFormat,
    /// The content violates its format.
    #[error("broken {format} picture: {reason}")]
    Malformed {
        /// Which format.
        format: PictureFormat,
        /// What is wrong.
        reason: String,
    },
    /// The format cannot store the picture.
    #[error("{format} cannot hold {what}")]
    CannotHold {
        /// Which format.
        format: PictureFormat,
        /// What it cannot store.
        what: &'static str,
    },
    /// Two pictures that are to be compared differ in size.
    #[error("the pictures differ in size: {}x{} and {}x{}", .0[0], .0[1], .1[0], .1[1])]
    SizesDiffer([u32; 2], [u32; 2]),
    /// A picture file could not be written or read.
    #[error("{}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// Why not.
        source: Box<ImageError>,
    },
}

impl ImageError {
    fn in_file(self, path: &Path) -> Self {
        Self::File { path: path.into(), source: Box::new(self) }
    }
}

/// sRGB colour and linear alpha (not premultiplied), row-major, the upper left pixel first.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Pixels<'a> {
    /// 8 bits per component.
    Eight(Cow<'a, [[u8; 4]]>),
    /// 16 bits per component.
    Sixteen(Cow<'a, [[u16; 4]]>),
}

impl Pixels<'_> {
    /// The number of pixels.
    fn len(&self) -> usize {
        match self {
            Self::Eight(pixels) => pixels.len(),
            Self::Sixteen(pixels) => pixels.len(),
        }
    }
}

/// A picture in memory.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture<'a> {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// `width * height` pixels.
    pub pixels: Pixels<'a>,
}

impl<'a> Picture<'a> {
    /// The colour of a frame: 16 bits if the frame has them, else 8.
    pub fn from_frame(frame: &'a Frame) -> Self {
        let pixels = if frame.planes.color16.is_empty() {
            Pixels::Eight(Cow::Borrowed(&frame.planes.color))
        } else {
            Pixels::Sixteen(Cow::Borrowed(&frame.planes.color16))
        };
        Self { width: frame.width, height: frame.height, pixels }
    }

    /// True if every pixel is fully opaque. Opaque pictures are written without an alpha channel.
    pub fn is_opaque(&self) -> bool {
        // All pixels of a piece, whatever they are: leaving at the first one keeps the compiler from using vectors.
        const PIECE: usize = 1 << 15;
        match &self.pixels {
            Pixels::Eight(p) => {
                p.par_chunks(PIECE).all(|p| p.iter().fold(u8::MAX, |all, p| all & p[3]) == u8::MAX)
            }
            Pixels::Sixteen(p) => {
                p.par_chunks(PIECE).all(|p| p.iter().fold(u16::MAX, |all, p| all & p[3]) == u16::MAX)
            }
        }
    }

    /// Writes the picture in a format.
    ///
    /// # Errors
    /// Errors of `out`; [`ImageError::CannotHold`] for a picture that the format cannot store.
    pub fn write(&self, format: PictureFormat, out: &mut dyn Write) -> Result<(), ImageError> {
        match format {
            PictureFormat::Png => png::write(self, out),
            PictureFormat::Ppm => ppm::write(self, out),
            PictureFormat::WebP => webp::write(self, out),
            PictureFormat::Jpeg { quality } => jpeg::write(self, quality, out),
        }
    }

    /// Writes the picture to a file, in the format of its extension. A file of that name is replaced only when the
    /// new one is complete.
    ///
    /// # Errors
    /// [`ImageError::File`], which names the file; its source is [`ImageError::UnknownExtension`], or an error of
    /// [`Picture::write`].
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), ImageError> {
        let path = path.as_ref();
        self.save_at(path).map_err(|source| source.in_file(path))
    }

    fn save_at(&self, path: &Path) -> Result<(), ImageError> {
        let format = PictureFormat::from_path(path).ok_or(ImageError::UnknownExtension)?;
        let mut file = OutputFile::create(&Destination::File(path.into()))?;
        self.write(format, &mut file)?;
        Ok(file.commit()?)
    }

    /// The same picture with 8 bits a component.
    fn to_eight(&self) -> Picture<'_> {
        let pixels = match &self.pixels {
            Pixels::Eight(pixels) => Cow::Borrowed(&**pixels),
            // To the nearest step.
            Pixels::Sixteen(pixels) => pixels
                .par_iter()
                .map(|p| p.map(|v| ((u32::from(v) + 128) / 257) as u8))
                .collect::<Vec<_>>()
                .into(),
        };
        Picture { width: self.width, height: self.height, pixels: Pixels::Eight(pixels) }
    }

    /// `width * height` as a length, for readers that must not trust a header.
    fn pixel_count(width: u32, height: u32) -> Option<usize> {
        usize::try_from(u64::from(width) * u64::from(height)).ok()
    }
}

impl Picture<'static> {
    /// Reads a PNG, PPM, WebP or JPEG picture from a file; the format is found by content.
    ///
    /// # Errors
    /// [`ImageError::File`], which names the file; its source is the system's reason, or an error of
    /// [`Picture::from_bytes`].
    pub fn from_file(path: impl AsRef<Path>) -> Result<Self, ImageError> {
        let path = path.as_ref();
        let bytes = fs::read(path).map_err(ImageError::Io);
        bytes.and_then(|bytes| Self::from_bytes(&bytes)).map_err(|source| source.in_file(path))
    }

    /// Reads a PNG, PPM, WebP or JPEG picture from memory; the format is found by content.
    ///
    /// # Errors
    /// [`ImageError::UnknownFormat`], [`ImageError::Malformed`].
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, ImageError> {
        if bytes.starts_with(b"\x89PNG") {
            png::read(bytes)
        } else if bytes.starts_with(b"P6") {
            ppm::read(bytes)
        } else if bytes.starts_with(b"RIFF") && bytes.get(8..12) == Some(b"WEBP") {
            webp::read(bytes)
        } else if bytes.starts_with(&[0xff, 0xd8, 0xff]) {
            jpeg::read(bytes)
        } else {
            Err(ImageError::UnknownFormat)
        }
    }
}

#[cfg(test)]
mod tests;
