//! Pictures of all directions.

use glam::DVec3;
use tercio_mesh::trig::sin_cos;

/// A picture of all directions, in linear light: equirectangular, longitude across and latitude down, twice as wide as
/// high. Its own axes are x to the right, y upwards and z towards the viewer; its middle lies in the direction of -z, what
/// is right of the middle towards +x, its upper border is +y.
#[derive(Clone, Debug, PartialEq)]
pub struct Panorama {
    height: usize,
    /// Row by row, the upper left one first.
    pixels: Vec<[f32; 3]>,
}

/// Why a panorama cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PanoramaError {
    /// It has another shape.
    #[error("expected a panorama twice as wide as high, found {width}x{height} pixels")]
    Shape {
        /// Pixels in a row.
        width: usize,
        /// Rows.
        height: usize,
    },
    /// A pixel has no light that can be reflected.
    #[error("the pixel in column {x} of row {y} (from 0) has the light {value}, expected 0 to 1e6")]
    Light {
        /// The pixel's column.
        x: usize,
        /// The pixel's row.
        y: usize,
        /// Its first value that is out of range.
        value: f32,
    },
    /// It is to be too strong.
    #[error(
        "the strength of an environment must be 0 or above, and its light at most 1e6; is {strength}, with light up to {brightest}"
    )]
    Strength {
        /// The strength.
        strength: f64,
        /// The largest value times the strength.
        brightest: f64,
    },
}

/// The largest radius of a source of light that is taken out, degrees.
const SOURCE_DEGREES: f64 = 6.0;

/// Larger panoramas are averaged to this many rows.
const MOST_ROWS: usize = 1024;

impl Panorama {
    /// A panorama of these pixels, row by row. One of more than 1024 rows is made smaller, by halves.
    ///
    /// # Errors
    /// [`PanoramaError`] for another shape, and for light below 0, above 1e6, or NaN.
    ///
    /// # Panics
    /// If there are not `width * height` pixels.
    pub fn new(width: usize, height: usize, pixels: Vec<[f32; 3]>) -> Result<Self, PanoramaError> {
        assert_eq!(pixels.len(), width * height, "a colour for each pixel");
        if height == 0 || width != 2 * height {
            return Err(PanoramaError::Shape { width, height });
        }
        let is_wrong = |v: &f32| !(0.0..=1e6).contains(v);
        if let Some(index) = pixels.iter().position(|p| p.iter().any(is_wrong)) {
            let value = pixels[index].into_iter().find(is_wrong).unwrap_or(f32::NAN);
            return Err(PanoramaError::Light { x: index % width, y: index / width, value });
        }
        let mut panorama = Self { height, pixels };
        while panorama.height > MOST_ROWS {
            panorama = panorama.halved();
        }
        Ok(panorama)
    }

    /// A panorama of three colours, linear RGB: from the zenith to the horizon, and on to the ground, in proportion to the
    /// sine of the elevation.
    ///
    /// # Errors
    /// [`PanoramaError::Light`] for colours out of range.
    pub fn gradient(zenith: [f32; 3], horizon: [f32; 3], ground: [f32; 3]) -> Result<Self, PanoramaError> {
        const ROWS: usize = 64;
        let row = |y: usize| {
            let up = elevation(y, ROWS).0 as f32;
            let end = if up > 0.0 { zenith } else { ground };
            let color: [f32; 3] = std::array::from_fn(|k| horizon[k] + (end[k] - horizon[k]) * up.abs());
            std::iter::repeat_n(color, 2 * ROWS)
        };
        Self::new(2 * ROWS, ROWS, (0..ROWS).flat_map(row).collect())
    }

    /// Rows; half the columns.
    pub fn height(&self) -> usize {
        self.height
    }

    /// The largest value.
    pub fn brightest(&self) -> f64 {
        self.pixels.iter().flatten().fold(0.0, |most, &v| most.max(f64::from(v)))
    }

    pub(super) fn scaled(&self, strength: f64) -> Self {
        let scaled = |p: &[f32; 3]| p.map(|v| (f64::from(v) * strength) as f32);
        Self { height: self.height, pixels: self.pixels.iter().map(scaled).collect() }
    }

