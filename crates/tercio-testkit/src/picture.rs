//! Pictures of 8-bit RGBA: read, written, compared.

use std::fs::{self, File};
use std::io::{BufReader, BufWriter};
use std::path::Path;

/// A picture of 8-bit RGBA, rows from the top, not premultiplied.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `width * height * 4` bytes.
    pub rgba: Vec<u8>,
}

/// Why a picture could not be read or written.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// The file system's reason.
    #[error(transparent)]
    Io(#[from] std::io::Error),
    /// Not a PNG.
    #[error(transparent)]
    Decode(#[from] png::DecodingError),
    /// It cannot be encoded as a PNG.
    #[error(transparent)]
    Encode(#[from] png::EncodingError),
}

impl Picture {
    /// Takes the pixels as they are.
    ///
    /// # Panics
    /// If `rgba` is not `width * height * 4` bytes.
    pub fn new(width: u32, height: u32, rgba: Vec<u8>) -> Self {
        assert_eq!(rgba.len() as u64, u64::from(width) * u64::from(height) * 4, "{width}x{height} RGBA");
        Self { width, height, rgba }
    }

    /// Reads a PNG of any kind; grey, palettes and 16 bit become RGBA8.
    ///
    /// # Errors
    /// The file cannot be read or is no PNG.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, PictureError> {
        let mut decoder = png::Decoder::new(BufReader::new(File::open(path)?));
        decoder
            .set_transformations(png::Transformations::normalize_to_color8() | png::Transformations::ALPHA);
        let mut reader = decoder.read_info()?;
        let mut bytes = vec![0; reader.output_buffer_size().unwrap_or(0)];
        let frame = reader.next_frame(&mut bytes)?;
        bytes.truncate(frame.buffer_size());
        let rgba = match frame.color_type {
            png::ColorType::GrayscaleAlpha => {
                bytes.as_chunks::<2>().0.iter().flat_map(|&[grey, alpha]| [grey, grey, grey, alpha]).collect()
            }
            _ => bytes,
        };
        Ok(Self::new(frame.width, frame.height, rgba))
    }

    /// Writes an RGBA8 PNG and makes the folders that it needs.
    ///
    /// # Errors
    /// The file system's reason, or a picture without pixels.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), PictureError> {
        let path = path.as_ref();
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder)?;
        }
        let mut encoder = png::Encoder::new(BufWriter::new(File::create(path)?), self.width, self.height);
        encoder.set_color(png::ColorType::Rgba);
        encoder.set_depth(png::BitDepth::Eight);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&self.rgba)?;
        Ok(writer.finish()?)
    }

    /// The pixel in column `x` and row `y`; `None` outside.
    pub fn pixel(&self, x: u32, y: u32) -> Option<[u8; 4]> {
        if x >= self.width || y >= self.height {
            return None;
        }
        let at = (y as usize * self.width as usize + x as usize) * 4;
        self.rgba[at..].first_chunk().copied()
    }

    /// How `actual` differs from this one. Where only one of them has a pixel, it differs by 255.
    pub fn compare(&self, actual: &Self) -> Difference {
        if (self.width, self.height) == (actual.width, actual.height) {
            return compare(&self.rgba, &actual.rgba);
        }
        let mut tally = Tally::default();
        for y in 0..self.height.max(actual.height) {
            for x in 0..self.width.max(actual.width) {
                tally.pixel(self.pixel(x, y), actual.pixel(x, y));
            }
        }
        tally.finish()
    }

    /// This picture, `actual` and their difference side by side on grey. The difference is opaque black
    /// where they are equal; a difference of one shows already.
    pub fn side_by_side(&self, actual: &Self) -> Self {
        const GAP: u32 = 4;
        const GREY: [u8; 4] = [96, 96, 96, 255];
        let (width, height) = (self.width.max(actual.width), self.height.max(actual.height));
        let mut rgba = Vec::with_capacity((width as usize * 3 + 2 * GAP as usize) * height as usize * 4);
        for y in 0..height {
            let row = |picture: &Self, rgba: &mut Vec<u8>| {
                (0..width).for_each(|x| rgba.extend(picture.pixel(x, y).unwrap_or(GREY)));
            };
            row(self, &mut rgba);
            (0..GAP).for_each(|_| rgba.extend(GREY));
            row(actual, &mut rgba);
            (0..GAP).for_each(|_| rgba.extend(GREY));
            (0..width).for_each(|x| rgba.extend(difference_color(self.pixel(x, y), actual.pixel(x, y))));
        }
        Self::new(width * 3 + 2 * GAP, height, rgba)
    }
}

/// Brightens small differences, so that a single pixel that differs by one is visible.
fn difference_color(expected: Option<[u8; 4]>, actual: Option<[u8; 4]>) -> [u8; 4] {
    let lift =
        |difference: u8| if difference == 0 { 0 } else { 64 + (u32::from(difference) * 191 / 255) as u8 };
    match (expected, actual) {
        (Some(a), Some(b)) => {
            let [red, green, blue, alpha] = [0, 1, 2, 3].map(|i| lift(a[i].abs_diff(b[i])));
            // A difference in alpha alone has no colour of its own and is shown white.
            [red.max(alpha), green.max(alpha), blue.max(alpha), 255]
        }
        _ => [255, 0, 255, 255],
    }
}

