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
use fearless_simd::{Level, Simd, dispatch, f32x16};
use rayon::prelude::*;
use tercio_raster::{Frame, Outputs, RenderError, Settings};
use tercio_scene::{Camera, Scene};

use crate::darken::darken;
use crate::lanes::{LANES, Lanes, clamp, splat};
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
        let light = light(&surface, radius as usize, self.strength, level);
        darken(&mut frame.planes, &light);
        Ok(())
    }
}

/// The share of light that is left in each pixel.
fn light(surface: &Surface, radius: usize, strength: f32, level: Level) -> Vec<f32> {
    let (width, height) = (surface.width, surface.height);
    let margin = radius * RINGS[RINGS.len() - 1].0;
    let stride = width.next_multiple_of(LANES) + 2 * margin;
    // Nothing is visible in the margins.
    let mut depth = vec![f32::INFINITY; stride * (height + 2 * margin)];
    let rows = depth.par_chunks_mut(stride).skip(margin).zip(surface.depth.par_chunks(width));
    rows.with_min_len(16).for_each(|(to, from)| to[margin..margin + width].copy_from_slice(from));
    let mut light = vec![1.0; width * height];
    light.par_chunks_mut(width).enumerate().for_each(|(y, to)| {
        for (chunk, to) in to.chunks_mut(LANES).enumerate() {
            let at = (y + margin) * stride + margin + chunk * LANES;
            if depth[at..at + LANES].iter().any(|d| d.is_finite()) {
                let place = Place { surface, depth: &depth, at, stride, radius };
                let found = dispatch!(level, simd => place.light(simd, strength).to_array());
                to.iter_mut().zip(found).for_each(|(to, light)| *to = light);
            }
        }
    });
    light
}

/// 16 pixels of a row.
struct Place<'a> {
    surface: &'a Surface,
    /// With margins.
    depth: &'a [f32],
    /// The index of the first pixel.
    at: usize,
    stride: usize,
    radius: usize,
}

impl Place<'_> {
    #[inline(always)]
    fn light<S: Simd>(&self, simd: S, strength: f32) -> Lanes<S> {
        let (none, one) = (splat(simd, 0.0), splat(simd, 1.0));
        let depth = f32x16::from_slice(simd, &self.depth[self.at..self.at + LANES]);
        let is_visible = depth.simd_lt(splat(simd, f32::INFINITY));
        let depth = is_visible.select(depth, one);
        let scale = splat(simd, self.surface.scale);
        // Pixels per unit of length at this distance.
        let pixels = if self.surface.perspective { scale / depth } else { scale };
        let mut sum = none;
        for (ring, weight) in RINGS {
            let distance = self.radius * ring;
            // The diagonal neighbours are farther away.
            let straight = 1.0 / distance as f32;
            let diagonal = straight * std::f32::consts::FRAC_1_SQRT_2;
            let mut of_ring = none;
            for (down, right) in [(0, 0), (0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1), (2, 2)] {
                let index = self.at + down * distance * self.stride + right * distance;
                let index = index - distance * self.stride - distance;
                let other = f32x16::from_slice(simd, &self.depth[index..index + LANES]);
                let per_pixel = if down == 1 || right == 1 { straight } else { diagonal };
                let slope = (depth - other) * pixels * per_pixel;
                of_ring += clamp(simd, slope, 0.0, STEEPEST);
            }
            sum += of_ring * (weight / 8.0);
        }
        // The exponential function, as a power of 64.
        let mut light = one / (one + sum * (strength * PER_SLOPE / 64.0));
        for _ in 0..6 {
            light = light * light;
        }
        is_visible.select(light, one)
    }
}