    /// Half as many rows and columns: means of four pixels, by the solid angle of their rows. The last row of an odd number
    /// is joined to those above.
    pub(super) fn halved(&self) -> Self {
        let (width, height) = (2 * self.height, self.height / 2);
        let mut pixels = Vec::with_capacity(2 * height * height);
        for y in 0..height {
            let last = if y + 1 == height { self.height } else { 2 * y + 2 };
            let rows: Vec<(usize, f64)> = (2 * y..last).map(|y| (y, elevation(y, self.height).1)).collect();
            let total: f64 = rows.iter().map(|(_, weight)| weight).sum();
            for x in 0..2 * height {
                let columns = 2 * x..if x + 1 == 2 * height { width } else { 2 * x + 2 };
                let share = 1.0 / (total * columns.len() as f64);
                let sum = |k: usize| {
                    let of_row = |&(y, weight): &(usize, f64)| {
                        let row = &self.pixels[y * width..][columns.clone()];
                        weight * row.iter().map(|p| f64::from(p[k])).sum::<f64>()
                    };
                    rows.iter().map(of_row).sum::<f64>()
                };
                pixels.push([0, 1, 2].map(|k| (sum(k) * share) as f32));
            }
        }
        Self { height, pixels }
    }

    /// Takes a small, very bright source of light out of the panorama, such as the sun: its direction in the panorama's axes,
    /// and the integral of its light over the solid angle. What is left in its place is as bright as what is around it.
    /// `None` if there is none whose light is at least a hundredth of all.
    pub(super) fn take_source(&mut self) -> Option<(DVec3, [f64; 3])> {
        let brightness = |color: [f32; 3]| color.map(f64::from).iter().sum::<f64>();
        let (mut all, mut brightest, mut middle) = (0.0, 0.0, DVec3::ZERO);
        self.for_each(|direction, solid_angle, color| {
            all += brightness(color) * solid_angle;
            if brightness(color) > brightest {
                (brightest, middle) = (brightness(color), direction);
            }
        });
        // The mean around it, outside of the cone that it may fill.
        let cone = |degrees: f64| sin_cos(degrees.to_radians()).1;
        let (inner, outer) = (cone(SOURCE_DEGREES), cone(2.0 * SOURCE_DEGREES + 180.0 / self.height as f64));
        let (mut sum, mut total) = ([0.0; 3], 0.0);
        self.for_each(|direction, solid_angle, color| {
            let cosine = direction.dot(middle);
            if cosine < inner && cosine > outer {
                total += solid_angle;
                (0..3).for_each(|k| sum[k] += f64::from(color[k]) * solid_angle);
            }
        });
        if !(total > 0.0) {
            return None;
        }
        let around = sum.map(|sum| (sum / total) as f32);
        let limit = 4.0 * brightness(around);
        let (mut light, mut toward, mut taken) = ([0.0; 3], DVec3::ZERO, Vec::new());
        let mut number = 0;
        self.for_each(|direction, solid_angle, color| {
            if direction.dot(middle) >= inner && brightness(color) > limit {
                let more =
                    [0, 1, 2].map(|k| (f64::from(color[k]) - f64::from(around[k])).max(0.0) * solid_angle);
                toward += direction * more.iter().sum::<f64>();
                (0..3).for_each(|k| light[k] += more[k]);
                taken.push(number);
            }
            number += 1;
        });
        if !(light.iter().sum::<f64>() > 0.01 * all) {
            return None;
        }
        taken.into_iter().for_each(|number: usize| self.pixels[number] = around);
        Some((toward.normalize(), light))
    }

    /// Calls `f` with the direction of each pixel's middle, in the panorama's axes; its solid angle; and its colour.
    pub(super) fn for_each(&self, mut f: impl FnMut(DVec3, f64, [f32; 3])) {
        let width = 2 * self.height;
        let columns = longitudes(width);
        for (y, row) in self.pixels.chunks_exact(width).enumerate() {
            let (up, share) = elevation(y, self.height);
            let aside = (1.0 - up * up).max(0.0).sqrt();
            let solid_angle = share * std::f64::consts::TAU / width as f64;
            for (&(sine, cosine), &color) in columns.iter().zip(row) {
                f(DVec3::new(aside * sine, up, -aside * cosine), solid_angle, color);
            }
        }
    }
}

/// The sine of the elevation in the middle of a row, and by how much the sine differs between its borders.
fn elevation(y: usize, rows: usize) -> (f64, f64) {
    let at = |y: f64| sin_cos(std::f64::consts::PI * (0.5 - y / rows as f64)).0;
    (at(y as f64 + 0.5), at(y as f64) - at(y as f64 + 1.0))
}

/// Sine and cosine of the angle of each column, to the right of the middle.
fn longitudes(width: usize) -> Vec<(f64, f64)> {
    let angle = |x: usize| ((x as f64 + 0.5) / width as f64 - 0.5) * std::f64::consts::TAU;
    (0..width).map(|x| sin_cos(angle(x))).collect()
}
