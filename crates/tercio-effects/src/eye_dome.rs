//! Eye-dome lighting: shades by depth alone, for scans and points whose normals say little.
//!
//! A pixel is the darker the farther its surroundings rise above it towards the viewer: creases, and what lies behind a
//! step of depth, are dark. Neighbours are looked at in eight directions at three distances. What counts is the slope, the
//! step of depth per distance in the picture, both in the same unit of length, so that the result does not depend on units,
//! on the distance of the model or on the kind of camera.
//!
//! Source: Boucheny, "Interactive scientific visualization of large datasets: towards a perceptive-based approach" (2009),
//! section 2.4, which takes the logarithm of depth instead.

use fearless_simd::prelude::*;
use fearless_simd::{Level, Simd, f32x16};
use rayon::prelude::*;
use tercio_raster::{Frame, Outputs, RenderError, Settings};
use tercio_scene::{Camera, Scene};

use crate::darken::{Colors, bands};
use crate::lanes::{LANES, Lanes, clamp, load, load_part, splat};
use crate::surface::Surface;

/// How eye-dome lighting looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EyeDome {
    /// 0 for none; 1 is usual; finite.
    pub strength: f32,
    /// Distance of the nearest neighbours that are looked at, in pixels, 1 to [`EyeDome::MAX_RADIUS`]; `None` for a thousandth of the picture's
    /// height, rounded up.
    pub radius: Option<u32>,
}

impl Default for EyeDome {
    fn default() -> Self {
        Self { strength: 1.0, radius: None }
    }
}

/// The distances of the neighbours, in radii, and their weights.
const RINGS: [(usize, f32); 3] = [(1, 4.0 / 7.0), (2, 2.0 / 7.0), (4, 1.0 / 7.0)];
/// Slopes count up to this.
const STEEPEST: f32 = 8.0;
/// The exponent of the light that a mean slope of 1 leaves, at strength 1.
const PER_SLOPE: f32 = 0.5;

impl EyeDome {
    /// The largest radius.
    pub const MAX_RADIUS: u32 = 64;

    /// The planes that it needs; frames may have others besides.
    pub const NEEDED: Outputs = Outputs { linear: true, depth: true, ..Outputs::NONE };

    /// Darkens the colours of a finished frame of this scene, camera and settings: its linear plane, and the 8-bit and
    /// 16-bit planes if it has them.
    ///
    /// # Errors
    /// [`RenderError::Setting`] if radius or strength is out of range; [`RenderError::Camera`].
    ///
    /// # Panics
    /// If the frame does not have the planes [`EyeDome::NEEDED`] of a whole picture, or this processor does not have the
    /// SIMD level of the settings.
    pub fn apply(
        &self,
        frame: &mut Frame,
        scene: &Scene,
        camera: &Camera,
        settings: &Settings,
    ) -> Result<(), RenderError> {
        let setting = |what, range: String, value: String| Err(RenderError::Setting { what, range, value });
        if !(self.strength >= 0.0 && self.strength.is_finite()) {
            let value = self.strength.to_string();
            return setting("strength of eye-dome lighting", "0 or above and finite".into(), value);
        }
        let radius = self.radius.unwrap_or_else(|| settings.height.div_ceil(1000).clamp(1, Self::MAX_RADIUS));
        if !(1..=Self::MAX_RADIUS).contains(&radius) {
            let what = "radius of eye-dome lighting";
            return setting(what, format!("1 to {} pixels", Self::MAX_RADIUS), radius.to_string());
        }
        let (surface, level) = Surface::of_frame(frame, scene, camera, settings, 1.0, &Self::NEEDED)?;
        // The depths stay as they are while the colours change.
        let depth = std::mem::take(&mut frame.planes.depth);
        let shader = Shader {
            surface: &surface,
            depth: &depth,
            radius: radius as usize,
            strength: self.strength,
            level,
        };
        shader.darken(bands(&mut frame.planes, surface.width, BAND));
        frame.planes.depth = depth;
        Ok(())
    }
}

/// Rows that one thread darkens at a time.
const BAND: usize = 32;

/// Takes light from the pixels of a frame.
struct Shader<'a> {
    surface: &'a Surface,
    depth: &'a [f32],
    /// In pixels.
    radius: usize,
    strength: f32,
    level: Level,
}

