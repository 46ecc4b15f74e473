//! The differences between two pictures.

use tercio_mesh::loops::prelude::*;

use super::{ImageError, Picture, Pixels};

/// The differences between two pictures of the same size, in units of 8-bit components, 0 to 255, also between 16-bit
/// pictures, where they may be fractions. Channels are red, green, blue, alpha; a picture without alpha is opaque.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Difference {
    /// Number of pixels.
    pub pixels: u64,
    /// Number of pixels that differ in any channel.
    pub differing: u64,
    /// The largest difference of each channel.
    pub largest: [f64; 4],
    /// The mean difference of each channel over all pixels.
    pub mean: [f64; 4],
}

impl Difference {
    /// The largest difference of any channel.
    pub fn largest_of_all(&self) -> f64 {
        self.largest.into_iter().fold(0.0, f64::max)
    }

    /// The mean over all pixels and channels.
    pub fn mean_of_all(&self) -> f64 {
        self.mean.iter().sum::<f64>() / 4.0
    }
}

/// 8-bit components are scaled to 16 bits so that 255 becomes 65535.
const STEP: u16 = 257;

/// Compares two pictures and makes a third that shows where they differ: black where they are equal, white (in a
/// channel) where they differ most. A difference in alpha alone appears as grey.
///
/// # Errors
/// [`ImageError::SizesDiffer`].
pub fn compare(a: &Picture, b: &Picture) -> Result<(Difference, Picture<'static>), ImageError> {
    if (a.width, a.height) != (b.width, b.height) {
        return Err(ImageError::SizesDiffer([a.width, a.height], [b.width, b.height]));
    }
    let (wide_a, wide_b) = (sixteen(a), sixteen(b));
    let differences: Vec<[u16; 4]> =
        wide_a.par_iter().zip(&*wide_b).map(|(a, b)| std::array::from_fn(|k| a[k].abs_diff(b[k]))).collect();
    // Integers, so that the sums do not depend on the order in which threads add.
    let none = (0u64, [0u16; 4], [0u64; 4]);
    let (differing, largest, sum) = differences
        .par_iter()
        .fold(
            || none,
            |(n, largest, sum), d| {
                let any = u64::from(*d != [0; 4]);
                let add = |k: usize| sum[k] + u64::from(d[k]);
                (n + any, std::array::from_fn(|k| largest[k].max(d[k])), std::array::from_fn(add))
            },
        )
        .reduce(
            || none,
            |a, b| {
                (
                    a.0 + b.0,
                    std::array::from_fn(|k| a.1[k].max(b.1[k])),
                    std::array::from_fn(|k| a.2[k] + b.2[k]),
                )
            },
        );
    let scale = f64::from(STEP);
    let difference = Difference {
        pixels: differences.len() as u64,
        differing,
        largest: largest.map(|v| f64::from(v) / scale),
        mean: sum.map(|v| v as f64 / scale / differences.len().max(1) as f64),
    };
    let white = largest.into_iter().max().unwrap_or(0).max(1);
    let shown = |v: u16| (u32::from(v) * 255).div_ceil(u32::from(white)) as u8;
    let pixels: Vec<[u8; 4]> = differences
        .par_iter()
        .map(|&[r, g, b, a]| [r.max(a), g.max(a), b.max(a)].map(shown))
        .map(opaque)
        .collect();
    Ok((difference, Picture { width: a.width, height: a.height, pixels: Pixels::Eight(pixels.into()) }))
}

fn opaque([r, g, b]: [u8; 3]) -> [u8; 4] {
    [r, g, b, u8::MAX]
}

fn sixteen<'a>(picture: &'a Picture) -> std::borrow::Cow<'a, [[u16; 4]]> {
    match &picture.pixels {
        Pixels::Sixteen(p) => std::borrow::Cow::Borrowed(p),
        Pixels::Eight(p) => p.par_iter().map(|p| p.map(|v| u16::from(v) * STEP)).collect::<Vec<_>>().into(),
    }
}
