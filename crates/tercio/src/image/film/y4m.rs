//! YUV4MPEG2, written by hand: a line of text, and planes of bytes.

use std::io::Write;

use tercio_mesh::loops::prelude::*;

use super::Film;
use crate::image::{ImageError, Picture, Pixels};

/// Bits behind the point of the coefficients.
const BITS: u32 = 16;

/// Luma and chroma of BT.709 from R'G'B', for 16 to 235 (luma) and 16 to 240 (chroma), times 2^16.
const ROWS: [[f64; 3]; 3] = {
    const KR: f64 = 0.2126;
    const KB: f64 = 0.0722;
    const KG: f64 = 1.0 - KR - KB;
    const CB: f64 = 0.5 / (1.0 - KB);
    const CR: f64 = 0.5 / (1.0 - KR);
    [[KR, KG, KB], [-KR * CB, -KG * CB, 0.5], [0.5, -KG * CR, -KB * CR]]
};

/// Range and zero of each plane.
const RANGES: [(f64, i32); 3] = [(219.0, 16), (224.0, 128), (224.0, 128)];

pub(super) fn begin<W: Write>(film: &Film, mut out: W) -> Result<W, ImageError> {
    let Film { width, height, rate, .. } = film;
    // Progressive, square pixels.
    writeln!(
        out,
        "YUV4MPEG2 W{width} H{height} F{}:{} Ip A1:1 C444 XCOLORRANGE=LIMITED",
        rate.pictures, rate.seconds
    )?;
    Ok(out)
}

/// The three planes, one after the other.
pub(super) fn encode(picture: &Picture) -> Vec<u8> {
    let Pixels::Eight(pixels) = &picture.pixels else { return Vec::new() };
    let mut bytes = vec![0; pixels.len() * 3];
    let one = f64::from(1u32 << BITS);
    for (plane, (row, (range, zero))) in
        bytes.chunks_exact_mut(pixels.len().max(1)).zip(ROWS.into_iter().zip(RANGES))
    {
        let [r, g, b] = row.map(|k| (k * range / 255.0 * one).round() as i32);
        let add = (zero << BITS) + (1 << (BITS - 1));
        plane.par_chunks_mut(1 << 16).zip(pixels.par_chunks(1 << 16)).for_each(|(plane, pixels)| {
            for (value, p) in plane.iter_mut().zip(pixels) {
                let [red, green, blue] = [p[0], p[1], p[2]].map(i32::from);
                // Between 16 and 240 for all colours.
                *value = ((r * red + g * green + b * blue + add) >> BITS) as u8;
            }
        });
    }
    bytes
}

pub(super) fn append<W: Write>(out: &mut W, planes: &[u8]) -> Result<(), ImageError> {
    out.write_all(b"FRAME\n")?;
    Ok(out.write_all(planes)?)
}
