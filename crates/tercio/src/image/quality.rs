//! How alike two pictures look: PSNR and SSIM.

use tercio_mesh::loops::prelude::*;

use super::{ImageError, Picture, Pixels};

/// Pixels along the edge of a window of SSIM.
const WINDOW: usize = 11;
/// Standard deviation of the window's Gaussian, pixels.
const SIGMA: f64 = 1.5;

/// How alike two pictures look.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Similarity {
    /// Peak signal-to-noise ratio in dB over red, green, blue and alpha (if a picture has translucent pixels), for a peak of
    /// 255; infinite for equal pictures.
    pub psnr: f64,
    /// Mean structural similarity of the luma (BT.709) of what is seen on black; 1 for equal pictures. `None` for pictures
    /// smaller than a window of 11 x 11 pixels.
    pub ssim: Option<f64>,
}

/// Computes how alike two pictures look. SSIM has the window (Gaussian, 11 x 11 pixels, standard deviation 1.5) and the constants
/// (0.01, 0.03) of Wang, Bovik, Sheikh and Simoncelli, "Image quality assessment: from error visibility to structural
/// similarity", IEEE Transactions on Image Processing 13 (2004), over all windows that are inside the picture.
///
/// # Errors
/// [`ImageError::SizesDiffer`].
pub fn similarity(a: &Picture, b: &Picture) -> Result<Similarity, ImageError> {
    if (a.width, a.height) != (b.width, b.height) {
        return Err(ImageError::SizesDiffer([a.width, a.height], [b.width, b.height]));
    }
    let (values_a, values_b) = (values(a), values(b));
    let channels = if a.is_opaque() && b.is_opaque() { 3 } else { 4 };
    // Rows, so that the order of the sum is always the same.
    let width = (a.width as usize).max(1);
    let rows: Vec<f64> = values_a
        .par_chunks(width)
        .zip(values_b.par_chunks(width))
        .map(|(a, b)| {
            let squares =
                a.iter().zip(b).flat_map(|(a, b)| (0..channels).map(|k| f64::from(a[k] - b[k]).powi(2)));
            squares.sum()
        })
        .collect();
    let mean = rows.iter().sum::<f64>() / (values_a.len().max(1) * channels) as f64;
    let psnr = if mean > 0.0 { 10.0 * (255.0 * 255.0 / mean).log10() } else { f64::INFINITY };
    let lumas = [luma(&values_a), luma(&values_b)];
    let ssim = mean_ssim(&lumas[0], &lumas[1], width, a.height as usize);
    Ok(Similarity { psnr, ssim })
}

/// In steps of 8 bits.
fn values(picture: &Picture) -> Vec<[f32; 4]> {
    match &picture.pixels {
        Pixels::Eight(pixels) => pixels.par_iter().map(|p| p.map(f32::from)).collect(),
        Pixels::Sixteen(pixels) => pixels.par_iter().map(|p| p.map(|v| f32::from(v) / 257.0)).collect(),
    }
}

fn luma(values: &[[f32; 4]]) -> Vec<f32> {
    let of_pixel = |&[r, g, b, a]: &[f32; 4]| (0.2126 * r + 0.7152 * g + 0.0722 * b) * (a / 255.0);
    values.par_iter().map(of_pixel).collect()
}

fn mean_ssim(a: &[f32], b: &[f32], width: usize, height: usize) -> Option<f64> {
    if width < WINDOW || height < WINDOW {
        return None;
    }
    let weights = weights();
    let (columns, rows) = (width - WINDOW + 1, height - WINDOW + 1);
    let of_row = |y: usize| -> f64 {
        // Weighted down the columns first.
        let moments: Vec<[f64; 5]> = (0..width)
            .map(|x| {
                let mut sums = [0.0; 5];
                for (k, weight) in weights.iter().enumerate() {
                    let place = (y + k) * width + x;
                    let (a, b) = (f64::from(a[place]), f64::from(b[place]));
                    let terms = [a, b, a * a, b * b, a * b];
                    sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += weight * term);
                }
                sums
            })
            .collect();
        let of_window = |x: usize| {
            let mut sums = [0.0; 5];
            for (weight, column) in weights.iter().zip(&moments[x..]) {
                sums.iter_mut().zip(column).for_each(|(sum, term)| *sum += weight * term);
            }
            index(sums)
        };
        (0..columns).map(of_window).sum()
    };
    let rows_of: Vec<f64> = (0..rows).into_par_iter().map(of_row).collect();
    Some(rows_of.iter().sum::<f64>() / (columns * rows) as f64)
}

