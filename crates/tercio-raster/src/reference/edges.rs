//! Lines along the sides of a triangle, at one point of it.

use tercio_mesh::edges::Beyond;
use tercio_scene::SurfaceEdges;

use super::shading::{Vec3, each, shading_distance, shown};
use crate::conventions::SUBPIXELS;
use crate::settings::Settings;
use crate::surface_edges::{Footprint, PIXELS, apex_of};
use crate::view::{ObjectView, ScreenVertex};

/// Light with the lines over it. `area` and its change from one sub-pixel to the next are those of the sides, and `scale` what makes them
/// barycentric coordinates in perspective; `corners` are on the screen.
#[expect(clippy::too_many_arguments, reason = "one caller; a struct would only rename them")]
pub fn over(
    edges: &SurfaceEdges,
    triangle: usize,
    (object, corners): (&ObjectView, [ScreenVertex; 3]),
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
    // The line from an end of a side to a point that is on the other side of the side.
    let whole = (area[0] + area[1]) + area[2];
    let to_far_end = |line: &mut dyn FnMut(f32, f32, f32), side: usize, end: usize, position: Vec3| {
        let from = corners[(side + 1 + end) % 3];
        let to = object.project(position);
        if !to.inside || corners.iter().any(|corner| !corner.inside) {
            return;
        }
        let (x, y) = ((to.x - from.x) as f32, (to.y - from.y) as f32);
        let (of_x, of_y) = ((sample[0] - from.x) as f32, (sample[1] - from.y) as f32);
        let is_beyond = (right[side] * x + down[side] * y) * whole < 0.0;
        // A point behind the end is as near to the sides of the triangle there.
        if is_beyond && of_x * x + of_y * y >= 0.0 {
            line(of_x * y - of_y * x, y, -x);
        }
    };
    match &edges.beyond {
        Beyond::Nothing => {}
        Beyond::Quadrilaterals(fourth) => {
            if let Some(position) = fourth.of(triangle) {
                (0..2).for_each(|end| to_far_end(&mut line, apex_of(sides), end, position));
            }
        }
        // Functions of the lines beyond the side opposite to a corner, which are linear combinations of those of the sides.
        Beyond::Polygons(places) => {
            for (apex, places) in places[triangle].iter().enumerate() {
                for (n, &place) in places.iter().enumerate().filter(|(_, place)| **place > 0.0) {
                    let beside = (apex + 1 + n) % 3;
                    let (by_apex, by_beside) = (place * scale[apex], scale[beside]);
                    let of = |v: Vec3| v[apex] * by_apex + v[beside] * by_beside;
                    line(of(area), of(right), of(down));
                }
            }
        }
        Beyond::Ends(ends) => {
            for far in ends.of(triangle) {
                to_far_end(&mut line, far.side.into(), far.end.into(), far.position);
            }
        }
    }
    let Footprint { size, shrinking, least } = Footprint::new(settings, shading_distance(settings));
    let extent = (size - across * shrinking).max(least);
    let covered = (edges.width * 0.5 - nearest * PIXELS) + extent * 0.5;
    let cover = covered.max(0.0).min(edges.width.min(extent)) / extent * edges.opacity;
    let light = light.map(shown);
    each(|k| light[k] + (edges.color[k] - light[k]) * cover)
}
