//! Which outputs of an interrupted series are there and whole.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;
use std::time::SystemTime;

use tercio::image::{Destination, PictureFormat};
use tercio::vector::VectorFormat;

use crate::output::{Array, Plan, modified};

/// Whether all outputs of a picture are there, are of this size, end as such files end, and are not older than an input. Files
/// appear only when they are whole; this finds those of another command or of other models, or that something else has cut.
pub fn is_there(plan: &Plan, size: (u32, u32), newest_input: Option<SystemTime>) -> bool {
    let pictures = plan.picture.iter().flat_map(|(files, format)| files.iter().map(move |f| (f, *format)));
    let arrays = plan.arrays.iter().flat_map(|(files, array)| files.iter().map(move |f| (f, *array)));
    let of_file = |destination: &Destination, check: &dyn Fn(&Path) -> Option<bool>| match destination {
        Destination::Stdout => false,
        // Where the file system has no times, none is older.
        Destination::File(path) => {
            check(path).unwrap_or(false) && modified(path).is_none_or(|time| Some(time) >= newest_input)
        }
    };
    let drawing = plan.drawing.as_ref();
    drawing.is_none_or(|(file, format)| of_file(file, &|path| is_drawing(path, *format, size)))
        && pictures.into_iter().all(|(file, format)| of_file(file, &|path| is_picture(path, format, size)))
        && arrays.into_iter().all(|(file, array)| of_file(file, &|path| is_array(path, array, size)))
}

fn is_picture(path: &Path, format: PictureFormat, (width, height): (u32, u32)) -> Option<bool> {
    let mut file = File::open(path).ok()?;
    let length = file.metadata().ok()?.len();
    let mut head = [0; 33];
    Some(match format {
        PictureFormat::Png => {
            file.read_exact(&mut head).ok()?;
            let mut tail = [0; 12];
            file.seek(SeekFrom::End(-12)).ok()?;
            file.read_exact(&mut tail).ok()?;
            let number = |at: usize| u32::from_be_bytes([head[at], head[at + 1], head[at + 2], head[at + 3]]);
            head.starts_with(b"\x89PNG\r\n\x1a\n")
                && (number(16), number(20)) == (width, height)
                && tail == *b"\0\0\0\0IEND\xaeB`\x82"
        }
        PictureFormat::Ppm => {
            let start = |most: u32| format!("P6\n{width} {height}\n{most}\n").into_bytes();
            let pixels = u64::from(width) * u64::from(height) * 3;
            let mut head = Vec::new();
            file.take(33).read_to_end(&mut head).ok()?;
            [(start(255), pixels), (start(65535), pixels * 2)]
                .iter()
                .any(|(start, bytes)| head.starts_with(start) && length == start.len() as u64 + bytes)
        }
        PictureFormat::Jpeg { .. } => {
            let mut bytes = Vec::new();
            // The size is in the head, after the tables that the encoder writes before it.
            (&file).take(4096).read_to_end(&mut bytes).ok()?;
            let frame = bytes.windows(4).position(|w| w == [0xff, 0xc0, 0, 17])?;
            let number =
                |at: usize| Some(u32::from(u16::from_be_bytes([*bytes.get(at)?, *bytes.get(at + 1)?])));
            let mut tail = [0; 2];
            file.seek(SeekFrom::End(-2)).ok()?;
            file.read_exact(&mut tail).ok()?;
            bytes.starts_with(&[0xff, 0xd8])
                && (number(frame + 7)?, number(frame + 5)?) == (width, height)
                && tail == [0xff, 0xd9]
        }
        _ => {
            // WebP: its size is not where all variants have it; its length is.
            file.read_exact(&mut head[..12]).ok()?;
            let riff = u64::from(u32::from_le_bytes([head[4], head[5], head[6], head[7]]));
            head.starts_with(b"RIFF") && head[8..12] == *b"WEBP" && length == riff + 8
        }
    })
}

fn is_drawing(path: &Path, format: VectorFormat, (width, height): (u32, u32)) -> Option<bool> {
    let mut file = File::open(path).ok()?;
    let mut head = Vec::new();
    Read::by_ref(&mut file).take(400).read_to_end(&mut head).ok()?;
    file.seek(SeekFrom::End(-7)).ok()?;
    let mut tail = Vec::new();
    file.read_to_end(&mut tail).ok()?;
    Some(match format {
        VectorFormat::Svg => {
            let size = format!("width=\"{width}\" height=\"{height}\"");
            tail == b"</svg>\n" && String::from_utf8_lossy(&head).contains(&size)
        }
        VectorFormat::Pdf => {
            // 72 points an inch, of 96 pixels.
            let [width, height] = [width, height].map(|pixels| f64::from(pixels) * 0.75);
            let size = format!("/MediaBox [0 0 {width} {height}]");
            head.starts_with(b"%PDF-")
                && String::from_utf8_lossy(&head).contains(&size)
                && tail.trim_ascii_end().ends_with(b"%%EOF")
        }
    })
}

fn is_array(path: &Path, array: Array, (width, height): (u32, u32)) -> Option<bool> {
    let mut file = File::open(path).ok()?;
    let length = file.metadata().ok()?.len();
    let mut head = [0; 10];
    file.read_exact(&mut head).ok()?;
    let values = if matches!(array, Array::Normals) { 3 } else { 1 };
    let bytes = u64::from(width) * u64::from(height) * values * 4;
    let header = 10 + u64::from(u16::from_le_bytes([head[8], head[9]]));
    Some(head.starts_with(b"\x93NUMPY\x01\x00") && length == header + bytes)
}