/// The index of a window, from its weighted means of a, b, their squares and their product.
fn index([a, b, aa, bb, ab]: [f64; 5]) -> f64 {
    const C1: f64 = (0.01 * 255.0) * (0.01 * 255.0);
    const C2: f64 = (0.03 * 255.0) * (0.03 * 255.0);
    let (variances, covariance) = (aa - a * a + bb - b * b, ab - a * b);
    ((2.0 * a * b + C1) * (2.0 * covariance + C2)) / ((a * a + b * b + C1) * (variances + C2))
}

fn weights() -> [f64; WINDOW] {
    let middle = (WINDOW / 2) as f64;
    let plain: [f64; WINDOW] =
        std::array::from_fn(|k| (-(k as f64 - middle).powi(2) / (2.0 * SIGMA * SIGMA)).exp());
    let sum: f64 = plain.iter().sum();
    plain.map(|weight| weight / sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(width: u32, height: u32, pixel: impl Fn(u32, u32) -> u8) -> Picture<'static> {
        let grey = |i: u32| {
            let v = pixel(i % width, i / width);
            [v, v, v, 255]
        };
        Picture {
            width,
            height,
            pixels: Pixels::Eight((0..width * height).map(grey).collect::<Vec<_>>().into()),
        }
    }

    #[test]
    fn equal_pictures_are_as_alike_as_can_be() {
        let a = picture(20, 15, |x, y| (x * 11 + y * 7) as u8);
        let found = similarity(&a, &a).unwrap();
        assert_eq!(found.psnr, f64::INFINITY);
        assert!((found.ssim.unwrap() - 1.0).abs() < 1e-12);
        assert_eq!(similarity(&picture(10, 99, |_, _| 0), &picture(10, 99, |_, _| 9)).unwrap().ssim, None);
        assert!(similarity(&a, &picture(15, 20, |_, _| 0)).is_err());
    }

    #[test]
    fn flat_pictures_follow_closed_formulas() {
        let (a, b) = (picture(16, 16, |_, _| 100), picture(16, 16, |_, _| 110));
        let found = similarity(&a, &b).unwrap();
        assert!((found.psnr - 20.0 * 25.5f64.log10()).abs() < 1e-9, "{found:?}");
        let c = 2.55f64 * 2.55;
        let expected = (2.0 * 100.0 * 110.0 + c) / (100.0 * 100.0 + 110.0 * 110.0 + c);
        assert!((found.ssim.unwrap() - expected).abs() < 1e-6, "{found:?} {expected}");
    }

    #[test]
    fn ssim_is_that_of_the_definition() {
        let (a, b) = (
            picture(23, 17, |x, y| (x * x * 3 + y * 29) as u8),
            picture(23, 17, |x, y| (x * x * 3 + y * 29 + (x ^ y) * 5) as u8),
        );
        // Window by window with two-dimensional weights, deviations from the mean, and no common sums.
        let value = |p: &Picture, x: usize, y: usize| match &p.pixels {
            Pixels::Eight(pixels) => f64::from(pixels[y * 23 + x][0]),
            Pixels::Sixteen(_) => unreachable!("8 bits"),
        };
        let gauss = |k: usize| (-(k as f64 - 5.0).powi(2) / 4.5).exp();
        let all: f64 = (0..121).map(|i| gauss(i % 11) * gauss(i / 11)).sum();
        let mut total = 0.0;
        for (x0, y0) in (0..13 * 7).map(|i| (i % 13, i / 13)) {
            let mean = |f: &dyn Fn(usize, usize) -> f64| -> f64 {
                (0..121).map(|i| gauss(i % 11) * gauss(i / 11) / all * f(x0 + i % 11, y0 + i / 11)).sum()
            };
            let (ma, mb) = (mean(&|x, y| value(&a, x, y)), mean(&|x, y| value(&b, x, y)));
            let va = mean(&|x, y| (value(&a, x, y) - ma).powi(2));
            let vb = mean(&|x, y| (value(&b, x, y) - mb).powi(2));
            let cov = mean(&|x, y| (value(&a, x, y) - ma) * (value(&b, x, y) - mb));
            let (c1, c2) = (6.5025, 58.5225);
            total += (2.0 * ma * mb + c1) * (2.0 * cov + c2) / ((ma * ma + mb * mb + c1) * (va + vb + c2));
        }
        let found = similarity(&a, &b).unwrap().ssim.unwrap();
        assert!((found - total / 91.0).abs() < 1e-4, "{found} {}", total / 91.0);
    }
}
