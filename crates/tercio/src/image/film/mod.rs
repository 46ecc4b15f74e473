//! Films: many pictures of one size in one file.
//!
//! A [`Film`] describes the file. [`Film::encode`] does the work of one picture, on any thread and in any order;
//! [`FilmWriter::append`] writes the results in order.

mod apng;
mod gif;
mod palette;
mod webp;
mod y4m;

use std::fmt;
use std::io::Write;
use std::path::Path;
use std::str::FromStr;

use super::png::samples;
use super::{ImageError, Picture, WEBP_MAX_SIZE};

/// A format of films.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FilmFormat {
    /// 256 colours a picture, at most 50 pictures a second, without transparency.
    Gif,
    /// Animated PNG: exact colours, with transparency.
    Apng,
    /// Animated WebP: exact colours, with transparency, at most 16384 pixels per side.
    WebP,
    /// Uncompressed YUV4MPEG2 for video encoders: 8 bits, no chroma subsampling (C444), BT.709, 16 to 235.
    Y4m,
    /// Red, green and blue of all pixels, 8 bits each, and nothing else.
    Rgb,
}

impl FilmFormat {
    /// All formats.
    pub const ALL: [Self; 5] = [Self::Gif, Self::Apng, Self::WebP, Self::Y4m, Self::Rgb];

    /// The name, which is also the extension of its files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Gif => "gif",
            Self::Apng => "apng",
            Self::WebP => "webp",
            Self::Y4m => "y4m",
            Self::Rgb => "rgb",
        }
    }

    /// The format of a file name, by its extension in any case.
    pub fn from_path(path: impl AsRef<Path>) -> Option<Self> {
        path.as_ref().extension()?.to_str()?.to_ascii_lowercase().parse().ok()
    }
}

impl fmt::Display for FilmFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for FilmFormat {
    type Err = String;

    fn from_str(s: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|f| f.name() == s).ok_or_else(|| {
            let names = Self::ALL.map(Self::name).join(", ");
            format!("expected one of {names}, found \"{s}\"")
        })
    }
}

/// Pictures a second, as a fraction: 30000/1001 is that of television.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameRate {
    /// Pictures.
    pub pictures: u32,
    /// In so many seconds, at least 1.
    pub seconds: u32,
}

impl FrameRate {
    /// Pictures a second.
    pub fn per_second(self) -> f64 {
        f64::from(self.pictures) / f64::from(self.seconds)
    }
}

impl FromStr for FrameRate {
    type Err = String;

    /// `25`, `12.5` or `30000/1001`; from one picture in 1000 seconds to 1000 in one.
    fn from_str(s: &str) -> Result<Self, String> {
        let wrong =
            || "expected pictures a second, such as 25, 29.97 or 30000/1001, from 0.001 to 1000".to_owned();
        let (pictures, seconds) = match s.split_once('/') {
            Some((pictures, seconds)) => {
                (pictures.trim().parse().map_err(|_| wrong())?, seconds.trim().parse().map_err(|_| wrong())?)
            }
            None => {
                let rate = s.parse().ok().filter(|r: &f64| (0.001..=1000.0).contains(r)).ok_or_else(wrong)?;
                // Three digits after the point are exact.
                ((rate * 1000.0).round() as u32, 1000)
            }
        };
        let divisor = greatest_common_divisor(pictures, seconds).max(1);
        let rate = Self { pictures: pictures / divisor, seconds: seconds / divisor };
        let is_good = rate.seconds > 0 && (0.001..=1000.0).contains(&rate.per_second());
        if is_good { Ok(rate) } else { Err(wrong()) }
    }
}

impl fmt::Display for FrameRate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.seconds {
            1 => write!(f, "{}", self.pictures),
            seconds => write!(f, "{}/{seconds}", self.pictures),
        }
    }
}

fn greatest_common_divisor(a: u32, b: u32) -> u32 {
    if b == 0 { a } else { greatest_common_divisor(b, a % b) }
}

/// What a film is, before its pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Film {
    /// The format of its file.
    pub format: FilmFormat,
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Number of pictures.
    pub pictures: u32,
    /// Pictures a second.
    pub rate: FrameRate,
    /// How often it is shown, in GIF, APNG and WebP; 0 for ever.
    pub plays: u16,
    /// Whether pictures may be translucent, in APNG and WebP.
    pub is_translucent: bool,
}

/// A picture of a film, encoded as far as it can be without the others.
#[derive(Debug)]
pub struct EncodedPicture(Encoded);

