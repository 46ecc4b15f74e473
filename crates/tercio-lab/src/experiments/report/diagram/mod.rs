//! Machines as diagrams: their stages, where work is sorted between processors, and what travels.

mod engine;

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
        // What document 001, 2.3.4, calls hybrid: sort-middle and sort-last in one. Those with tile engines are drawn as such.
        SortingClass::Hybrid => [Straight, Sorted(DataKind::Descriptor), Sorted(DataKind::Sample)],
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
    if let (Some(heap), Some(engine)) = (&machine.heap, &machine.tile_engine) {
        engine::push(shapes, machine, heap, engine);
        return page;
    }
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
            outline(shapes, dvec2(left, y), BOX, &label);
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
        join(shapes, color, lines.map(|(a, b)| [dvec2(from, y(a)), dvec2(to, y(b))]));
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
                // The engines' triangles are sorted into the tiles of a heap.
                SortingClass::Hybrid => {
                    if machine.tile_engine.is_some() {
                        1
                    } else {
                        2
                    }
                }
            };
            assert_eq!(element.matches(">sort</text>").count(), sorts, "{name}");
        }
        let ring = svg(&load("princeton-engine").unwrap());
        assert!(ring.contains("descriptors, 84 B each") && ring.contains("processor 1024"));
        assert!(!ring.contains("pixels, "));
    }

    #[test]
    fn the_stages_and_queues_of_tile_engines_are_drawn() {
        let element = |name: &str| svg(&load(name).unwrap());
        let count = |name: &str, label: &str| element(name).matches(&format!(">{label}</text>")).count();
        for stage in
            ["front end", "triangle heap", "set-up triangle", "draw triangle", "set-up span", "draw span"]
        {
            assert_eq!(count("hybris-asic", stage), 1, "{stage}");
        }
        // Four stages and a tile buffer for each engine; two lanes of two stages and two spans each in the 2x2 engine.
        assert_eq!((count("hybris-asic", "engine 1"), count("hybris-asic-two-engines", "engine 2")), (5, 5));
        assert_eq!((count("hybris-asic-2x2", "odd lines"), count("hybris-asic-2x2", "odd pixels")), (2, 2));
        assert_eq!(
            (count("hybris-asic", "queue of 16"), count("hybris-asic-2x2", "queues of 16 and 4")),
            (2, 2)
        );
        assert_eq!((count("hybris-fpga", "register"), count("hybris-fpga", "bus, 100 MB/s")), (2, 1));
        assert_eq!((count("hybris-dual-cpu", "heap 2"), count("hybris-dual-cpu", "processor 2")), (1, 6));
        assert_eq!(count("hybris-single-cpu", "register"), 0, "nested loops have no queues");
    }
}