impl Shader<'_> {
    /// Darkens bands of [`BAND`] rows.
    fn darken(&self, bands: Vec<Colors>) {
        let Surface { width, height, .. } = *self.surface;
        let nothing = vec![f32::INFINITY; width];
        let memory = || vec![1.0; width.next_multiple_of(LANES)];
        bands.into_par_iter().enumerate().for_each_init(memory, |light, (number, mut colors)| {
            for y in number * BAND..((number + 1) * BAND).min(height) {
                tercio_raster::dispatch!(self.level, simd => self.row(simd, y, &nothing, light));
                colors.darken((y - number * BAND) * width, &light[..width], self.level);
            }
        });
    }

    /// The depths of the row so many rows below the given one, or above it; `nothing` outside the picture.
    fn depths<'b>(&'b self, y: usize, below: isize, nothing: &'b [f32]) -> &'b [f32] {
        let Surface { width, height, .. } = *self.surface;
        let y = y.checked_add_signed(below).filter(|&y| y < height);
        y.map_or(nothing, |y| &self.depth[y * width..(y + 1) * width])
    }

    /// The share of light that is left in each pixel of a row.
    #[inline(always)]
    fn row<S: Simd>(&self, simd: S, y: usize, nothing: &[f32], light: &mut [f32]) {
        let rings = RINGS.map(|(ring, weight)| {
            let distance = self.radius * ring;
            let below = distance as isize;
            // The diagonal neighbours are farther away.
            let straight = 1.0 / distance as f32;
            let rows = [-below, 0, below].map(|below| self.depths(y, below, nothing));
            Ring { distance, straight, diagonal: straight * std::f32::consts::FRAC_1_SQRT_2, weight, rows }
        });
        let depths = self.depths(y, 0, nothing);
        let margin = rings[rings.len() - 1].distance;
        for (number, light) in light.as_chunks_mut::<LANES>().0.iter_mut().enumerate() {
            let x = number * LANES;
            let depth = load_part(simd, depths, x, f32::INFINITY);
            *light = if depth.simd_lt(splat(simd, f32::INFINITY)).all_false() {
                [1.0; LANES]
            } else if x >= margin && x + LANES + margin <= depths.len() {
                self.light::<_, true>(simd, &rings, x, depth).to_array()
            } else {
                self.light::<_, false>(simd, &rings, x, depth).to_array()
            };
        }
    }

    /// The same of 16 pixels; `INSIDE` if all that they look at is between the left and the right edge of the picture.
    #[inline(always)]
    fn light<S: Simd, const INSIDE: bool>(
        &self,
        simd: S,
        rings: &[Ring; RINGS.len()],
        x: usize,
        depth: Lanes<S>,
    ) -> Lanes<S> {
        let (none, one) = (splat(simd, 0.0), splat(simd, 1.0));
        let is_visible = depth.simd_lt(splat(simd, f32::INFINITY));
        let depth = is_visible.select(depth, one);
        // Pixels per unit of the scene at this distance.
        let pixels = if self.surface.perspective {
            splat(simd, self.surface.scale) / depth
        } else {
            splat(simd, self.surface.scale * self.surface.per_world)
        };
        let mut sum = none;
        for ring in rings {
            let (straight, diagonal) = (pixels * ring.straight, pixels * ring.diagonal);
            let mut of_ring = none;
            for (row, below) in [(0, true), (1, false), (2, true)] {
                let [left, middle, right] = if INSIDE {
                    ring.inside(simd, row, x)
                } else {
                    let [middle, right] = [x + ring.distance, x + 2 * ring.distance];
                    [
                        ring.anywhere(simd, row, x),
                        ring.anywhere(simd, row, middle),
                        ring.anywhere(simd, row, right),
                    ]
                };
                let slanting = if below { diagonal } else { straight };
                of_ring += clamp(simd, (depth - left) * slanting, 0.0, STEEPEST);
                if below {
                    of_ring += clamp(simd, (depth - middle) * straight, 0.0, STEEPEST);
                }
                of_ring += clamp(simd, (depth - right) * slanting, 0.0, STEEPEST);
            }
            sum += of_ring * (ring.weight / 8.0);
        }
        // The exponential function, as a power of 64.
        let mut light = one / (one + sum * (self.strength * PER_SLOPE / 64.0));
        for _ in 0..6 {
            light = light * light;
        }
        is_visible.select(light, one)
    }
}

/// Neighbours at one distance.
struct Ring<'a> {
    /// In pixels.
    distance: usize,
    /// The inverse of the distance, in pixels, of neighbours to the right, and of those on diagonals.
    straight: f32,
    diagonal: f32,
    weight: f32,
    /// Depths of the rows above, here and below.
    rows: [&'a [f32]; 3],
}

impl Ring<'_> {
    /// Three times 16 depths of a row: to the left of the pixels from the given one on, there, and to the right.
    #[inline(always)]
    fn inside<S: Simd>(&self, simd: S, row: usize, x: usize) -> [Lanes<S>; 3] {
        let depths = &self.rows[row][x - self.distance..x + self.distance + LANES];
        let (left, middle, right) =
            (&depths[..LANES], &depths[self.distance..], &depths[2 * self.distance..]);
        [
            f32x16::from_slice(simd, left),
            f32x16::from_slice(simd, &middle[..LANES]),
            f32x16::from_slice(simd, right),
        ]
    }

    /// 16 depths of a row from a pixel on that is counted from one distance left of the picture.
    #[inline(always)]
    fn anywhere<S: Simd>(&self, simd: S, row: usize, first: usize) -> Lanes<S> {
        let mut depths = [f32::INFINITY; LANES];
        for lane in 0..LANES {
            let x = (first + lane).checked_sub(self.distance);
            if let Some(depth) = x.and_then(|x| self.rows[row].get(x)) {
                depths[lane] = *depth;
            }
        }
        load(simd, &depths)
    }
}