#[derive(Debug)]
enum Encoded {
    Gif(Box<::gif::Frame<'static>>),
    Bytes(Vec<u8>),
}

impl Film {
    /// Checks that the format can hold the film.
    ///
    /// # Errors
    /// One sentence.
    pub fn check(&self) -> Result<(), String> {
        match self.format {
            FilmFormat::Gif if self.rate.per_second() > 50.0 => Err(format!(
                "a GIF shows 50 pictures a second at most, not {}: choose a lower --fps or another format",
                self.rate
            )),
            FilmFormat::Gif if self.width.max(self.height) > 65535 => {
                Err("a GIF has at most 65535 pixels a side".into())
            }
            FilmFormat::WebP if self.width.max(self.height) > WEBP_MAX_SIZE => {
                Err(format!("a WebP has at most {WEBP_MAX_SIZE} pixels a side"))
            }
            FilmFormat::Apng | FilmFormat::WebP => Ok(()),
            format if self.is_translucent => {
                let name = format.name().to_uppercase();
                Err(format!("{name} has no transparency; choose another --background or format"))
            }
            _ => Ok(()),
        }
    }

    /// Encodes a picture, which is the film's `number`-th, counted from 0.
    ///
    /// # Errors
    /// [`ImageError::SizesDiffer`] if it has another size; those of an encoder.
    pub fn encode(&self, picture: &Picture, number: u32) -> Result<EncodedPicture, ImageError> {
        let (own, other) = ([self.width, self.height], [picture.width, picture.height]);
        if own != other {
            return Err(ImageError::SizesDiffer(own, other));
        }
        let eight = picture.to_eight();
        Ok(EncodedPicture(match self.format {
            FilmFormat::Gif => Encoded::Gif(Box::new(gif::encode(self, &eight, number))),
            FilmFormat::Apng => Encoded::Bytes(samples(&eight, !self.is_translucent)),
            FilmFormat::WebP => Encoded::Bytes(webp::encode(self, &eight, number)?),
            FilmFormat::Y4m => Encoded::Bytes(y4m::encode(&eight)),
            FilmFormat::Rgb => Encoded::Bytes(samples(&eight, true)),
        }))
    }

    /// Begins a file.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn begin<W: Write>(&self, out: W) -> Result<FilmWriter<W>, ImageError> {
        Ok(FilmWriter(match self.format {
            FilmFormat::Gif => Writer::Gif(gif::begin(self, out)?),
            FilmFormat::Apng => Writer::Apng(apng::begin(self, out)?),
            FilmFormat::WebP => Writer::WebP(webp::begin(self, out)?),
            FilmFormat::Y4m => Writer::Y4m(y4m::begin(self, out)?),
            FilmFormat::Rgb => Writer::Rgb(out),
        }))
    }
}

/// A film that is being written.
#[derive(Debug)]
pub struct FilmWriter<W: Write>(Writer<W>);

enum Writer<W: Write> {
    Gif(::gif::Encoder<W>),
    Apng(::png::Writer<W>),
    WebP(webp::Waiting<W>),
    Y4m(W),
    Rgb(W),
}

impl<W: Write> fmt::Debug for Writer<W> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Writer")
    }
}

impl<W: Write> FilmWriter<W> {
    /// Writes the next picture.
    ///
    /// # Errors
    /// Those of the output.
    pub fn append(&mut self, picture: &EncodedPicture) -> Result<(), ImageError> {
        match (&mut self.0, &picture.0) {
            (Writer::Gif(out), Encoded::Gif(frame)) => gif::append(out, frame),
            (Writer::Apng(out), Encoded::Bytes(bytes)) => apng::append(out, bytes),
            (Writer::WebP(out), Encoded::Bytes(bytes)) => out.append(bytes),
            (Writer::Y4m(out), Encoded::Bytes(bytes)) => y4m::append(out, bytes),
            (Writer::Rgb(out), Encoded::Bytes(bytes)) => Ok(out.write_all(bytes)?),
            _ => Err(ImageError::Io(std::io::Error::other("a picture of another film"))),
        }
    }

    /// Writes what comes after the last picture.
    ///
    /// # Errors
    /// Those of the output; a number of pictures that was not announced.
    pub fn finish(self) -> Result<(), ImageError> {
        match self.0 {
            Writer::Gif(out) => gif::finish(out),
            Writer::Apng(out) => apng::finish(out),
            Writer::WebP(out) => out.finish(),
            Writer::Y4m(mut out) | Writer::Rgb(mut out) => Ok(out.flush()?),
        }
    }
}

#[cfg(test)]
mod tests;
