//! The directions of the model's axes, in a corner of the picture.

use glam::DVec3;
use tercio_mesh::trig::sin_cos_degrees;

use crate::annotation::margins::MOST_TAKEN;
use crate::font::{CAP_HEIGHT, Direction, Line};
use crate::layout::{Layout, Rect, SHRINK, overlap};
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

/// Half of the height of a name, in ems, and how far the tail of a y is below that.
const HALF_NAME: f64 = 0.27;
const TAIL: f64 = 0.2;

/// The corners of what is drawn of an arm, in pixels from the origin of the axes: its shaft and its head, or a square on its
/// corner if it points towards the viewer or away.
pub(crate) fn shapes(arm: &Arm, em: f64) -> Vec<Vec<[f64; 2]>> {
    let [x, y] = arm.tip;
    let length = (x * x + y * y).sqrt();
    if length <= em * 0.15 {
        let r = em * 0.22;
        return vec![vec![[-r, 0.0], [0.0, -r], [r, 0.0], [0.0, r]]];
    }
    let head = (em * 0.62).min(length);
    let at = |along: f64, aside: f64| {
        let [ux, uy] = [x / length, y / length];
        [ux * along - uy * aside, uy * along + ux * aside]
    };
    let (half, end) = (width(em) * 0.5, length - head * 0.8);
    vec![
        vec![at(0.0, half), at(end, half), at(end, -half), at(0.0, -half)],
        vec![at(length, 0.0), at(length - head, em * 0.23), at(length - head, -em * 0.23)],
    ]
}

/// The width of shafts.
fn width(em: f64) -> f64 {
    (em * 0.14).max(1.0)
}

/// Whether a box touches a convex polygon: no line along a side of either has them on its two sides.
pub(crate) fn touches([left, top, right, bottom]: Rect, polygon: &[[f64; 2]]) -> bool {
    let corners = [[left, top], [right, top], [right, bottom], [left, bottom]];
    let sides = (0..polygon.len()).map(|i| {
        let ([ax, ay], [bx, by]) = (polygon[i], polygon[(i + 1) % polygon.len()]);
        [ay - by, bx - ax]
    });
    let range = |points: &[[f64; 2]], [nx, ny]: [f64; 2]| {
        let along = points.iter().map(|[x, y]| x * nx + y * ny);
        along.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)])
    };
    sides.chain([[1.0, 0.0], [0.0, 1.0]]).all(|normal| {
        let ([a, b], [c, d]) = (range(&corners, normal), range(polygon, normal));
        a < d && c < b
    })
}

/// The box of a name with this middle.
fn name_box(name: &str, [x, y]: [f64; 2], em: f64) -> Rect {
    let half = Line::new(name).width * em * 0.5;
    let below = if name == "y" { HALF_NAME + TAIL } else { HALF_NAME };
    [x - half, y - HALF_NAME * em, x + half, y + below * em]
}

