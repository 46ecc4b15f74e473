//! Lines along the sides of a triangle, at one point of it.

use tercio_mesh::edges::Beyond;
use tercio_scene::SurfaceEdges;

use super::shading::{Vec3, each, shading_distance, shown};
use crate::conventions::SUBPIXELS;
use crate::settings::Settings;
use crate::surface_edges::{Footprint, Nearest, PIXELS, SNAPPED, apex_of, nearest_of_clipped};
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
    let from_middle = sample.map(|c| (c.rem_euclid(SUBPIXELS) - SUBPIXELS / 2) as f32);
    let sides = edges.sides_of(triangle as u32);
    let projected = positions.map(|p| object.project(p));
    let mut nearest = Nearest::NONE;
    let own = (0..3).filter(|k| sides >> k & 1 == 1);
    own.for_each(|k| nearest.add([area[k], right[k], down[k]], from_middle));
    // The line from an end of a side to a point that is on the other side of the side. Homogeneous coordinates hold wherever the point is.
    let whole = (area[0] + area[1]) + area[2];
    let to_far_end = |side: usize, end: usize, position: Vec3| {
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
        (inwards < snapped && is_beside).then_some([of_x * y - of_y * x, y, -x])
    };
    let is_clipped = projected.iter().any(|corner| !corner.inside);
    match &edges.beyond {
        Beyond::Nothing => {}
        Beyond::Quadrilaterals(_) | Beyond::Ends(_) if is_clipped => {
            let of = [area, right, down];
            nearest.take(nearest_of_clipped(edges, (triangle, sides), positions, of, from_middle));
        }
        Beyond::Quadrilaterals(fourth) => {
            if let Some(position) = fourth.of(triangle) {
                let lines = (0..2).filter_map(|end| to_far_end(apex_of(sides), end, position));
                lines.for_each(|line| nearest.add(line, from_middle));
            }
        }
        // Functions of the lines beyond the side opposite to a corner, which are linear combinations of those of the sides.
        Beyond::Polygons(places) => {
            for (apex, places) in places[triangle].iter().enumerate() {
                for (n, &place) in places.iter().enumerate().filter(|(_, place)| **place > 0.0) {
                    let beside = (apex + 1 + n) % 3;
                    let (by_apex, by_beside) = (place * scale[apex], scale[beside]);
                    let of = |v: Vec3| v[apex] * by_apex + v[beside] * by_beside;
                    nearest.add([of(area), of(right), of(down)], from_middle);
                }
            }
        }
        Beyond::Ends(ends) => {
            let all = ends.of(triangle);
            let lines = all.filter_map(|far| to_far_end(far.side.into(), far.end.into(), far.position));
            lines.for_each(|line| nearest.add(line, from_middle));
        }
    }
    let Footprint { size, shrinking, least } = Footprint::new(settings, shading_distance(settings));
    let Nearest { distance: nearest, across } = nearest;
    let extent = (size - across * shrinking).max(least);
    let covered = (edges.width * 0.5 - nearest * PIXELS) + extent * 0.5;
    let cover = covered.max(0.0).min(edges.width.min(extent)) / extent * edges.opacity;
    let light = light.map(shown);
    each(|k| light[k] + (edges.color[k] - light[k]) * cover)
}
