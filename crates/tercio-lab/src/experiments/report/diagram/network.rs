//! Networks between two columns of a diagram, by their shape, and what lies inside a column.

use std::f64::consts::PI;

use glam::{DVec2, dvec2};
use tercio::vector::{Cap, Shape, Style};

use super::ROWS;
use crate::machines::Topology;

/// Half the width of a network's drawing.
const HALF: f64 = 17.0;
/// It reaches that far beyond the first and the last line.
const BEYOND: f64 = 14.0;
/// Levels of a tree that are drawn.
const LEVELS: u32 = 4;

fn lines(shapes: &mut Vec<Shape>, color: [u8; 4], width: f64, lines: Vec<Vec<DVec2>>) {
    shapes.push(Shape::Lines { style: Style { color, width, cap: Cap::Round }, lines });
}

/// A network between boxes whose edges are at `left` and `right`, at heights `from` and `to`.
pub(super) fn push(
    shapes: &mut Vec<Shape>,
    topology: Topology,
    color: [u8; 4],
    [left, right]: [f64; 2],
    [from, to]: [&[f64]; 2],
) {
    if topology == Topology::Crossbar {
        let pairs = from.iter().flat_map(|&a| to.iter().map(move |&b| [a, b]));
        return super::join(shapes, color, pairs.map(|[a, b]| [dvec2(left, a), dvec2(right, b)]));
    }
    let middle = 0.5 * (left + right);
    let both = || from.iter().chain(to).copied();
    let (top, bottom) = (both().fold(f64::INFINITY, f64::min), both().fold(f64::NEG_INFINITY, f64::max));
    let half = if topology == Topology::Bus { 0.0 } else { HALF };
    let tap = |x: f64, edge: f64, y: &f64| vec![dvec2(edge, *y), dvec2(x, *y)];
    let mut taps: Vec<_> = from.iter().map(|y| tap(middle - half, left + 3.0, y)).collect();
    taps.extend(to.iter().map(|y| tap(middle + half, right - 3.0, y)));
    lines(shapes, color, 1.3, taps);
    let (above, below) = (top - BEYOND, bottom + BEYOND);
    match topology {
        Topology::Bus => lines(shapes, color, 4.0, vec![vec![dvec2(middle, above), dvec2(middle, below)]]),
        Topology::Ring => lines(shapes, color, 2.2, vec![stadium(middle, above, below)]),
        Topology::Memory => lines(shapes, color, 2.2, vec![rectangle(middle, HALF, above, below)]),
        Topology::FatTree => fat_tree(shapes, color, middle, from, to),
        Topology::Mesh => grid(shapes, color, middle, [above, below], false),
        Topology::Torus => grid(shapes, color, middle, [above, below], true),
        Topology::Crossbar => {}
    }
}

/// Two parallel lines with half circles at their ends.
fn stadium(middle: f64, top: f64, bottom: f64) -> Vec<DVec2> {
    let arc = |center: f64, from: f64| {
        (0..=12)
            .map(move |k| dvec2(middle, center) + HALF * DVec2::from_angle(from + PI * f64::from(k) / 12.0))
    };
    let mut points: Vec<_> = arc(top + HALF * 0.6, PI).chain(arc(bottom - HALF * 0.6, 0.0)).collect();
    points.push(points[0]);
    points
}

fn rectangle(middle: f64, half: f64, top: f64, bottom: f64) -> Vec<DVec2> {
    let [left, right] = [middle - half, middle + half];
    vec![dvec2(left, top), dvec2(right, top), dvec2(right, bottom), dvec2(left, bottom), dvec2(left, top)]
}

/// The way up to the root and down again: links to the root are wider.
fn fat_tree(shapes: &mut Vec<Shape>, color: [u8; 4], middle: f64, from: &[f64], to: &[f64]) {
    let root = dvec2(middle, ROWS[0][0]);
    let side = |x: f64, rows: &[f64]| rows.iter().map(|&y| vec![dvec2(x, y), root]).collect::<Vec<_>>();
    lines(shapes, color, 3.0, [side(middle - HALF, from), side(middle + HALF, to)].concat());
    lines(shapes, color, 1.3, vec![rectangle(root.x, 6.0, root.y - 6.0, root.y + 6.0)]);
}

