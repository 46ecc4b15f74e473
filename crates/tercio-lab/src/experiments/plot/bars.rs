//! Bars of categories.

use glam::{DVec2, dvec2};
use tercio::vector::{Anchor, Cap, Shape, Style};

use super::label;
use super::symbols::hatching;

/// Share of a category's place that its bars fill.
pub(super) const FILLED: f64 = 0.8;

/// A bar with the corners `low` and `high`: ours is filled, published ones are hatched.
pub(super) fn push_bar(
    shapes: &mut Vec<Shape>,
    look: usize,
    color: [u8; 4],
    published: bool,
    low: DVec2,
    high: DVec2,
) {
    let corners = vec![low, dvec2(high.x, low.y), high, dvec2(low.x, high.y)];
    let outline = corners.iter().copied().chain([low]).collect();
    if published {
        shapes.push(Shape::Area { color: [255; 4], polygons: vec![corners] });
        let style = Style { color, width: 1.2, cap: Cap::Square };
        shapes.push(Shape::Lines { style, lines: hatching(look, low, high) });
    } else {
        shapes.push(Shape::Area { color, polygons: vec![corners] });
    }
    let style = Style { color, width: 1.2, cap: Cap::Square };
    shapes.push(Shape::Lines { style, lines: vec![outline] });
}

/// The mark of a bar whose value is not known.
pub(super) fn push_gap(shapes: &mut Vec<Shape>, size: f64, foot: DVec2) {
    label::push(shapes, "?", size, foot - dvec2(0.0, 4.0), Anchor::Middle, false);
}
