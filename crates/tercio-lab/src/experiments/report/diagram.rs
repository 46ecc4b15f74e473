//! Machines as diagrams: their stages, where work is sorted between processors, and what travels.

use glam::{DVec2, dvec2};
use tercio::vector::{Anchor, Cap, Page, Shape, Style, Text, VectorFormat, text_width};

use crate::machines::{DataKind, Machine, SortingClass};

const SIZE: DVec2 = dvec2(760.0, 210.0);
const INK: [u8; 4] = [25, 25, 25, 255];
const SORT: [u8; 4] = [225, 60, 120, 255];
const BOX: DVec2 = dvec2(108.0, 34.0);
const FONT: f64 = 12.0;
/// Left edges of the stages: what comes in, geometry, rasterization, picture.
const STAGES: [(&str, f64); 4] =
    [("polygons", 10.0), ("geometry", 215.0), ("rasterization", 420.0), ("picture", 640.0)];
/// Rows of the processors that are drawn.
const ROWS: [f64; 3] = [62.0, 106.0, 150.0];

/// What lies between two stages.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Link {
    /// Data stay on their processor.
    Straight,
    /// Every processor sends to every other one.
    Sorted(DataKind),
    /// Sorted between the processors of a group only.
    InGroups(DataKind),
}

/// What lies after polygons, geometry and rasterization.
fn links(class: SortingClass) -> [Link; 3] {
    use Link::{InGroups, Sorted, Straight};
    match class {
        SortingClass::None => [Straight; 3],
        SortingClass::SortFirst => [Sorted(DataKind::Primitive), Straight, Straight],
        SortingClass::SortMiddle => [Straight, Sorted(DataKind::Descriptor), Straight],
        SortingClass::SortLast => [Straight, Straight, Sorted(DataKind::Sample)],
        SortingClass::SortTwice => [Straight, InGroups(DataKind::Descriptor), Sorted(DataKind::Sample)],
        SortingClass::Hybrid => {
            [Sorted(DataKind::Primitive), Sorted(DataKind::Descriptor), Sorted(DataKind::Sample)]
        }
    }
}

/// A machine as an element `svg`.
pub(super) fn svg(machine: &Machine) -> String {
    let text = String::from_utf8(page(machine).to_bytes(VectorFormat::Svg)).unwrap_or_default();
    text.split_once('\n').map_or(String::new(), |(_, element)| element.to_owned())
}

fn page(machine: &Machine) -> Page {
    let mut page = Page { size: SIZE.to_array(), background: None, shapes: Vec::new() };
    let shapes = &mut page.shapes;
    let processors = machine.processors.count.whole();
    let rows = &ROWS[..(processors.min(3) as usize).max(1)];
    let links = links(machine.sorting.class);
    for (stage, (name, left)) in STAGES.into_iter().enumerate() {
        let middle = left + 0.5 * BOX.x;
        text(shapes, name, FONT, dvec2(middle, 24.0), INK);
        for (i, &y) in rows.iter().enumerate() {
            // With many processors the last row stands for all that are not drawn.
            let number = if i == 2 && processors > 3 { processors } else { i as u64 + 1 };
            let label = match stage {
                0 => format!("share {number}"),
                1 | 2 => format!("processor {number}"),
                _ => format!("part {number}"),
            };
            outline(shapes, dvec2(left, y), &label);
        }
        if processors > 3 {
            text(shapes, "...", FONT, dvec2(middle, 0.5 * (ROWS[1] + ROWS[2]) + 21.0), INK);
        }
    }
    for (i, link) in links.into_iter().enumerate() {
        let (from, to) = (STAGES[i].1 + BOX.x, STAGES[i + 1].1);
        let pairs = (0..rows.len()).flat_map(|a| (0..rows.len()).map(move |b| (a, b)));
        let joined = |a: usize, b: usize| match link {
            Link::Straight => a == b,
            Link::Sorted(_) => true,
            Link::InGroups(_) => a == b || (a < 2 && b < 2),
        };
        let color = if link == Link::Straight { INK } else { SORT };
        let y = |row: usize| rows[row] + 0.5 * BOX.y;
        let lines = pairs.filter(|&(a, b)| joined(a, b));
        let lines = lines.map(|(a, b)| vec![dvec2(from + 3.0, y(a)), dvec2(to - 3.0, y(b))]).collect();
        shapes.push(Shape::Lines { style: Style { color, width: 1.3, cap: Cap::Round }, lines });
        if let Link::Sorted(kind) | Link::InGroups(kind) = link {
            let at = 0.5 * (from + to);
            text(shapes, "sort", FONT, dvec2(at, 42.0), SORT);
            text(shapes, &travelling(machine, kind), FONT - 1.0, dvec2(at, 198.0), SORT);
        }
    }
    page
}

/// What travels, with its size if the description gives it.
fn travelling(machine: &Machine, kind: DataKind) -> String {
    let what = match kind {
        DataKind::Primitive => "polygons",
        DataKind::Descriptor => "descriptors",
        DataKind::Sample | DataKind::Pixel => "pixels",
    };
    machine.bytes.get(&kind).map_or(what.into(), |size| format!("{what}, {size} each"))
}

fn outline(shapes: &mut Vec<Shape>, low: DVec2, label: &str) {
    let high = low + BOX;
    let line = vec![low, dvec2(high.x, low.y), high, dvec2(low.x, high.y), low];
    shapes
        .push(Shape::Lines { style: Style { color: INK, width: 1.2, cap: Cap::Square }, lines: vec![line] });
    // Large numbers of processors are long.
    let size = FONT.min(FONT * (BOX.x - 8.0) / text_width(label, FONT));
    text(shapes, label, size, low + dvec2(0.5 * BOX.x, 0.5 * BOX.y + 0.36 * size), INK);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machines::{NAMES, load};

    #[test]
    fn every_machine_is_sorted_where_its_class_says_and_what_travels_is_named() {
        for name in NAMES {
            let machine = load(name).unwrap();
            let element = svg(&machine);
            assert!(element.starts_with("<svg") && element.trim_end().ends_with("</svg>"), "{name}");
            let sorts = match machine.sorting.class {
                SortingClass::None => 0,
                SortingClass::SortFirst | SortingClass::SortMiddle | SortingClass::SortLast => 1,
                SortingClass::SortTwice => 2,
                SortingClass::Hybrid => 3,
            };
            assert_eq!(element.matches(">sort</text>").count(), sorts, "{name}");
        }
        let ring = svg(&load("princeton-engine").unwrap());
        assert!(ring.contains("descriptors, 84 B each") && ring.contains("processor 1024"));
        assert!(!ring.contains("pixels, "));
    }
}
