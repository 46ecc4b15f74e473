//! The box of a model, with numbers along its edges.
//!
//! Only edges of back faces are drawn. The whole model is in front of the plane of each of them, so the box is composited behind the
//! finished picture, and the model occludes it exactly. Tick labels are placed outside the silhouette of the box, where no part of
//! the model can be.

use glam::DVec3;

use crate::font::{CAP_HEIGHT, Direction, Line};
use crate::layout::{Layout, Rect, overlap};
use crate::number::NumberFormat;
use crate::outline::Outline;
use crate::overlay::{Overlay, Paint};
use crate::project::Projector;
use crate::ticks::{self, Tick};

/// An edge of a box: parallel to `axis`, at the upper or lower end of the other two axes.
#[derive(Clone, Copy, Debug)]
struct Edge {
    axis: usize,
    upper: [bool; 2],
    /// Whether the outer sides of its two faces are seen.
    seen: [bool; 2],
}

fn edges(projector: &Projector, [min, max]: [DVec3; 2]) -> impl Iterator<Item = Edge> {
    let all = (0..3).flat_map(|axis| (0..4).map(move |i| (axis, [i & 1 > 0, i & 2 > 0])));
    all.map(move |(axis, upper)| {
        let seen = [0, 1].map(|k| {
            let other = (axis + 1 + k) % 3;
            projector.sees(other, if upper[k] { max[other] } else { min[other] }, upper[k])
        });
        Edge { axis, upper, seen }
    })
}

impl Edge {
    /// A point of the edge.
    fn at(&self, value: f64, [min, max]: [DVec3; 2]) -> DVec3 {
        let mut p = min;
        for k in 0..2 {
            let other = (self.axis + 1 + k) % 3;
            p[other] = if self.upper[k] { max[other] } else { min[other] };
        }
        p[self.axis] = value;
        p
    }

    fn is_outline(&self) -> bool {
        self.seen[0] != self.seen[1]
    }
}

/// Adds the box; what is behind the model to `behind`, numbers to the picture.
pub fn add(
    layout: &mut Layout,
    behind: &mut Overlay,
    projector: &Projector,
    bounds: [DVec3; 2],
    format: NumberFormat,
) {
    let [min, max] = bounds;
    let mut color = layout.color;
    color[3] *= 0.8;
    for edge in edges(projector, bounds).filter(|edge| !(edge.seen[0] && edge.seen[1])) {
        let ends = [min, max].map(|end| edge.at(end[edge.axis], bounds));
        if let Some([p, q]) = projector.line(ends[0], ends[1]) {
            behind.fill(Outline::stroke(p, q, layout.line), Paint::Solid(color));
        }
    }
    let Some(middle) = projector.point((min + max) * 0.5) else { return };
    for axis in (0..3).filter(|&axis| min[axis] < max[axis]) {
        let candidates = edges(projector, bounds).filter(|edge| edge.axis == axis && edge.is_outline());
        let seen = candidates.filter_map(|edge| {
            let [p, q] = [min, max].map(|end| projector.point(edge.at(end[axis], bounds)));
            let (p, q) = (p?, q?);
            let [x, y] = [0, 1].map(|k| (p[k] + q[k]) * 0.5 - middle[k]);
            let [dx, dy] = [q[0] - p[0], q[1] - p[1]];
            // Below if it is rather level, at the left if it is rather upright.
            let score = if dx.abs() > dy.abs() { y } else { -x };
            Some((score, edge, p, q))
        });
        let best = seen.max_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((_, edge, p, q)) = best {
            add_numbers(layout, projector, bounds, edge, [p, q], middle, format);
        } else {
            layout.leave_out(&format!("numbers of the {} axis", ["x", "y", "z"][axis]));
        }
    }
}

