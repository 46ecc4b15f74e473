//! Machines as diagrams: their stages, where work is sorted between processors, and what travels.

mod columns;
mod engine;
mod network;
#[cfg(test)]
mod tests;

use glam::{DVec2, dvec2};
use tercio::vector::{Anchor, Cap, Page, Shape, Style, Text, VectorFormat, text_width};

use columns::{Column, Link, columns};

use crate::machines::{Arrangement, Machine};

/// Size of the pipeline of tile engines.
const SIZE: DVec2 = dvec2(760.0, 210.0);
/// Height of all other diagrams, and their least width.
const HEIGHT: f64 = 224.0;
const WIDTH: f64 = 760.0;
const INK: [u8; 4] = [25, 25, 25, 255];
const SORT: [u8; 4] = [225, 60, 120, 255];
const FONT: f64 = 12.0;
const BOX_HEIGHT: f64 = 34.0;
/// Middles of the rows of a column with one, two or three boxes.
const ROWS: [&[f64]; 3] = [&[123.0], &[95.0, 151.0], &[79.0, 123.0, 167.0]];

/// A machine as an element `svg`.
pub(super) fn svg(machine: &Machine) -> String {
    let text = String::from_utf8(page(machine).to_bytes(VectorFormat::Svg)).unwrap_or_default();
    text.split_once('\n').map_or(String::new(), |(_, element)| element.to_owned())
}

fn page(machine: &Machine) -> Page {
    let mut page = Page { size: SIZE.to_array(), background: None, shapes: Vec::new() };
    if let (Some(heap), Some(engine)) = (&machine.heap, &machine.tile_engine) {
        engine::push(&mut page.shapes, machine, heap, engine);
        return page;
    }
    let columns = columns(machine);
    let (width, gap) = match columns.len() {
        0..=4 => (108.0, 97.0),
        5 => (100.0, 70.0),
        _ => (92.0, 66.0),
    };
    let all = columns.len() as f64 * (width + gap) - gap;
    page.size = [WIDTH.max(all + 20.0), HEIGHT];
    let left = 0.5 * (page.size[0] - all);
    let sides: Vec<_> = (0..columns.len())
        .map(|i| left + i as f64 * (width + gap))
        .map(|left| [left, left + width])
        .collect();
    for (column, &sides) in columns.iter().zip(&sides) {
        push_column(&mut page.shapes, column, sides, width + gap - 8.0);
    }
    for (pair, sides) in columns.windows(2).zip(sides.windows(2)) {
        let [from, to] = pair else { continue };
        push_link(&mut page.shapes, from, to, [sides[0][1], sides[1][0]], width + gap - 8.0);
    }
    page
}

/// A column: what its boxes are, how many there are, and at most three of them.
fn push_column(shapes: &mut Vec<Shape>, column: &Column, [left, right]: [f64; 2], room: f64) {
    let middle = 0.5 * (left + right);
    fitting(shapes, &column.title, FONT, dvec2(middle, 20.0), INK, room);
    fitting(shapes, &column.note, FONT - 1.5, dvec2(middle, 36.0), INK, room);
    if column.arrangement == Arrangement::Tree {
        return network::splitters(shapes, column.count, [left, right], column.color());
    }
    let rows = column.rows();
    for (label, &y) in column.labels.iter().zip(rows) {
        outline(shapes, dvec2(left, y - 0.5 * BOX_HEIGHT), dvec2(right - left, BOX_HEIGHT), label);
    }
    let skips = column.units() > 3;
    if let (true, [.., above, below]) = (skips, rows) {
        // Beside the arrow of a pipeline.
        let x = if column.arrangement == Arrangement::Pipeline { middle + 14.0 } else { middle };
        text(shapes, "...", FONT, dvec2(x, 0.5 * (above + below) + 1.0), INK);
    }
    if column.arrangement == Arrangement::Pipeline {
        let ends = rows.windows(2).map(|pair| [pair[0], pair[1]].map(|y| dvec2(middle, y)));
        let inset = dvec2(0.0, 0.5 * BOX_HEIGHT);
        network::arrows(shapes, column.color(), ends.map(|[a, b]| [a + inset, b - inset]));
    }
}

/// What lies between two columns.
fn push_link(shapes: &mut Vec<Shape>, from: &Column, to: &Column, [left, right]: [f64; 2], room: f64) {
    let color = to.color();
    match &to.link {
        Link::Over { topology, in_groups } => {
            let (a, b) = (from.outputs(), to.inputs());
            // From each row to the one behind the last.
            let groups: &[[usize; 2]] =
                if *in_groups && a.len() == 3 && b.len() == 3 { &[[0, 2], [2, 3]] } else { &[[0, 3]] };
            for &[first, end] in groups {
                let part = |y: &[f64]| y[first.min(y.len())..end.min(y.len())].to_vec();
                network::push(shapes, *topology, color, [left, right], [&part(&a), &part(&b)]);
            }
        }
        Link::Own | Link::All => {
            let ends = columns::joined(from, to).into_iter();
            join(shapes, color, ends.map(|[a, b]| [dvec2(left, a), dvec2(right, b)]));
        }
    }
    let at = 0.5 * (left + right);
    if to.sorted {
        text(shapes, "sort", FONT, dvec2(at, 52.0), SORT);
    }
    if let Some(what) = &to.receives {
        fitting(shapes, what, FONT - 1.0, dvec2(at, 203.0), color, room);
    }
    if let Some(way) = &to.way {
        fitting(shapes, way, FONT - 1.5, dvec2(at, 218.0), color, room);
    }
}

/// Lines from the right edges of boxes to the left edges of others.
fn join(shapes: &mut Vec<Shape>, color: [u8; 4], ends: impl Iterator<Item = [DVec2; 2]>) {
    let gap = dvec2(3.0, 0.0);
    let lines = ends.map(|[from, to]| vec![from + gap, to - gap]).collect();
    shapes.push(Shape::Lines { style: Style { color, width: 1.3, cap: Cap::Round }, lines });
}

fn outline(shapes: &mut Vec<Shape>, low: DVec2, size: DVec2, label: &str) {
    let high = low + size;
    let line = vec![low, dvec2(high.x, low.y), high, dvec2(low.x, high.y), low];
    shapes
        .push(Shape::Lines { style: Style { color: INK, width: 1.2, cap: Cap::Square }, lines: vec![line] });
    // Large numbers of processors are long.
    let font = FONT.min(FONT * (size.x - 8.0) / text_width(label, FONT)).min(0.8 * size.y);
    text(shapes, label, font, low + dvec2(0.5 * size.x, 0.5 * size.y + 0.36 * font), INK);
}

fn text(shapes: &mut Vec<Shape>, text: &str, size: f64, at: DVec2, color: [u8; 4]) {
    shapes.push(Shape::Text(Text {
        color,
        size,
        at,
        anchor: Anchor::Middle,
        upwards: false,
        text: text.into(),
    }));
}

/// A text, smaller if it is wider than the room for it.
fn fitting(shapes: &mut Vec<Shape>, words: &str, size: f64, at: DVec2, color: [u8; 4], room: f64) {
    if !words.is_empty() {
        let size = size.min(size * room / text_width(words, size));
        text(shapes, words, size, at, color);
    }
}
