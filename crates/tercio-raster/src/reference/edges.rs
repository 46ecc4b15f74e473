//! Lines along the sides of a triangle, at one point of it.

use tercio_mesh::edges::Beyond;
use tercio_scene::SurfaceEdges;

use super::shading::{Vec3, each, shading_distance, shown};
use crate::conventions::SUBPIXELS;
use crate::settings::Settings;
use crate::surface_edges::{Footprint, PIXELS, apex_of};

/// Light with the lines over it. `area` and its change from one sub-pixel to the next are those of the sides, and `scale` what makes them
/// barycentric coordinates in perspective.
pub fn over(
    edges: &SurfaceEdges,
    triangle: usize,
    (area, right, down): (Vec3, Vec3, Vec3),
    scale: Vec3,
    settings: &Settings,
    sample: [i32; 2],
    light: Vec3,
) -> Vec3 {
    let [x, y] = sample.map(|c| (c.rem_euclid(SUBPIXELS) - SUBPIXELS / 2) as f32);
    let sides = edges.sides_of(triangle as u32);
    let (mut nearest, mut across) = (f32::INFINITY, 0.0);
    let mut line = |area: f32, right: f32, down: f32| {
        let inverse = 1.0 / (right * right + down * down).sqrt();
        let distance = area.abs() * inverse;
        if distance < nearest {
            (nearest, across) = (distance, (x * right + y * down).abs() * inverse);
        }
    };
    (0..3).filter(|k| sides >> k & 1 == 1).for_each(|k| line(area[k], right[k], down[k]));
    // Functions of the lines beyond the side opposite to a corner, which are linear combinations of those of the sides.
    let mut beyond = |apex: usize, places: [f32; 2]| {
        for (n, place) in places.into_iter().enumerate().filter(|(_, place)| *place > 0.0) {
            let beside = (apex + 1 + n) % 3;
            let (by_apex, by_beside) = (place * scale[apex], scale[beside]);
            let of = |v: Vec3| v[apex] * by_apex + v[beside] * by_beside;
            line(of(area), of(right), of(down));
        }
    };
    match &edges.beyond {
        Beyond::Nothing => {}
        Beyond::Quadrilaterals(places) => beyond(apex_of(sides), places[triangle]),
        Beyond::Polygons(places) => (0..3).for_each(|k| beyond(k, places[triangle][k])),
    }
    let Footprint { size, shrinking, least } = Footprint::new(settings, shading_distance(settings));
    let extent = (size - across * shrinking).max(least);
    let covered = (edges.width * 0.5 - nearest * PIXELS) + extent * 0.5;
    let cover = covered.max(0.0).min(edges.width.min(extent)) / extent * edges.opacity;
    let light = light.map(shown);
    each(|k| light[k] + (edges.color[k] - light[k]) * cover)
}
