//! Two pictures and their difference side by side.

use tercio_scene::srgb_to_linear;
use tercio_testkit::Picture;

use super::level;

/// Factor of the difference that is shown.
const LIFT: u8 = 16;
/// Pixels between the pictures.
const GAP: u32 = 8;

/// tercio's picture, the ray tracer's, and 16 times their difference on black.
pub fn side_by_side(ours: &Picture, theirs: &Picture) -> Picture {
    let (width, height) = (ours.width, ours.height);
    let mut rgba = Vec::new();
    for y in 0..height {
        for x in 0..width * 3 + GAP * 2 {
            let (part, x) = (x / (width + GAP), x % (width + GAP));
            let pixel = match (part, ours.pixel(x, y), theirs.pixel(x, y)) {
                (0, Some(a), _) => a,
                (1, _, Some(b)) => b,
                (_, Some(a), Some(b)) => {
                    let [r, g, b] = [0, 1, 2].map(|k| a[k].abs_diff(b[k]).saturating_mul(LIFT));
                    [r, g, b, 255]
                }
                _ => [255; 4],
            };
            rgba.extend(pixel);
        }
    }
    Picture::new(width * 3 + GAP * 2, height, rgba)
}

/// A picture with half the pixels in a row and half the rows: the means of 2 x 2 pixels in linear light.
pub fn halved(picture: &Picture) -> Picture {
    let (width, height) = (picture.width / 2, picture.height / 2);
    let mut rgba = Vec::new();
    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x * 2, y * 2))) {
        let four = [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)];
        let four = four.map(|(x, y)| picture.pixel(x, y).unwrap_or_default());
        let mean =
            |k: usize| four.iter().map(|p| srgb_to_linear(f64::from(p[k]) / 255.0)).sum::<f64>() * 0.25;
        rgba.extend([0, 1, 2].map(|k| level(mean(k))));
        rgba.push(255);
    }
    Picture::new(width, height, rgba)
}