/// How two pictures differ, over all four channels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Difference {
    /// Pixels compared.
    pub pixels: u64,
    /// Pixels with a channel that differs.
    pub differing: u64,
    /// The largest difference of a channel, 0 to 255.
    pub largest: u8,
    /// Mean of the differences of all channels of all pixels, 0 to 255.
    pub mean: f64,
}

impl Difference {
    /// True if the pictures are the same, byte for byte.
    pub fn is_none(&self) -> bool {
        self.differing == 0
    }
}

impl std::fmt::Display for Difference {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { pixels, differing, largest, mean } = self;
        write!(f, "{differing} of {pixels} pixels differ, by at most {largest}, by {mean:.4} in the mean")
    }
}

/// Compares two RGBA8 pictures of the same size, byte for byte.
///
/// # Panics
/// If the slices differ in length or are not whole pixels.
pub fn compare(expected: &[u8], actual: &[u8]) -> Difference {
    assert_eq!(expected.len(), actual.len(), "pictures of the same size");
    let (expected, expected_rest) = expected.as_chunks::<4>();
    let (actual, _) = actual.as_chunks::<4>();
    assert!(expected_rest.is_empty(), "whole RGBA pixels");
    let mut tally = Tally::default();
    for (a, b) in expected.iter().zip(actual) {
        tally.pixel(Some(*a), Some(*b));
    }
    tally.finish()
}

#[derive(Default)]
struct Tally {
    difference: Difference,
    sum: u64,
}

impl Tally {
    fn pixel(&mut self, expected: Option<[u8; 4]>, actual: Option<[u8; 4]>) {
        self.difference.pixels += 1;
        if expected == actual {
            return;
        }
        self.difference.differing += 1;
        let channels = match (expected, actual) {
            (Some(a), Some(b)) => [0, 1, 2, 3].map(|i| a[i].abs_diff(b[i])),
            _ => [255; 4],
        };
        for channel in channels {
            self.difference.largest = self.difference.largest.max(channel);
            self.sum += u64::from(channel);
        }
    }

    fn finish(self) -> Difference {
        let channels = self.difference.pixels.max(1) * 4;
        Difference { mean: self.sum as f64 / channels as f64, ..self.difference }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gradient(width: u32, height: u32) -> Picture {
        let rgba = (0..width * height).flat_map(|i| [i as u8, (i >> 3) as u8, 7, 255 - i as u8]).collect();
        Picture::new(width, height, rgba)
    }

    #[test]
    fn equal_pictures_do_not_differ() {
        let picture = gradient(7, 5);
        let difference = picture.compare(&picture);
        assert!(difference.is_none());
        assert_eq!(difference, Difference { pixels: 35, ..Difference::default() });
    }

    #[test]
    fn differences_are_counted_by_pixel_and_measured_by_channel() {
        let expected = Picture::new(2, 2, vec![10; 16]);
        let mut actual = expected.clone();
        actual.rgba[0] = 13;
        actual.rgba[1] = 5;
        actual.rgba[15] = 11;
        let difference = expected.compare(&actual);
        let mean = f64::from(3 + 5 + 1) / 16.0;
        assert_eq!(difference, Difference { pixels: 4, differing: 2, largest: 5, mean });
        assert_eq!(difference.to_string(), "2 of 4 pixels differ, by at most 5, by 0.5625 in the mean");
    }

    #[test]
    fn a_pixel_that_only_one_picture_has_differs() {
        let difference = gradient(3, 2).compare(&gradient(3, 4));
        assert_eq!((difference.pixels, difference.differing, difference.largest), (12, 6, 255));
    }

    #[test]
    fn side_by_side_shows_both_and_where_they_differ() {
        let expected = gradient(3, 2);
        let mut actual = expected.clone();
        actual.rgba[4] += 1; // red of the pixel (1, 0)
        let picture = expected.side_by_side(&actual);
        assert_eq!((picture.width, picture.height), (17, 2));
        assert_eq!(picture.pixel(2, 1), expected.pixel(2, 1));
        assert_eq!(picture.pixel(7 + 1, 0), actual.pixel(1, 0));
        assert_eq!(picture.pixel(14, 0), Some([0, 0, 0, 255]));
        assert_eq!(picture.pixel(14 + 1, 0), Some([64, 0, 0, 255]));
        assert_eq!((picture.pixel(17, 0), picture.pixel(0, 2)), (None, None));
    }

    #[test]
    fn a_png_comes_back_as_it_was_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a/b/picture.png");
        let picture = gradient(31, 33);
        picture.write(&path).unwrap();
        assert_eq!(Picture::read(&path).unwrap(), picture);
    }

    #[test]
    fn grey_and_rgb_become_rgba() {
        let folder = tempfile::tempdir().unwrap();
        for (color, bytes) in [(png::ColorType::Grayscale, vec![9]), (png::ColorType::Rgb, vec![9, 9, 9])] {
            let path = folder.path().join("picture.png");
            let mut encoder = png::Encoder::new(File::create(&path).unwrap(), 1, 1);
            encoder.set_color(color);
            encoder.write_header().unwrap().write_image_data(&bytes).unwrap();
            assert_eq!(Picture::read(&path).unwrap(), Picture::new(1, 1, vec![9, 9, 9, 255]), "{color:?}");
        }
    }

    #[test]
    fn what_is_no_png_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.png");
        assert!(matches!(Picture::read(&path), Err(PictureError::Io(_))));
        fs::write(&path, b"not a picture").unwrap();
        assert!(matches!(Picture::read(&path), Err(PictureError::Decode(_))));
    }
}
