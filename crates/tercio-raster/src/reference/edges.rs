//! Lines along the sides of a triangle, at one point of it.

use tercio_mesh::edges::Beyond;
use tercio_scene::SurfaceEdges;

use super::shading::{Vec3, each, shading_distance, shown};
use crate::conventions::SUBPIXELS;
use crate::settings::Settings;
use crate::surface_edges::{Footprint, PIXELS, SNAPPED, apex_of, nearest_of_clipped};
use crate::view::ObjectView;

/// Light with the lines over it. `area` and its change from one sub-pixel to the next are those of the sides, and `scale` what makes them
/// barycentric coordinates in perspective; `positions` are those of the corners.
#[expect(clippy::too_many_arguments, reason = "one caller; a struct would only rename them")]
pub fn over(
    edges: &SurfaceEdges,
    triangle: usize,
    (object, positions): (&ObjectView, [Vec3; 3]),
    (area, right, down): (Vec3, Vec3, Vec3),
    scale: Vec3,
    settings: &Settings,
    sample: [i32; 2],
    light: Vec3,
) -> Vec3 {
    let [x, y] = sample.map(|c| (c.rem_euclid(SUBPIXELS) - SUBPIXELS / 2) as f32);
    let sides = edges.sides_of(triangle as u32);
    let projected = positions.map(|p| object.project(p));
    let (mut nearest, mut across) = (f32::INFINITY, 0.0);
    let mut line = |area: f32, right: f32, down: f32| {
        let inverse = 1.0 / (right * right + down * down).sqrt();
        let distance = area.abs() * inverse;
        if distance < nearest {
            (nearest, across) = (distance, (x * right + y * down).abs() * inverse);
        }
    };
    (0..3).filter(|k| sides >> k & 1 == 1).for_each(|k| line(area[k], right[k], down[k]));
    // The line from an end of a side to a point that is on the other side of the side. Homogeneous coordinates hold wherever the point is.
    let whole = (area[0] + area[1]) + area[2];
    let to_far_end = |line: &mut dyn FnMut(f32, f32, f32), side: usize, end: usize, position: Vec3| {
        let corner = projected[(side + 1 + end) % 3];
        let to = object.homogeneous(position);
        let from = [(corner.x - object.offset[0]) as f32, (corner.y - object.offset[1]) as f32];
        let (x, y) = (to[0] - from[0] * to[2], to[1] - from[1] * to[2]);
        let (of_x, of_y) = ((sample[0] - corner.x) as f32, (sample[1] - corner.y) as f32);
        let inwards = right[side] * x + down[side] * y;
        let inwards = if whole < 0.0 { -inwards } else { inwards };
        let snapped = (right[side].abs() + down[side].abs()) * (to[2].abs() * SNAPPED);
        // A point behind the beginning is as near to the sides of the triangle there; behind the far end there is no line, unless it is
        // behind the viewer.
        let along = of_x * x + of_y * y;
        let is_beside = along >= 0.0 && (along * to[2] <= y * y + x * x || to[2] <= 0.0);
        if inwards < snapped && is_beside {
            line(of_x * y - of_y * x, y, -x);
        }
    };
    let is_clipped = projected.iter().any(|corner| !corner.inside);
    match &edges.beyond {
        Beyond::Nothing => {}
        Beyond::Quadrilaterals(_) | Beyond::Ends(_) if is_clipped => {
            let of = [area, right, down];
            let clipped = nearest_of_clipped(edges, (triangle, sides), positions, of, [x, y]);
            if clipped[0] < nearest {
                [nearest, across] = clipped;
            }
        }
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