fn add_numbers(
    layout: &mut Layout,
    projector: &Projector,
    bounds: [DVec3; 2],
    edge: Edge,
    [p, q]: [[f64; 2]; 2],
    middle: [f64; 2],
    format: NumberFormat,
) {
    let (em, axis) = (layout.em * 0.9, edge.axis);
    let [dx, dy] = [q[0] - p[0], q[1] - p[1]];
    let length = (dx * dx + dy * dy).sqrt();
    if !(length > em * 2.0) {
        return layout.leave_out(&format!("numbers of the {} axis", ["x", "y", "z"][axis]));
    }
    // Perpendicular to the edge, away from the middle of the box.
    let mut out = [-dy / length, dx / length];
    let [mx, my] = [(p[0] + q[0]) * 0.5 - middle[0], (p[1] + q[1]) * 0.5 - middle[1]];
    if out[0] * mx + out[1] * my < 0.0 {
        out = out.map(|v| -v);
    }
    // Labels beside each other need more room than labels above each other.
    let across = dx.abs() / length;
    let range = [bounds[0][axis], bounds[1][axis]];
    let most = (length / (em * (1.9 + 3.0 * across))) as usize + 1;
    let numbers = |most: usize| -> Vec<Number> {
        let ticks = ticks::linear(range, most, format).into_iter();
        let at = |tick: &Tick| projector.point(edge.at(tick.value, bounds));
        ticks.filter_map(|tick| Some(Number::of(&tick, at(&tick)?, out, em))).collect()
    };
    // Fewer of them, where they would lie on each other: numbers that are wide, or far behind.
    let are_apart = |numbers: &Vec<Number>| {
        numbers.windows(2).all(|pair| !overlap(&pair[0].rect, &pair[1].rect, em * APART))
    };
    let mut fewer = (2..=most.max(2)).rev().map(&numbers);
    let chosen = fewer.find(are_apart).unwrap_or_else(|| numbers(2));
    let mut boxes: Vec<Rect> = Vec::new();
    let mut reach = 0.0f64;
    for Number { line, at, end, rect, reach: own } in chosen {
        if !is_free(layout, &rect, em) {
            continue;
        }
        layout.overlay.stroke(at, end, layout.line, layout.color);
        layout.overlay.text(&line, [rect[0], rect[3]].map(f64::round), em, Direction::Right, layout.color);
        layout.keep(&format!("number of the {} axis", ["x", "y", "z"][axis]), rect);
        boxes.push(rect);
        reach = reach.max(own);
    }
    if boxes.is_empty() {
        return layout.leave_out(&format!("numbers of the {} axis", ["x", "y", "z"][axis]));
    }
    // The name of the axis, beyond its numbers.
    let name = Line::new(["x", "y", "z"][axis]);
    let distance = em * 1.25 + reach;
    let half = [name.width * em * 0.5, em * CAP_HEIGHT * 0.5];
    for share in [0.5, 0.4, 0.6, 0.25, 0.75] {
        let at = [0, 1].map(|k| p[k] + (q[k] - p[k]) * share + out[k] * distance);
        let rect = [at[0] - half[0], at[1] - half[1], at[0] + half[0], at[1] + half[1]];
        if is_free(layout, &rect, em) {
            let place = [rect[0], rect[3]].map(f64::round);
            layout.overlay.text(&name, place, em, Direction::Right, layout.color);
            layout.keep("name of an axis", rect);
            return;
        }
    }
}

/// The least distance between numbers, and from them to other things, in ems.
const APART: f64 = 0.3;

/// Whether a box is in the picture, apart from what is there.
fn is_free(layout: &Layout, rect: &Rect, em: f64) -> bool {
    let inside = rect[0] >= 1.0
        && rect[1] >= 1.0
        && rect[2] <= layout.size[0] - 1.0
        && rect[3] <= layout.size[1] - 1.0;
    inside && layout.placed.iter().all(|other| !overlap(&other.rect, rect, em * APART))
}

/// A number beside an edge.
struct Number {
    line: Line,
    /// The ends of its mark.
    at: [f64; 2],
    end: [f64; 2],
    rect: Rect,
    /// How far it reaches beyond the marks.
    reach: f64,
}

impl Number {
    /// The number of a tick that is at a point of an edge, with its mark in the direction `out`.
    fn of(tick: &Tick, at: [f64; 2], out: [f64; 2], em: f64) -> Self {
        let end = [at[0] + out[0] * em * 0.45, at[1] + out[1] * em * 0.45];
        let line = Line::new(&tick.label);
        let half = [line.width * em * 0.5, em * CAP_HEIGHT * 0.5];
        // The box of the label touches the line through the ends of the marks.
        let aside = out[0].abs() * half[0] + out[1].abs() * half[1];
        let distance = em * 0.25 + aside;
        let center = [end[0] + out[0] * distance, end[1] + out[1] * distance];
        let rect = [center[0] - half[0], center[1] - half[1], center[0] + half[0], center[1] + half[1]];
        Self { line, at, end, rect, reach: distance + aside }
    }
}