/// A grid; its rows and columns are rings if it is a torus.
fn grid(shapes: &mut Vec<Shape>, color: [u8; 4], middle: f64, [top, bottom]: [f64; 2], wraps: bool) {
    let x = [-1.0, 0.0, 1.0].map(|k| middle + k * HALF);
    let y = [0.0, 0.5, 1.0].map(|k| top + k * (bottom - top));
    let mut all: Vec<_> = x.iter().map(|&x| vec![dvec2(x, top), dvec2(x, bottom)]).collect();
    all.extend(y.iter().map(|&y| vec![dvec2(x[0], y), dvec2(x[2], y)]));
    lines(shapes, color, 1.6, all);
    if !wraps {
        return;
    }
    // From each end back to the other one, beside the line.
    let bow = |a: DVec2, b: DVec2, aside: DVec2| {
        let point = move |k: u32| {
            let t = f64::from(k) / 10.0;
            a.lerp(b, t) + (PI * t).sin() * aside
        };
        (0..=10).map(point).collect::<Vec<_>>()
    };
    let mut back: Vec<_> = y.iter().map(|&y| bow(dvec2(x[0], y), dvec2(x[2], y), dvec2(0.0, -7.0))).collect();
    back.extend(x.iter().map(|&x| bow(dvec2(x, top), dvec2(x, bottom), dvec2(6.0, 0.0))));
    lines(shapes, color, 0.8, back);
}

/// Arrows from point to point.
pub(super) fn arrows(shapes: &mut Vec<Shape>, color: [u8; 4], ends: impl Iterator<Item = [DVec2; 2]>) {
    let all = ends.flat_map(|[from, to]| {
        let back = (from - to).normalize_or_zero() * 5.0;
        [vec![from, to], vec![to + back + back.perp() * 0.7, to, to + back - back.perp() * 0.7]]
    });
    lines(shapes, color, 1.3, all.collect());
}

/// Levels of a binary tree of so many nodes that are drawn.
fn levels(nodes: u64) -> u32 {
    (u64::BITS - nodes.leading_zeros()).clamp(1, LEVELS)
}

/// Nodes of a level have these heights.
fn level(k: u32) -> impl Iterator<Item = f64> {
    let [top, bottom] = [ROWS[2][0] - 17.0, ROWS[2][2] + 17.0];
    let of = 1u32 << k;
    (0..of).map(move |i| top + (bottom - top) * (f64::from(i) + 0.5) / f64::from(of))
}

/// Heights of the leaves of a binary tree of so many nodes.
pub(super) fn leaves(nodes: u64) -> Vec<f64> {
    level(levels(nodes) - 1).collect()
}

/// A binary tree of so many nodes: the first levels of it.
pub(super) fn splitters(shapes: &mut Vec<Shape>, nodes: u64, [left, right]: [f64; 2], color: [u8; 4]) {
    let levels = levels(nodes);
    let size = 5.0;
    let x = |k: u32| match levels {
        1 => 0.5 * (left + right),
        _ => left + size + (right - left - 2.0 * size) * f64::from(k) / f64::from(levels - 1),
    };
    let (mut branches, mut squares) = (Vec::new(), Vec::new());
    for k in 0..levels {
        let parents: Vec<_> = if k > 0 { level(k - 1).collect() } else { Vec::new() };
        for (i, y) in level(k).enumerate() {
            if let Some(&parent) = parents.get(i / 2) {
                branches.push(vec![dvec2(x(k - 1) + size, parent), dvec2(x(k) - size, y)]);
            }
            squares.push(rectangle(x(k), size, y - size, y + size));
        }
    }
    lines(shapes, color, 1.3, branches);
    lines(shapes, super::INK, 1.2, squares);
}
