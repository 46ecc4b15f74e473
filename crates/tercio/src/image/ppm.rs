//! Portable pixmap, P6. Source: the `ppm(5)` page of Netpbm.

use std::io::Write;

use super::png::{opaque_samples, rgba};
use super::{ImageError, Picture, PictureFormat, Pixels};

pub(super) fn write(picture: &Picture, out: &mut dyn Write) -> Result<(), ImageError> {
    let Some(samples) = opaque_samples(picture) else {
        return Err(ImageError::CannotHold { format: PictureFormat::Ppm, what: "transparency" });
    };
    let largest = match picture.pixels {
        Pixels::Eight(_) => u16::from(u8::MAX),
        Pixels::Sixteen(_) => u16::MAX,
    };
    write!(out, "P6\n{} {}\n{largest}\n", picture.width, picture.height)?;
    Ok(out.write_all(&samples)?)
}

fn malformed(reason: &str) -> ImageError {
    ImageError::Malformed { format: PictureFormat::Ppm, reason: reason.to_owned() }
}

pub(super) fn read(bytes: &[u8]) -> Result<Picture<'static>, ImageError> {
    let mut at = 2;
    let mut numbers = [0u32; 3];
    for number in &mut numbers {
        *number =
            header_number(bytes, &mut at).ok_or_else(|| malformed("expected a number in the header"))?;
    }
    let [width, height, largest] = numbers;
    if largest != 255 && largest != 65535 {
        return Err(malformed(&format!("expected 255 or 65535 as the largest value, found {largest}")));
    }
    // There is one white space byte between the header and the samples.
    let content = bytes.get(at + 1..).unwrap_or_default();
    let width_of_sample = if largest == 255 { 1 } else { 2 };
    let expected = Picture::pixel_count(width, height).and_then(|n| n.checked_mul(3 * width_of_sample));
    let content = expected
        .and_then(|n| content.get(..n))
        .ok_or_else(|| malformed(&format!("{width}x{height} pixels are more than the file holds")))?;
    let pixels = if largest == 255 {
        Pixels::Eight(rgba(content, 3, u8::MAX).into())
    } else {
        let values: Vec<u16> = content.as_chunks().0.iter().map(|&b| u16::from_be_bytes(b)).collect();
        Pixels::Sixteen(rgba(&values, 3, u16::MAX).into())
    };
    Ok(Picture { width, height, pixels })
}

/// The next number of the header; comments run from # to the end of the line.
fn header_number(bytes: &[u8], at: &mut usize) -> Option<u32> {
    loop {
        match bytes.get(*at)? {
            b'#' => *at += bytes[*at..].iter().position(|&b| b == b'\n')?,
            b if b.is_ascii_whitespace() => *at += 1,
            _ => break,
        }
    }
    let digits = bytes[*at..].iter().take_while(|b| b.is_ascii_digit()).count();
    let text = std::str::from_utf8(&bytes[*at..*at + digits]).ok()?;
    *at += digits;
    text.parse().ok()
}
