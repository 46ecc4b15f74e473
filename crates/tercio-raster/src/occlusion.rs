//! Ambient occlusion in screen space: darkens what little of the surroundings can reach.
//!
//! Around each visible point, fixed points are spread over the hemisphere above the surface, with the cosine as density
//! of their directions and the square of the distance as distribution of their distances: those behind something visible
//! are occluded, if it is above the tangent plane and not far in front. Where what is visible is thick, their share is that
//! of the rays that hit something, a hit at the share s of the radius counting as 1 - s^2. What is hidden, or outside the
//! picture, occludes nothing.
//!
//! Each pixel is computed by itself from the finished planes, in `f32` without any function of the system, so that the
//! result does not depend on tiles, threads, ranks or SIMD levels, and there are no seams.
//!
//! Sources: the hemispheres of points of Filion and McNaughton, "StarCraft II effects and techniques" (2008); the basis of
//! Duff et al., "Building an orthonormal basis, revisited" (2017).

use rayon::prelude::*;
use tercio_scene::{Camera, Scene};

use crate::conventions::SUBPIXELS;
use crate::error::RenderError;
use crate::frame::{Frame, Outputs};
use crate::resolve::{color8, color16};
use crate::settings::Settings;
use crate::view::View;

/// How ambient occlusion looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AmbientOcclusion {
    /// How far surfaces darken each other, relative to the radius of the scene; above 0.
    pub radius: f64,
    /// 0 for none to 1: the share of light that is taken from what is wholly occluded.
    pub strength: f32,
}

impl Default for AmbientOcclusion {
    fn default() -> Self {
        Self { radius: 0.1, strength: 1.0 }
    }
}

impl AmbientOcclusion {
    /// The planes that it needs; frames may have others besides.
    pub const NEEDED: Outputs = Outputs { linear: true, depth: true, normals: true, ..Outputs::NONE };

    /// Darkens the colours of a finished frame of this scene, camera and settings: its linear plane, and the 8-bit and
    /// 16-bit planes if it has them.
    ///
    /// # Errors
    /// [`RenderError::Setting`] if radius or strength is out of range; [`RenderError::Camera`].
    ///
    /// # Panics
    /// If the frame does not have the planes [`AmbientOcclusion::NEEDED`] of a whole picture.
    pub fn apply(
        &self,
        frame: &mut Frame,
        scene: &Scene,
        camera: &Camera,
        settings: &Settings,
    ) -> Result<(), RenderError> {
        let setting = |what, range: &str, value: f64| {
            Err(RenderError::Setting { what, range: range.into(), value: value.to_string() })
        };
        if !(self.radius > 0.0 && self.radius.is_finite()) {
            return setting("radius of ambient occlusion", "above 0 and finite", self.radius);
        }
        if !(0.0..=1.0).contains(&self.strength) {
            return setting("strength of ambient occlusion", "0 to 1", self.strength.into());
        }
        let bounds = scene.bounds();
        let view = View::new(camera, &bounds, settings.width, settings.height)?;
        let (width, height) = (settings.width as usize, settings.height as usize);
        let Frame { planes, .. } = frame;
        let is_complete =
            [planes.linear.len(), planes.depth.len(), planes.normals.len()] == [width * height; 3];
        assert!(is_complete, "the frame has the planes that ambient occlusion needs");
        let space = Space::new(&view, self.radius * bounds.radius(), &planes.depth, &planes.normals);
        let pixels = 0..planes.depth.len();
        let occlusion =
            pixels.into_par_iter().with_min_len(64).map(|i| space.occlusion(i % width, i / width));
        let mut light = Vec::new();
        occlusion.map(|share| 1.0 - self.strength * share).collect_into_vec(&mut light);
        // What is not darkened keeps its bytes.
        let darkened = |color: &[f32; 4], light: f32| (light < 1.0).then(|| darkened(*color, light));
        let linear = &planes.linear;
        let colors = planes.color.par_iter_mut().zip(linear).zip(&light).with_min_len(1 << 12);
        colors.for_each(|((to, color), &light)| *to = darkened(color, light).map_or(*to, color8));
        let colors = planes.color16.par_iter_mut().zip(linear).zip(&light).with_min_len(1 << 12);
        colors.for_each(|((to, color), &light)| *to = darkened(color, light).map_or(*to, color16));
        for (color, &light) in planes.linear.iter_mut().zip(&light) {
            *color = darkened(color, light).unwrap_or(*color);
        }
        Ok(())
    }
}

/// A premultiplied linear colour with less light.
fn darkened([r, g, b, alpha]: [f32; 4], light: f32) -> [f32; 4] {
    [r * light, g * light, b * light, alpha]
}

type Vec3 = [f32; 3];

/// Number of points around each visible point.
const POINTS: usize = 96;

/// What is less than this above the tangent plane occludes nothing: facets of a smooth surface would darken each other.
const BIAS: f32 = 0.025;

