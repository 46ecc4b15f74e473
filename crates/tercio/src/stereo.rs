//! Stereo pictures: the frames of two eyes become one frame.
//!
//! [`Stereo`](tercio_scene::Stereo) makes the cameras of the two eyes. Each function takes the finished frames of the
//! left and the right eye, of the same size, and returns one with the counts and times of both.

use tercio_mesh::loops::prelude::*;
use tercio_raster::Frame;
use tercio_raster::color::{DECODE, encode8, encode16};
use tercio_raster::frame::Planes;
use tercio_scene::srgb_to_linear;

use crate::image::ImageError;

/// The left eye's picture on the left, the right eye's on the right: twice as wide, with all planes that both frames
/// have.
///
/// # Errors
/// [`ImageError::SizesDiffer`].
pub fn side_by_side(left: &Frame, right: &Frame) -> Result<Frame, ImageError> {
    let width = left.width as usize;
    Ok(Frame { width: left.width.saturating_mul(2), ..joined(left, right, width)? })
}

/// The left eye's picture above the right eye's: twice as high, with all planes that both frames have.
///
/// # Errors
/// [`ImageError::SizesDiffer`].
pub fn over_under(left: &Frame, right: &Frame) -> Result<Frame, ImageError> {
    let pixels = left.width as usize * left.height as usize;
    Ok(Frame { height: left.height.saturating_mul(2), ..joined(left, right, pixels)? })
}

/// The picture for glasses with a red filter before the left eye and a cyan one before the right eye. It has colours
/// only: the other planes of two eyes do not make one.
///
/// Each colour is the least-squares projection of Dubois: of all colours of a display, the one whose light, seen
/// through the two filters, is nearest to the colours that the two eyes should see. Against the red of one eye beside
/// the green and blue of the other, both eyes see the same brightness, even of a strongly coloured surface, and less of
/// each other's picture. The grey of a scan stays grey where both eyes see the same. The
/// projection is computed in linear light, and colours outside the display's range are clamped, as the author does. The
/// coefficients are those that he published for the filters of common glasses.
///
/// Alpha is the larger one of both, and what is transparent counts as black: glasses cannot separate two pictures that
/// are laid over a bright page, so an opaque background is better.
///
/// Source: E. Dubois, "A projection method to generate anaglyph stereo images", Proc. IEEE Int. Conf. Acoustics, Speech
/// and Signal Processing, vol. 3, pp. 1661-1664 (2001), and "Conversion of a stereo pair to anaglyph with the
/// least-squares projection method" (2009).
///
/// # Errors
/// [`ImageError::SizesDiffer`].
pub fn anaglyph(left: &Frame, right: &Frame) -> Result<Frame, ImageError> {
    check_sizes(left, right)?;
    let linear16 = |level: u16| srgb_to_linear(f64::from(level) / 65535.0) as f32;
    let planes = Planes {
        color: both(&left.planes.color, &right.planes.color, |eyes| {
            let alpha = eyes[0][3].max(eyes[1][3]);
            let shares = eyes.map(|[.., own]| f32::from(own) / f32::from(alpha.max(1)));
            let linear = eyes.map(|[r, g, b, _]| [r, g, b].map(|level| DECODE[usize::from(level)]));
            let [r, g, b] = projection(linear, shares).map(encode8);
            [r, g, b, alpha]
        }),
        color16: both(&left.planes.color16, &right.planes.color16, |eyes| {
            let alpha = eyes[0][3].max(eyes[1][3]);
            let shares = eyes.map(|[.., own]| f32::from(own) / f32::from(alpha.max(1)));
            let linear = eyes.map(|[r, g, b, _]| [r, g, b].map(linear16));
            let [r, g, b] = projection(linear, shares).map(encode16);
            [r, g, b, alpha]
        }),
        ..Planes::default()
    };
    Ok(Frame {
        width: left.width,
        height: left.height,
        planes,
        stats: left.stats.plus(&right.stats),
        ..Frame::default()
    })
}

/// Dubois' matrices for red and cyan filters, of the left and the right eye: red, green and blue of the anaglyph from
/// red, green and blue of a picture. The rows of both together add up to 1, so that white stays white.
const PROJECTION: [[[f32; 3]; 3]; 2] = [
    [
        [0.456_100, 0.500_484, 0.176_381],
        [-0.040_082_2, -0.037_824_6, -0.015_758_9],
        [-0.015_216_1, -0.020_597_1, -0.005_468_56],
    ],
    [
        [-0.043_470_6, -0.087_938_8, -0.001_555_29],
        [0.378_476, 0.733_64, -0.018_450_3],
        [-0.072_152_7, -0.112_961, 1.226_4],
    ],
];

/// The anaglyph of the linear colours that two eyes see, each of which counts with its share. Not clamped.
fn projection(eyes: [[f32; 3]; 2], shares: [f32; 2]) -> [f32; 3] {
    std::array::from_fn(|to| {
        let [left, right] = [0, 1].map(|eye| {
            let (row, color) = (PROJECTION[eye][to], eyes[eye]);
            ((row[0] * color[0] + row[1] * color[1]) + row[2] * color[2]) * shares[eye]
        });
        left + right
    })
}

fn check_sizes(left: &Frame, right: &Frame) -> Result<(), ImageError> {
    let [a, b] = [left, right].map(|frame| [frame.width, frame.height]);
    if a == b { Ok(()) } else { Err(ImageError::SizesDiffer(a, b)) }
}

/// A plane made from two, pixel by pixel; empty if a frame does not have it.
fn both<T: Copy + Send + Sync>(left: &[T], right: &[T], of: impl Fn([T; 2]) -> T + Sync) -> Vec<T> {
    left.par_iter().zip(right).with_min_len(1 << 12).map(|(&left, &right)| of([left, right])).collect()
}

/// All planes of two frames: in turn as many pixels of the left one, and as many of the right one.
fn joined(left: &Frame, right: &Frame, in_turn: usize) -> Result<Frame, ImageError> {
    check_sizes(left, right)?;
    let planes = left.planes.in_turn(&right.planes, in_turn);
    Ok(Frame {
        width: left.width,
        height: left.height,
        planes,
        stats: left.stats.plus(&right.stats),
        ..Frame::default()
    })
}

#[cfg(test)]
mod tests;