/// The middles of the names of arms, in pixels from the origin of the axes: beyond their ends, or beside these where something
/// else is there.
pub(crate) fn names(arms: &[Arm], em: f64) -> Vec<[f64; 2]> {
    let shapes: Vec<Vec<[f64; 2]>> = arms.iter().flat_map(|arm| shapes(arm, em)).collect();
    let mut boxes: Vec<Rect> = Vec::new();
    let mut middles = Vec::new();
    for (number, arm) in arms.iter().enumerate() {
        let [x, y] = arm.tip;
        let length = (x * x + y * y).sqrt();
        // The name of a short arm is opposite to the others.
        let mut toward = [x, y];
        if length < em * 0.7 {
            let others = arms.iter().enumerate().filter(|(other, _)| *other != number);
            toward = others.fold([0.0; 2], |sum, (_, other)| [sum[0] - other.tip[0], sum[1] - other.tip[1]]);
        }
        let size = (toward[0] * toward[0] + toward[1] * toward[1]).sqrt().max(1e-9);
        let [ux, uy] = toward.map(|v| v / size);
        // Turned to one side, then to the other one, farther and farther.
        let turned = |step: i32| {
            let (sin, cos) = sin_cos_degrees(f64::from(step) * TURN);
            [ux * cos - uy * sin, uy * cos + ux * sin]
        };
        let steps =
            || (0..).map(|n: i32| if n % 2 == 0 { n / 2 } else { -(n / 2) - 1 }).take(360 / TURN as usize);
        let beyond = length + em * 0.55;
        let usual = std::iter::once([ux * beyond, uy * beyond]);
        let at_end = steps().map(|step| turned(step).map(|d| d * em * 0.62)).map(|[dx, dy]| [x + dx, y + dy]);
        let round = [beyond.min(em * FARTHEST), em * 1.4, em * FARTHEST].into_iter();
        let round = round.flat_map(|distance| steps().map(move |step| turned(step).map(|d| d * distance)));
        let is_free = |middle: &[f64; 2]| {
            let rect = name_box(arm.name, *middle, em);
            let reaches = em * HALF;
            rect.iter().all(|side| side.abs() <= reaches)
                && !boxes.iter().any(|other| overlap(other, &rect, em * 0.05))
                && !shapes.iter().any(|shape| touches(rect, shape))
        };
        let first = [ux * beyond, uy * beyond];
        let middle = usual.chain(at_end).chain(round).find(is_free).unwrap_or(first);
        boxes.push(name_box(arm.name, middle, em));
        middles.push(middle);
    }
    middles
}

/// Degrees between two places that are tried for a name.
const TURN: f64 = 15.0;
/// The largest distance of a name from the origin of the axes, in ems.
const FARTHEST: f64 = LENGTH + 0.5;

/// The share of the shorter side of a picture that the box of the axes takes as a rule, at most: in small pictures they are smaller.
const USUAL: f64 = 0.4;

/// The size of the text of the axes, and their unit of length: that of all text, smaller by at most [`SHRINK`] in small pictures.
fn em(layout: &Layout) -> f64 {
    let wanted = layout.size[0].min(layout.size[1]) * USUAL / (HALF * 2.0);
    wanted.clamp(layout.em * SHRINK, layout.em)
}

/// The size of the box of the axes; `None` where they were most of the picture, so that the model would have no room.
pub(crate) fn size(layout: &Layout) -> Option<[f64; 2]> {
    // Compared before it is rounded: a larger picture has them, too.
    let side = em(layout) * HALF * 2.0;
    (side < layout.size[0].min(layout.size[1]) * MOST_TAKEN - 1e-6).then_some([side.ceil(); 2])
}

/// Draws the axes in a box of that size.
pub(crate) fn draw(layout: &mut Layout, projector: &Projector, rect: Rect) {
    let em = em(layout);
    let middle = [(rect[0] + rect[2]) * 0.5, (rect[1] + rect[3]) * 0.5];
    let arms = arms(projector, em * LENGTH);
    let is_dark = layout.color[1] > 0.4;
    let names = names(&arms, em);
    for (arm, [lx, ly]) in arms.iter().zip(names) {
        let [x, y] = arm.tip;
        let length = (x * x + y * y).sqrt();
        // On a dark picture they are brighter.
        let color = if is_dark { arm.color.map(|c| (c * 1.6 + 0.12).min(1.0)) } else { arm.color };
        let paint = Paint::Solid(color);
        let shapes = shapes(arm, em);
        if length > em * 0.15 {
            let end = length - (em * 0.62).min(length) * 0.8;
            let end = [middle[0] + x / length * end, middle[1] + y / length * end];
            layout.overlay.fill(Outline::stroke(middle, end, width(em)), paint.clone());
        }
        if let Some(last) = shapes.last() {
            let corners: Vec<[f64; 2]> = last.iter().map(|[x, y]| [middle[0] + x, middle[1] + y]).collect();
            layout.overlay.fill(Outline::polygon(&corners), paint);
        }
        let line = Line::new(arm.name);
        let place = [middle[0] + lx - line.width * em * 0.5, middle[1] + ly + em * CAP_HEIGHT * 0.36];
        layout.overlay.text(&line, place.map(f64::round), em, Direction::Right, layout.color);
    }
}