/// Points of the hemisphere around +z. Directions are a spiral whose turns are as far apart as the points on them, distances
/// a van der Corput sequence.
fn points() -> Vec<Vec3> {
    const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;
    let point = |i: usize| {
        let (sine, cosine) = tercio_mesh::trig::sin_cos(GOLDEN_ANGLE * i as f64);
        let from_pole = ((i as f64 + 0.5) / POINTS as f64).sqrt();
        let share = f64::from((i as u32 + 1).reverse_bits()) / (1u64 << 32) as f64;
        let distance = share.sqrt();
        let direction = [from_pole * cosine, from_pole * sine, (1.0 - from_pole * from_pole).sqrt()];
        direction.map(|c| (distance * c) as f32)
    };
    (0..POINTS).map(point).collect()
}

/// The visible surface in the camera's axes: x to the right, y upwards, z towards the viewer. Lengths are in radii of the
/// occlusion.
struct Space<'a> {
    size: [i32; 2],
    perspective: bool,
    /// Pixels per radius; at a distance of one radius for a perspective camera.
    scale: f32,
    /// The middle of the picture, in pixels.
    middle: [f32; 2],
    /// The camera's axes in world space.
    axes: [Vec3; 3],
    /// Distance along the line of sight; infinite where nothing is visible.
    depth: Vec<f32>,
    /// Unit normals in world space.
    normals: &'a [Vec3],
    /// The points around each visible point.
    points: Vec<Vec3>,
}

impl<'a> Space<'a> {
    fn new(view: &View, radius: f64, depth: &[f32], normals: &'a [Vec3]) -> Self {
        let per_unit = view.scale / f64::from(SUBPIXELS);
        let axes = [view.basis.right, view.basis.up, -view.basis.forward];
        Self {
            size: [view.width as i32, view.height as i32],
            perspective: view.perspective,
            scale: if view.perspective { per_unit } else { per_unit * radius } as f32,
            middle: view.middle.map(|n| n as f32 / SUBPIXELS as f32),
            axes: axes.map(|axis| axis.as_vec3().to_array()),
            depth: depth.iter().map(|&d| (f64::from(d) / radius) as f32).collect(),
            normals,
            points: points(),
        }
    }

    fn index(&self, x: i32, y: i32) -> usize {
        y as usize * self.size[0] as usize + x as usize
    }

    /// The point at the middle of a pixel, at this distance.
    fn position(&self, x: i32, y: i32, distance: f32) -> Vec3 {
        let to_side = if self.perspective { distance / self.scale } else { 1.0 / self.scale };
        let [right, down] = [x as f32 + 0.5 - self.middle[0], y as f32 + 0.5 - self.middle[1]];
        [right * to_side, -down * to_side, -distance]
    }

    /// The pixel in which a point appears, if it is in the picture.
    fn pixel(&self, [x, y, z]: Vec3) -> Option<[i32; 2]> {
        let scale = if self.perspective { self.scale / -z } else { self.scale };
        let at = [self.middle[0] + x * scale, self.middle[1] - y * scale];
        let is_before_eye = self.perspective && z >= 0.0;
        let is_inside = |k: usize| at[k] >= 0.0 && at[k] < self.size[k] as f32;
        (!is_before_eye && is_inside(0) && is_inside(1)).then(|| at.map(|c| c as i32))
    }

    /// The share of the light from everywhere that does not reach a pixel's surface; 0 where there is none.
    fn occlusion(&self, x: usize, y: usize) -> f32 {
        let [x, y] = [x as i32, y as i32];
        let index = self.index(x, y);
        let distance = self.depth[index];
        if !distance.is_finite() {
            return 0.0;
        }
        let point = self.position(x, y, distance);
        let normal = self.axes.map(|axis| dot(axis, self.normals[index]));
        let [tangent, bitangent] = basis(normal);
        let mut sum = 0.0;
        for &[right, up, above] in &self.points {
            let around: Vec3 = std::array::from_fn(|k| {
                (point[k] + right * tangent[k]) + (up * bitangent[k] + above * normal[k])
            });
            let Some(at) = self.pixel(around) else { continue };
            let distance = self.depth[self.index(at[0], at[1])];
            let behind = -around[2] - distance;
            // Also if nothing is visible there.
            if behind <= 0.0 || at == [x, y] {
                continue;
            }
            let visible = self.position(at[0], at[1], distance);
            let apart: Vec3 = std::array::from_fn(|k| visible[k] - point[k]);
            if dot(apart, normal) > BIAS {
                sum += (2.0 - behind).clamp(0.0, 1.0);
            }
        }
        sum / POINTS as f32
    }
}

fn dot(a: Vec3, b: Vec3) -> f32 {
    (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]
}

/// Two unit vectors that are perpendicular to a unit vector and to each other.
fn basis([x, y, z]: Vec3) -> [Vec3; 2] {
    let sign = if z >= 0.0 { 1.0 } else { -1.0 };
    let a = -1.0 / (sign + z);
    let b = (x * y) * a;
    [[1.0 + sign * ((x * x) * a), sign * b, -sign * x], [b, sign + (y * y) * a, -y]]
}
