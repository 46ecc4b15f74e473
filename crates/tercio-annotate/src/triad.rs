//! The directions of the model's axes, in a corner of the picture.

use glam::DVec3;

use crate::font::{CAP_HEIGHT, Direction, Line};
use crate::layout::{Layout, Place};
use crate::outline::Outline;
use crate::overlay::Paint;
use crate::project::Projector;

/// Names, directions and colours (linear light) of the axes.
const AXES: [(&str, DVec3, [f32; 4]); 3] = [
    ("x", DVec3::X, [0.62, 0.03, 0.03, 1.0]),
    ("y", DVec3::Y, [0.02, 0.32, 0.05, 1.0]),
    ("z", DVec3::Z, [0.03, 0.14, 0.71, 1.0]),
];

/// Length of an axis in the plane of the picture, in ems.
const LENGTH: f64 = 2.1;
/// Half of the box, in ems: axes and their names.
const HALF: f64 = 3.0;

/// An axis in the picture, in pixels from the origin of the axes.
#[derive(Clone, Debug)]
pub struct Arm {
    /// Its name.
    pub name: &'static str,
    /// Its end, to the right and downwards.
    pub tip: [f64; 2],
    /// Away from the viewer.
    pub depth: f64,
    color: [f32; 4],
}

/// The axes in the picture, so many pixels long, the farthest first.
pub fn arms(projector: &Projector, length: f64) -> Vec<Arm> {
    let arm = |(name, axis, color): (&'static str, DVec3, [f32; 4])| {
        let d = projector.direction(axis) * length;
        Arm { name, tip: [d.x, d.y], depth: d.z, color }
    };
    let mut arms: Vec<Arm> = AXES.map(arm).into();
    arms.sort_by(|a, b| b.depth.total_cmp(&a.depth));
    arms
}

/// Adds the axes to a picture.
pub fn add(layout: &mut Layout, projector: &Projector, place: Place) {
    let em = layout.em;
    let side = (em * HALF * 2.0).ceil();
    let Some(rect) = layout.find([side, side], place) else { return layout.leave_out("axes") };
    layout.keep("axes", rect);
    let middle = [rect[0] + side * 0.5, rect[1] + side * 0.5];
    let arms = arms(projector, em * LENGTH);
    let is_dark = layout.color[1] > 0.4;
    for (number, arm) in arms.iter().enumerate() {
        let [x, y] = arm.tip;
        let length = (x * x + y * y).sqrt();
        // On a dark picture they are brighter.
        let color = if is_dark { arm.color.map(|c| (c * 1.6 + 0.12).min(1.0)) } else { arm.color };
        let paint = Paint::Solid(color);
        let width = (em * 0.14).max(1.0);
        let head = (em * 0.62).min(length);
        let at = |along: f64, aside: f64| {
            let [ux, uy] = [x / length, y / length];
            [middle[0] + ux * along - uy * aside, middle[1] + uy * along + ux * aside]
        };
        if length > em * 0.15 {
            layout.overlay.fill(Outline::stroke(middle, at(length - head * 0.8, 0.0), width), paint.clone());
            let corners = [at(length, 0.0), at(length - head, em * 0.23), at(length - head, -em * 0.23)];
            layout.overlay.fill(Outline::polygon(&corners), paint);
        } else {
            // Towards the viewer or away: a square on its corner.
            let r = em * 0.22;
            let [cx, cy] = middle;
            let corners = [[cx - r, cy], [cx, cy - r], [cx + r, cy], [cx, cy + r]];
            layout.overlay.fill(Outline::polygon(&corners), paint);
        }
        // The name is beyond the end; of a short axis opposite to the others.
        let line = Line::new(arm.name);
        let mut toward = [x, y];
        if length < em * 0.7 {
            let others = arms.iter().enumerate().filter(|(other, _)| *other != number);
            toward = others.fold([0.0; 2], |sum, (_, other)| [sum[0] - other.tip[0], sum[1] - other.tip[1]]);
        }
        let size = (toward[0] * toward[0] + toward[1] * toward[1]).sqrt().max(1e-9);
        let distance = length + em * 0.55;
        let [lx, ly] = [middle[0] + toward[0] / size * distance, middle[1] + toward[1] / size * distance];
        let place = [lx - line.width * em * 0.5, ly + em * CAP_HEIGHT * 0.36];
        layout.overlay.text(&line, place.map(f64::round), em, Direction::Right, layout.color);
    }
}
