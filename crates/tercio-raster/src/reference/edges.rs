//! Lines along the sides of a triangle, at one point of it.

use tercio_scene::SurfaceEdges;

use super::shading::{Vec3, each, shading_distance, shown};
use crate::conventions::SUBPIXELS;
use crate::settings::Settings;
use crate::surface_edges::{Footprint, PIXELS};

/// Light with the lines over it. `area` and its change from one sub-pixel to the next are those of the sides.
pub fn over(
    edges: &SurfaceEdges,
    triangle: usize,
    (area, right, down): (Vec3, Vec3, Vec3),
    settings: &Settings,
    sample: [i32; 2],
    light: Vec3,
) -> Vec3 {
    let [x, y] = sample.map(|c| (c.rem_euclid(SUBPIXELS) - SUBPIXELS / 2) as f32);
    let sides = edges.sides_of(triangle as u32);
    let (mut nearest, mut across) = (f32::INFINITY, 0.0);
    for k in (0..3).filter(|k| sides >> k & 1 == 1) {
        let inverse = 1.0 / (right[k] * right[k] + down[k] * down[k]).sqrt();
        let distance = area[k].abs() * inverse;
        if distance < nearest {
            (nearest, across) = (distance, (x * right[k] + y * down[k]).abs() * inverse);
        }
    }
    let Footprint { size, shrinking, least } = Footprint::new(settings, shading_distance(settings));
    let extent = (size - across * shrinking).max(least);
    let covered = (edges.width * 0.5 - nearest * PIXELS) + extent * 0.5;
    let cover = covered.max(0.0).min(edges.width.min(extent)) / extent;
    let light = light.map(shown);
    each(|k| light[k] + (edges.color[k] - light[k]) * cover)
}
